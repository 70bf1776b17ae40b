// Pictures of renderers that only pretend.
#pragma once

#include <algorithm>

#include "core/methods/renderer.h"

namespace tests {

/// Every pixel has had `samples` of this mean and of this variance of the mean.
inline core::Estimate flatEstimate(glm::uvec2 size, float mean, float variance, uint64_t samples)
{
    core::Estimate e;
    e.mean = core::Image(size.x, size.y, 3);
    e.variance = core::Image(size.x, size.y, 3);
    e.weight = core::Image(size.x, size.y, 1);
    std::fill(e.mean.pixels.begin(), e.mean.pixels.end(), mean);
    std::fill(e.variance.pixels.begin(), e.variance.pixels.end(), variance);
    std::fill(e.weight.pixels.begin(), e.weight.pixels.end(), static_cast<float>(samples));
    e.samples = samples;
    return e;
}

}  // namespace tests
