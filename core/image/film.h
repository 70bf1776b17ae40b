// What has been found of a picture: `Film` sums samples on the host, in double; `Estimate` is what
// every renderer hands out, whatever it sums and where.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "core/image/image.h"

namespace core {

/// Samples that were dropped because they were not colours, and rays whose traversal a device ended
/// before all was looked at (`stackOverflow`); all zero unless something is wrong.
struct FilmCounters {
    uint64_t nan = 0, inf = 0, negative = 0, stackOverflow = 0;
    bool clean() const { return nan + inf + negative + stackOverflow == 0; }
    FilmCounters& operator+=(const FilmCounters& other);
};

/// A picture as it stands. Pixels need not have had equally many samples: `weight` says how many
/// are behind each (for methods that reuse samples an effective number), 0 where nothing is known
/// yet and mean and variance are 0.
struct Estimate {
    Image mean;            // radiance, RGB
    Image variance;        // of the mean, RGB; empty when it was not asked for or is not known
    Image weight;          // one channel; empty when it was not asked for
    uint64_t samples = 0;  // that every pixel has had
    FilmCounters counters;
};

/// Sums over samples.
struct Film {
    uint32_t width = 0, height = 0;
    uint64_t samples = 0;         // that every pixel has had
    std::vector<glm::dvec3> sum;  // per pixel, row by row from the top
    std::vector<glm::dvec3> sumOfSquares;
    std::vector<uint32_t> weight;  // samples of each pixel: `samples`, or more in what goes ahead
    FilmCounters counters;

    void reset(uint32_t newWidth, uint32_t newHeight);

    /// One more sample of a pixel. One that is no colour counts as black and in `dropped`.
    void add(size_t pixel, const glm::vec3& radiance, FilmCounters& dropped);

    /// What is already known of a pixel counts as `count` samples (rounded, at least one) of that
    /// mean and mean square; replaces what there is. An estimate may be below zero: to leave that
    /// out would be a bias.
    void begin(size_t pixel, const glm::vec3& mean, const glm::vec3& squares, float count,
               FilmCounters& dropped);

    /// Mean radiance, RGB.
    Image mean() const;

    /// Variance of the mean per channel, from the samples' own spread; zero below two samples, the
    /// largest float where it is larger. With the Sobol sampler this is an upper bound: its samples
    /// are less noisy together than apart.
    Image varianceOfMean() const;

    /// Everything; `meanOnly` leaves variance and weight empty.
    Estimate estimate(bool meanOnly) const;
};

}  // namespace core
