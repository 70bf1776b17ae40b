// Completion: the loop over octants, and full sampling.
#include "core/completion/completion.h"

#include "core/completion/amc.h"
#include "core/completion/gauss_jordan.h"
#include "core/completion/matching.h"
#include "core/completion/svt.h"

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
    tracer.stats().authorRays += uint64_t(visible.rows()) * columns.size();
}

}  // namespace

uint64_t octantSeed(uint64_t seed, size_t octant)
{
    // The finalizer of G. Steele, D. Lea, C. Flood, "Fast Splittable Pseudorandom Number
    // Generators" (2014), twice: neighbouring seeds give unrelated sequences.
    const auto mix = [](uint64_t x) {
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
        return x ^ (x >> 31);
    };
    return mix(seed ^ mix(octant + 1));
}

CompletionStats& CompletionStats::operator+=(const CompletionStats& other)
{
    entries += other.entries;
    active += other.active;
    rays += other.rays;
    authorRays += other.authorRays;
    columns += other.columns;
    inactive += other.inactive;
    full += other.full;
    bailedOut += other.bailedOut;
    matched += other.matched;
    repaired += other.repaired;
    basis += other.basis;
    verificationFailures += other.verificationFailures;
    ambiguous += other.ambiguous;
    rated += other.rated;
    rates += other.rates;
    traceSeconds += other.traceSeconds;
    seconds += other.seconds;
    return *this;
}

void complete(VisibilityOracle& oracle, uint32_t rows, std::span<const ColumnRange> octants,
              const CompletionParams& params, uint64_t seed, CompletedSlice& out,
              const std::stop_token& stop)
{
    const Clock::time_point start = Clock::now();
    uint32_t columns = 0;
    for (const ColumnRange& octant : octants) {
        CHECK(octant.begin == columns && octant.end >= octant.begin);
        columns = octant.end;
    }
    out.visible.reset(rows, columns);
    const bool real = givesNumbers(params.method) && params.coefficients != Coefficients::bits;
    out.coefficients.assign(real ? size_t(rows) * columns : 0, 0.0f);
    out.residual.clear();
    out.stats = {};
    out.stats.entries = uint64_t(rows) * columns;
    out.stats.columns = columns;
    if (rows == 0) return;
    Tracer tracer(oracle, rows, params.dontCare, out.stats);
    const bool full = params.method == CompletionMethod::full || rows <= params.smallSlice;
    for (size_t o = 0; o < octants.size(); ++o) {
        const std::vector<uint32_t> active = activeColumns(tracer, octants[o]);
        if (active.empty()) continue;
        const uint64_t octant = octantSeed(seed, o);
        if (full)
            traceAll(tracer, active, out.visible);
        else if (params.method == CompletionMethod::matching)
            MatchingOctant(tracer, active, params, octant, out).run();
        else if (params.method == CompletionMethod::gaussJordan)
            GaussJordanOctant(tracer, active, params, octant, out).run();
        else if (params.method == CompletionMethod::svt)
            SvtOctant(tracer, active, params, octant, out).run(stop);
        else
            AmcOctant(tracer, active, params, octant, out).run();
    }
    if (full && !out.coefficients.empty())
        for (uint32_t j = 0; j < columns; ++j)
            bitsToFloats(out.visible.column(j), {&out.coefficients[size_t(j) * rows], rows});
    out.stats.seconds = secondsSince(start);
}

}  // namespace core::many_lights
