// The oracle as the ways of completion see it: rows that matter, rays counted, time measured.
#pragma once

#include "core/base/time.h"
#include "core/completion/bits.h"
#include "core/completion/completion.h"

namespace core::many_lights {

class Tracer {
public:
    /// Everything is kept by reference. `dontCare` false: all rows matter, whatever the oracle
    /// says.
    Tracer(VisibilityOracle& oracle, uint32_t rows, bool dontCare, CompletionStats& stats)
        : oracle_(oracle), dontCare_(dontCare), stats_(stats), all_(wordsFor(rows))
    {
        for (size_t w = 0; w < all_.size(); ++w) all_[w] = wordOfRows(rows, w);
    }

    /// The mask of the rows of a column that matter.
    std::span<const uint64_t> matters(uint32_t column) const
    {
        const uint64_t* mask = dontCare_ ? oracle_.matters(column) : nullptr;
        return {mask != nullptr ? mask : all_.data(), all_.size()};
    }
    std::optional<float> brightness(uint32_t column) const { return oracle_.brightness(column); }
    std::span<const uint64_t> all() const { return all_; }

    /// Traces requests, which ask for each row once. Returns the rays.
    uint32_t trace(std::span<const TraceRequest> requests)
    {
        ask(requests);
        uint32_t rays = 0;
        for (const TraceRequest& request : requests) rays += countBits({request.rows, all_.size()});
        stats_.rays += rays;
        return rays;
    }
    uint32_t trace(uint32_t column, std::span<const uint64_t> rows, std::span<uint64_t> visible)
    {
        const TraceRequest request{column, rows.data(), visible.data()};
        return trace({&request, 1});
    }
    /// The same, of so many rows.
    void trace(uint32_t column, std::span<const uint64_t> rows, std::span<uint64_t> visible,
               uint32_t count)
    {
        const TraceRequest request{column, rows.data(), visible.data()};
        ask({&request, 1});
        stats_.rays += count;
    }

    CompletionStats& stats() { return stats_; }

private:
    void ask(std::span<const TraceRequest> requests)
    {
        const Clock::time_point start = Clock::now();
        oracle_.trace(requests);
        stats_.traceSeconds += secondsSince(start);
    }

    VisibilityOracle& oracle_;
    bool dontCare_;
    CompletionStats& stats_;
    Words all_;
};

}  // namespace core::many_lights
