// Ways of lighting a slice that do not choose columns for all its receivers together: each receiver
// or group of receivers has lights of its own.
#pragma once

#include <algorithm>
#include <stop_token>

#include "core/many_lights/slice_job.h"

namespace core::many_lights {

class SliceLighter {
public:
    virtual ~SliceLighter() = default;

    /// Writes what the receivers that `chosen` lists send towards where they are seen from, their
    /// throughput left out, and adds to `stats` what it took. In statistics an entry is a pair of
    /// receiver and light that is shaded. False when `stop` came in between. The same for any
    /// number of threads, which may call it at the same time.
    virtual bool light(const SliceJob& job, std::span<const Receiver> receivers,
                       std::span<const uint32_t> chosen, uint32_t slice,
                       const std::stop_token& stop, std::span<glm::vec3> radiance,
                       SliceStats& stats) const = 0;
};

/// Adds a slice that was lit by so many pairs of receiver and light and that many shadow rays.
inline void countPairs(SliceStats& stats, size_t receivers, uint64_t pairs, uint64_t rays)
{
    ++stats.slices;
    stats.rows += receivers;
    stats.clusters += pairs / std::max<size_t>(receivers, 1);
    stats.completion.entries += pairs;
    stats.completion.active += pairs;
    stats.completion.rays += rays;
    stats.completion.authorRays += rays;
}

}  // namespace core::many_lights
