// What a renderer has found so far: per pixel the sum and the sum of squares of its samples,
// compensated (Kahan), and the count of samples that were dropped because they were not finite.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "core/image/image.h"

namespace core {

struct FilmCounters {
    uint64_t nan = 0, inf = 0, negative = 0, stackOverflow = 0;
    bool clean() const { return nan + inf + negative + stackOverflow == 0; }
};

/// Sums over samples; every pixel has `samples` of them.
struct Film {
    uint32_t width = 0, height = 0;
    uint64_t samples = 0;
    std::vector<glm::dvec3> sum;  // per pixel, row by row from the top
    std::vector<glm::dvec3> sumOfSquares;
    FilmCounters counters;

    void reset(uint32_t newWidth, uint32_t newHeight);

    /// Mean radiance, RGB.
    Image mean() const;

    /// Variance of the mean per channel, from the samples' own spread; zero below two samples. With
    /// the Sobol sampler this is an upper bound: its samples are less noisy together than apart.
    Image varianceOfMean() const;
};

}  // namespace core
