// Completion: the loop over octants, and full sampling.
#include "core/many_lights/completion.h"

#include "core/many_lights/tracer.h"

namespace core::many_lights {

namespace {

/// Counts the columns and drops those without a row that matters.
std::vector<uint32_t> activeColumns(Tracer& tracer, ColumnRange octant)
{
    std::vector<uint32_t> columns;
    columns.reserve(octant.end - octant.begin);
    for (uint32_t j = octant.begin; j < octant.end; ++j) {
        const uint32_t count = countBits(tracer.matters(j));
        tracer.stats().active += count;
        if (count > 0) columns.push_back(j);
    }
    tracer.stats().inactive += octant.end - octant.begin - static_cast<uint32_t>(columns.size());
    return columns;
}

void traceAll(Tracer& tracer, std::span<const uint32_t> columns, BitMatrix& visible)
{
    for (const uint32_t j : columns) tracer.trace(j, tracer.matters(j), visible.column(j));
    tracer.stats().full += static_cast<uint32_t>(columns.size());
}

}  // namespace

CompletionStats& CompletionStats::operator+=(const CompletionStats& other)
{
    entries += other.entries;
    active += other.active;
    rays += other.rays;
    columns += other.columns;
    inactive += other.inactive;
    full += other.full;
    traceSeconds += other.traceSeconds;
    seconds += other.seconds;
    return *this;
}

void complete(VisibilityOracle& oracle, uint32_t rows, std::span<const ColumnRange> octants,
              const CompletionParams& params, uint64_t seed, CompletedSlice& out)
{
    const Clock::time_point start = Clock::now();
    uint32_t columns = 0;
    for (const ColumnRange& octant : octants) {
        CHECK(octant.begin == columns && octant.end >= octant.begin);
        columns = octant.end;
    }
    out.visible.reset(rows, columns);
    out.stats = {};
    out.stats.entries = uint64_t(rows) * columns;
    out.stats.columns = columns;
    if (rows == 0) return;
    Tracer tracer(oracle, rows, params.dontCare, out.stats);
    for (const ColumnRange& octant : octants)
        traceAll(tracer, activeColumns(tracer, octant), out.visible);
    (void)seed;
    out.stats.seconds = secondsSince(start);
}

}  // namespace core::many_lights
