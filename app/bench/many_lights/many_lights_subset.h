// A random part of a frame that stands for all of it: some slices, whatever their size, and the
// pixels that they lie in.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/many_lights/frame.h"

namespace app::many_lights {

struct Subset {
    std::vector<uint8_t> places;   // 1: belongs to it; receivers stand at places (receivers.h)
    std::vector<uint32_t> pixels;  // that have any such place, ascending
    uint32_t perPixel = 1;         // places
    size_t receivers = 0, slices = 0;
};

/// How much of a frame.
struct SubsetSize {
    std::optional<double> share;  // of the slices; absent: until there are `receivers`
    size_t receivers = 0;
};

/// Slices of `points` drawn at random, at least one. A share of 1 has every place of the picture,
/// those without a receiver too.
Subset randomSubset(const core::many_lights::FrameReceivers& points, uint32_t perPixel,
                    const SubsetSize& size, uint32_t seed);

/// The slices with a receiver in the pixels corner <= p < corner + size of a picture of that width.
Subset subsetAround(const core::many_lights::FrameReceivers& points, uint32_t perPixel,
                    uint32_t width, glm::uvec2 corner, glm::uvec2 size);

/// Marks the slices that hold places of the subset. Slices of another size may hold others, too.
std::vector<uint8_t> slicesOf(const core::many_lights::FrameReceivers& points,
                              const Subset& subset);

/// The mean over the places of each pixel that belong to the subset.
std::vector<glm::vec3> valuesOf(std::span<const glm::vec3> radiance, const Subset& subset);

}  // namespace app::many_lights
