// Mean and variance of the mean from sums in double.
#include "core/image/film.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace core {

FilmCounters& FilmCounters::operator+=(const FilmCounters& other)
{
    nan += other.nan;
    inf += other.inf;
    negative += other.negative;
    stackOverflow += other.stackOverflow;
    return *this;
}

void Film::reset(uint32_t newWidth, uint32_t newHeight)
{
    width = newWidth;
    height = newHeight;
    samples = 0;
    const size_t pixels = size_t(width) * height;
    sum.assign(pixels, glm::dvec3(0));
    sumOfSquares.assign(pixels, glm::dvec3(0));
    weight.assign(pixels, 0);
    counters = {};
}

/// Counts a sample that is no colour.
static bool isColour(const glm::vec3& L, FilmCounters& dropped)
{
    if (std::isnan(L.x) || std::isnan(L.y) || std::isnan(L.z)) {
        ++dropped.nan;
        return false;
    }
    if (std::isinf(L.x) || std::isinf(L.y) || std::isinf(L.z)) {
        ++dropped.inf;
        return false;
    }
    if (L.x < 0 || L.y < 0 || L.z < 0) {
        ++dropped.negative;
        return false;
    }
    return true;
}

void Film::add(size_t pixel, const glm::vec3& radiance, FilmCounters& dropped)
{
    ++weight[pixel];
    if (!isColour(radiance, dropped)) return;
    const glm::dvec3 L(radiance);
    sum[pixel] += L;
    sumOfSquares[pixel] += L * L;
}

void Film::begin(size_t pixel, const glm::vec3& mean, const glm::vec3& squares, float count,
                 FilmCounters& dropped)
{
    weight[pixel] = static_cast<uint32_t>(std::max(std::lround(count), 1L));
    const bool colour = isColour(glm::abs(mean), dropped);
    const double n = weight[pixel];
    sum[pixel] = colour ? n * glm::dvec3(mean) : glm::dvec3(0);
    sumOfSquares[pixel] = colour ? n * glm::dvec3(squares) : glm::dvec3(0);
}

Image Film::mean() const
{
    Image image(width, height, 3);
    for (size_t i = 0; i < sum.size(); ++i) {
        const double scale = weight[i] > 0 ? 1.0 / double(weight[i]) : 0.0;
        for (int c = 0; c < 3; ++c)
            image.pixels[3 * i + size_t(c)] = static_cast<float>(sum[i][c] * scale);
    }
    return image;
}

Image Film::varianceOfMean() const
{
    Image image(width, height, 3);
    for (size_t i = 0; i < sum.size(); ++i) {
        if (weight[i] < 2) continue;
        const double n = double(weight[i]);
        // (E[x^2] - E[x]^2) / (n - 1): unbiased; rounding can push a noiseless pixel just below
        // zero.
        const glm::dvec3 mean = sum[i] / n;
        const glm::dvec3 spread = sumOfSquares[i] / n - mean * mean;
        constexpr double kMost = std::numeric_limits<float>::max();
        for (int c = 0; c < 3; ++c)
            image.pixels[3 * i + size_t(c)] =
                static_cast<float>(std::clamp(spread[c] / (n - 1), 0.0, kMost));
    }
    return image;
}

Estimate Film::estimate(bool meanOnly) const
{
    Estimate e;
    e.mean = mean();
    e.samples = samples;
    e.counters = counters;
    if (meanOnly) return e;
    e.variance = varianceOfMean();
    e.weight = Image(width, height, 1);
    for (size_t i = 0; i < weight.size(); ++i) e.weight.pixels[i] = static_cast<float>(weight[i]);
    return e;
}

}  // namespace core
