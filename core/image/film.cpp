// Mean and variance of the mean from sums in double.
#include "core/image/film.h"

#include <algorithm>

namespace core {

void Film::reset(uint32_t newWidth, uint32_t newHeight)
{
    width = newWidth;
    height = newHeight;
    samples = 0;
    sum.assign(size_t(width) * height, glm::dvec3(0));
    sumOfSquares.assign(size_t(width) * height, glm::dvec3(0));
    counters = {};
}

Image Film::mean() const
{
    Image image(width, height, 3);
    const double scale = samples > 0 ? 1.0 / double(samples) : 0.0;
    for (size_t i = 0; i < sum.size(); ++i)
        for (int c = 0; c < 3; ++c)
            image.pixels[3 * i + size_t(c)] = static_cast<float>(sum[i][c] * scale);
    return image;
}

Image Film::varianceOfMean() const
{
    Image image(width, height, 3);
    if (samples < 2) return image;
    const double n = double(samples);
    for (size_t i = 0; i < sum.size(); ++i) {
        // (E[x^2] - E[x]^2) / (n - 1): unbiased; rounding can push a noiseless pixel just below
        // zero.
        const glm::dvec3 mean = sum[i] / n;
        const glm::dvec3 spread = sumOfSquares[i] / n - mean * mean;
        for (int c = 0; c < 3; ++c)
            image.pixels[3 * i + size_t(c)] =
                static_cast<float>(std::max(spread[c], 0.0) / (n - 1));
    }
    return image;
}

}  // namespace core
