// Sums over tiles keep pixels apart: the variance of a tile's mean is that of its samples, not that
// of its picture.
#include "tests/support/statistics/compare_films.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "tests/support/statistics/stats.h"

namespace tests {

namespace {

struct PartMean {
    double mean = 0, variance = 0;
};

/// Mean over the pixels of a rectangle and the variance of that mean.
PartMean estimate(const core::Estimate& film, int channel, uint32_t x0, uint32_t y0, uint32_t x1,
                  uint32_t y1)
{
    PartMean e;
    double pixels = 0;
    for (uint32_t y = y0; y < y1; ++y) {
        for (uint32_t x = x0; x < x1; ++x) {
            e.mean += double(film.mean.at(x, y)[channel]);
            e.variance += double(film.variance.at(x, y)[channel]);
            pixels += 1;
        }
    }
    e.mean /= pixels;
    e.variance /= pixels * pixels;
    return e;
}

}  // namespace

FilmComparison compareFilms(const core::Estimate& a, const core::Estimate& b, uint32_t tile)
{
    FilmComparison c;
    std::vector<double> green;
    double variance = 0;
    for (int channel = 0; channel < 3; ++channel) {
        const PartMean wholeA = estimate(a, channel, 0, 0, a.mean.width, a.mean.height);
        const PartMean wholeB = estimate(b, channel, 0, 0, b.mean.width, b.mean.height);
        c.meanA += wholeA.mean / 3;
        c.meanB += wholeB.mean / 3;
        variance = std::max(variance, wholeA.variance + wholeB.variance);
        const double deviation = std::sqrt(wholeA.variance + wholeB.variance);
        if (deviation > 0)
            c.imageZ = std::max(c.imageZ, std::abs(wholeA.mean - wholeB.mean) / deviation);
        for (uint32_t y = 0; y < a.mean.height; y += tile) {
            for (uint32_t x = 0; x < a.mean.width; x += tile) {
                const uint32_t x1 = std::min(x + tile, a.mean.width),
                               y1 = std::min(y + tile, a.mean.height);
                const PartMean ta = estimate(a, channel, x, y, x1, y1),
                               tb = estimate(b, channel, x, y, x1, y1);
                const double scale = std::max(std::abs(ta.mean), std::abs(tb.mean));
                const double sigma = std::sqrt(ta.variance + tb.variance);
                if (sigma <= 1e-6 * scale) {  // constant up to rounding, e.g. a view into a lamp
                    c.exactMismatches += std::abs(ta.mean - tb.mean) > 1e-4 * scale ? 1u : 0u;
                    continue;
                }
                const double z = (ta.mean - tb.mean) / sigma;
                c.largestTileZ = std::max(c.largestTileZ, std::abs(z));
                ++c.tiles;
                if (channel == 1) green.push_back(normalTwoSidedP(z));
            }
        }
    }
    const double mean = 0.5 * (c.meanA + c.meanB);
    c.detectable = mean > 0 ? (kScore + 2.33) * std::sqrt(variance) / mean : 0;
    if (green.size() >= 16) c.uniformP = kolmogorovUniformP(green);
    return c;
}

bool FilmComparison::agree() const
{
    const double tileLimit = -normalQuantile(0.5 * sidak(kLevel, std::max<size_t>(tiles, 1)));
    return imageZ < kScore && largestTileZ < tileLimit && uniformP > 1e-4 && exactMismatches == 0;
}

std::string FilmComparison::describe() const
{
    char text[256];
    std::snprintf(
        text, sizeof(text),
        "means %.6g and %.6g, image |z| %.2f (detectable %.2f %%), largest of %zu tiles |z| %.2f, "
        "p-values uniform p %.2g, constant tiles that differ %zu",
        meanA, meanB, imageZ, 100 * detectable, tiles, largestTileZ, uniformP, exactMismatches);
    return text;
}

}  // namespace tests
