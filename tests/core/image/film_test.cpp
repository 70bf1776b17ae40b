// The film's mean and variance of the mean, against direct computation and against their
// expectation.
#include "core/image/film.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/statistics/stats.h"

namespace core {
namespace {

/// A film of `samples` draws per pixel and channel.
template <class Draw> Film filmOf(uint32_t width, uint32_t height, uint32_t samples, Draw draw)
{
    Film film;
    film.reset(width, height);
    film.samples = samples;
    for (size_t p = 0; p < film.sum.size(); ++p)
        for (uint32_t s = 0; s < samples; ++s) {
            const glm::dvec3 x(draw(), draw(), draw());
            film.sum[p] += x;
            film.sumOfSquares[p] += x * x;
            ++film.weight[p];
        }
    return film;
}

TEST(Film, handComputed)
{
    Film film;
    film.reset(2, 1);
    film.samples = 3;  // 1, 2, 6 and 4, 4, 4 in red
    film.sum = {{9, 0, 0}, {12, 0, 0}};
    film.sumOfSquares = {{41, 0, 0}, {48, 0, 0}};
    film.weight = {3, 3};
    EXPECT_EQ(film.mean().pixels, (std::vector<float>{3, 0, 0, 4, 0, 0}));
    // Spread 4 + 1 + 9 = 14: variance 7, of the mean 7/3.
    const Image variance = film.varianceOfMean();
    EXPECT_NEAR(variance.pixels[0], 7.0 / 3.0, 1e-6);
    EXPECT_EQ(variance.pixels[3], 0.0f);
}

TEST(Film, withoutSamplesIsBlack)
{
    Film film;
    film.reset(3, 2);
    EXPECT_EQ(film.mean().pixels, std::vector<float>(18, 0.0f));
    film.samples = 1;
    film.sum.assign(6, glm::dvec3(5));
    film.sumOfSquares.assign(6, glm::dvec3(25));
    film.weight.assign(6, 1);
    EXPECT_EQ(film.mean().pixels, std::vector<float>(18, 5.0f));
    EXPECT_EQ(film.varianceOfMean().pixels, std::vector<float>(18, 0.0f));
}

/// Pixels of a film that is in the middle of a sample are divided by what each has had.
TEST(Film, PixelsAheadHaveTheirOwnWeight)
{
    Film film;
    film.reset(2, 1);
    film.samples = 1;
    FilmCounters dropped;
    film.add(0, glm::vec3(4), dropped);
    film.add(1, glm::vec3(3), dropped);
    film.add(1, glm::vec3(5), dropped);
    film.add(1, glm::vec3(std::nanf(""), 0, 0), dropped);
    EXPECT_EQ(dropped.nan, 1u);
    const Estimate e = film.estimate(false);
    EXPECT_EQ(e.samples, 1u);
    EXPECT_EQ(e.weight.pixels, (std::vector<float>{1, 3}));
    EXPECT_EQ(e.mean.pixels[0], 4);
    EXPECT_FLOAT_EQ(e.mean.pixels[3], 8.0f / 3);
    EXPECT_EQ(e.variance.pixels[0], 0);
    EXPECT_FLOAT_EQ(e.variance.pixels[3], (34.0f / 3 - 64.0f / 9) / 2);
    EXPECT_TRUE(film.estimate(true).variance.pixels.empty());
}

TEST(Film, resetForgets)
{
    std::mt19937 random(1);
    Film film = filmOf(4, 4, 5, [&] { return double(random() % 7); });
    film.counters.nan = 3;
    EXPECT_FALSE(film.counters.clean());
    film.reset(2, 3);
    EXPECT_EQ(film.samples, 0u);
    EXPECT_TRUE(film.counters.clean());
    EXPECT_EQ(film.sum, std::vector<glm::dvec3>(6, glm::dvec3(0)));
    EXPECT_EQ(film.sumOfSquares.size(), 6u);
}

TEST(Film, noiselessPixelHasNoVariance)
{
    // Rounding must neither give a negative variance nor one that matters.
    const Film film = filmOf(1, 1, 100000, [] { return 0.1; });
    const float variance = film.varianceOfMean().pixels[0];
    EXPECT_GE(variance, 0.0f);
    EXPECT_LT(variance, 1e-16f);
}

/// An infinite one would be left out of means of variances, as if there were no noise.
TEST(Film, VariancesEndAtTheLargestFloat)
{
    Film film;
    film.reset(1, 1);
    FilmCounters dropped;
    film.add(0, glm::vec3(1e25f, 1, 0), dropped);
    film.add(0, glm::vec3(0, 1, 0), dropped);
    const Image variance = film.varianceOfMean();
    EXPECT_EQ(variance.pixels[0], std::numeric_limits<float>::max());
    EXPECT_EQ(variance.pixels[1], 0);
    EXPECT_EQ(dropped.inf, 0u);
}

TEST(Film, varianceOfTheMeanIsUnbiased)
{
    std::mt19937 random(2);
    std::exponential_distribution<double> draw(0.5);  // mean 2, variance 4
    const Film film = filmOf(100, 100, 16, [&] { return draw(random); });
    tests::Moments means, variances;
    for (const float v : film.mean().pixels) means.add(double(v));
    for (const float v : film.varianceOfMean().pixels) variances.add(double(v));
    const tests::Comparison mean = tests::againstExact(means, 2);
    const tests::Comparison variance = tests::againstExact(variances, 4.0 / 16.0);
    EXPECT_LT(mean.detectable, 0.02);
    EXPECT_LT(variance.detectable, 0.05);
    EXPECT_LT(std::abs(mean.z), tests::kScore);
    EXPECT_LT(std::abs(variance.z), tests::kScore);
    // And it describes the spread of the means themselves.
    EXPECT_NEAR(means.variance(), variances.mean(), 0.05 * variances.mean());
}

}  // namespace
}  // namespace core
