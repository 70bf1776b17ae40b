// Slices: receivers that lie close together and face alike, for which one set of clustered lights
// will do.
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "core/many_lights/receivers.h"

namespace core::many_lights {

struct SliceSettings {
    float normalScale = 0.05f;  // length that stands for a unit of the normals, in metres
    uint32_t threshold = 1000;  // receivers from which a set is split; slices hold less than twice
    uint32_t smallest = 10;     // that a split may leave on a side
};

struct Slices {
    std::vector<uint32_t> order;     // indices of receivers, slice by slice
    std::vector<IndexRange> ranges;  // of `order`, one per slice, adjacent
};

/// The leaves of a kd-tree over position and normal (6 dimensions): the widest extent is split in
/// its middle. S. Wang, "Efficient Sample Usage in Photo-Realistic Rendering" (2022), 5.3, after Ou
/// and Pellacini, "LightSlice" (2011). Within a slice receivers keep their order. Sets that a split
/// would leave lopsided are halved by order while they hold more than twice the threshold. Without
/// meaning once `stop` is requested.
Slices makeSlices(std::span<const Receiver> receivers, const SliceSettings& settings,
                  const std::stop_token& stop = {});

}  // namespace core::many_lights
