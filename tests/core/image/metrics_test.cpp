// T30: error metrics against hand-computed values, and Welch's test against its own promises.
#include "core/image/metrics.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "tests/support/statistics/stats.h"

namespace core {
namespace {

Image constant(uint32_t width, uint32_t height, glm::vec3 color)
{
    Image image(width, height, 3);
    for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = color[int(i % 3)];
    return image;
}

TEST(Metrics, handComputed)
{
    Image image(2, 1, 3), reference(2, 1, 3);
    image.pixels = {1, 2, 3, 0.5f, 0, 4};
    reference.pixels = {1, 1, 1, 0.25f, 1, 2};
    // d = 0 1 2 | 0.25 -1 2; squares 0 1 4 0.0625 1 4
    const ImageErrors errors = imageErrors(image, reference);
    EXPECT_NEAR(errors.rmse, std::sqrt(10.0625 / 6), 1e-12);
    const double relative = 0 + 1 / 1.01 + 4 / 1.01 + 0.0625 / 0.0725 + 1 / 1.01 + 4 / 4.01;
    EXPECT_NEAR(errors.relMse, relative / 6, 1e-12);
    EXPECT_NEAR(errors.meanSignedError, 4.25 / 6, 1e-12);
    EXPECT_EQ(errors.meanImage, glm::dvec3(0.75, 1, 3.5));
    EXPECT_EQ(errors.meanReference, glm::dvec3(0.625, 1, 1.5));
    EXPECT_EQ(errors.nonFinitePixels, 0u);
}

TEST(Metrics, NoiseIsTheRootOfTheMeanVariance)
{
    core::Image variance(8, 8, 3);
    for (size_t i = 0; i < variance.pixels.size(); ++i) variance.pixels[i] = i % 2 ? 0.01f : 0.03f;
    EXPECT_NEAR(core::noiseOf(variance), std::sqrt(0.02), 1e-7);
    variance.pixels[5] = std::numeric_limits<float>::infinity();
    EXPECT_NEAR(core::noiseOf(variance), std::sqrt(0.02), 1e-3);
    EXPECT_EQ(core::noiseOf({}), 0);
}

TEST(Metrics, constantOffsets)
{
    const Image reference = constant(50, 40, {0.5f, 1, 2});
    const Image image = constant(50, 40, {0.75f, 1.25f, 2.25f});
    const ImageErrors errors = imageErrors(image, reference);
    EXPECT_NEAR(errors.rmse, 0.25, 1e-12);
    EXPECT_NEAR(errors.meanSignedError, 0.25, 1e-12);
    EXPECT_NEAR(errors.relMse, 0.0625 * (1 / 0.26 + 1 / 1.01 + 1 / 4.01) / 3, 1e-12);
    EXPECT_NEAR(imageErrors(reference, image).meanSignedError, -0.25, 1e-12);
    const ImageErrors none = imageErrors(image, image);
    EXPECT_EQ(none.rmse, 0);
    EXPECT_EQ(none.relMse, 0);
}

TEST(Metrics, extraChannelsAreIgnored)
{
    Image image(1, 1, 4), reference(1, 1, 3);
    image.pixels = {1, 2, 3, 1000};
    reference.pixels = {1, 2, 2};
    EXPECT_NEAR(imageErrors(image, reference).rmse, std::sqrt(1.0 / 3), 1e-12);
}

TEST(Metrics, nonFinitePixelsAreCountedAndLeftOut)
{
    Image image = constant(8, 8, glm::vec3(2)), reference = constant(8, 8, glm::vec3(1));
    image.at(3, 3)[1] = std::numeric_limits<float>::quiet_NaN();
    image.at(4, 4)[2] = std::numeric_limits<float>::infinity();
    reference.at(4, 4)[0] = -std::numeric_limits<float>::infinity();
    reference.at(5, 6)[0] = std::numeric_limits<float>::quiet_NaN();
    const ImageErrors errors = imageErrors(image, reference);
    EXPECT_EQ(errors.nonFinitePixels, 3u);
    EXPECT_EQ(errors.rmse, 1);
    EXPECT_EQ(errors.meanImage, glm::dvec3(2));
    const Image nothing = constant(1, 1, glm::vec3(std::numeric_limits<float>::quiet_NaN()));
    EXPECT_EQ(imageErrors(nothing, nothing).nonFinitePixels, 1u);
    EXPECT_EQ(imageErrors(nothing, nothing).rmse, 0);
}

TEST(Metrics, sameForAnyNumberOfThreads)
{
    std::mt19937 random(3);
    Image image(123, 77, 3), reference(123, 77, 3);
    for (float& v : image.pixels) v = float(random()) * 0x1p-32f;
    for (float& v : reference.pixels) v = float(random()) * 0x1p-32f;
    const ImageErrors all = imageErrors(image, reference);
    const ThreadLimit limit(1);
    const ImageErrors one = imageErrors(image, reference);
    EXPECT_EQ(all.rmse, one.rmse);
    EXPECT_EQ(all.relMse, one.relMse);
    EXPECT_EQ(all.meanImage, one.meanImage);
}

/// Mean and variance of the mean of `samples` exponential draws per pixel and channel around
/// `level`.
struct NoisyImage {
    Image mean, variance;
    uint64_t samples;

    NoisyImage(uint32_t width, uint32_t height, uint32_t n, double level, uint32_t seed)
        : mean(width, height, 3), variance(width, height, 3), samples(n)
    {
        std::mt19937 random(seed);
        std::exponential_distribution<double> draw(1.0);
        for (size_t i = 0; i < mean.pixels.size(); ++i) {
            tests::Moments moments;
            for (uint32_t s = 0; s < n; ++s) moments.add(level * draw(random));
            mean.pixels[i] = float(moments.mean());
            variance.pixels[i] = float(moments.varianceOfMean());
        }
    }
    MeanAndVariance estimate() const { return {mean, variance, samples}; }
};

TEST(Welch, handComputed)
{
    const Image a = constant(2, 1, {3, 1, 0}), b = constant(2, 1, {2, 1, 0});
    Image va = constant(2, 1, {0.3f, 0.1f, 0}), vb = constant(2, 1, {0.2f, 0.1f, 0});
    const WelchResult result = welchTest({a, va, 0}, {b, vb, 0});
    // Sums over two pixels: difference 2, variance 2 (0.3 + 0.2) = 1.
    EXPECT_NEAR(result.image[0].z, 2, 1e-6);
    EXPECT_NEAR(result.image[0].p, 0.045500263896, 1e-7);
    EXPECT_EQ(result.image[1].z, 0);
    EXPECT_EQ(result.image[2].p, 1);
    ASSERT_EQ(result.tiles.size(), 1u);
    EXPECT_NEAR(result.largestTileZ, 2, 1e-6);
    EXPECT_NEAR(result.smallestP, 1 - std::pow(1 - 0.045500263896, 3), 1e-6);
    EXPECT_NEAR(result.detectableBias[0], (4.21 + 2.33) * 1 / 4, 1e-6);
}

TEST(Welch, degreesOfFreedomAndStudentsTail)
{
    const Image a = constant(1, 1, glm::vec3(3)), b = constant(1, 1, glm::vec3(1));
    const Image va = constant(1, 1, glm::vec3(1)), vb = constant(1, 1, glm::vec3(0.5f));
    const WelchResult result = welchTest({a, va, 16}, {b, vb, 32});
    const double degrees = 1.5 * 1.5 / (1.0 / 15 + 0.25 / 31);
    EXPECT_NEAR(result.image[0].degreesOfFreedom, degrees, 1e-9);
    const double exact = tests::studentTwoSidedP(2 / std::sqrt(1.5), degrees);
    EXPECT_NEAR(result.image[0].p / exact, 1, 0.01);
    // The approximation holds far out in the tail, where decisions are made.
    for (const double t : {1.0, 3.0, 5.0, 8.0}) {
        const Image far = constant(1, 1, glm::vec3(float(1 + t * std::sqrt(1.5))));
        const double p = welchTest({far, va, 16}, {b, vb, 32}).image[0].p;
        EXPECT_NEAR(p / tests::studentTwoSidedP(t, degrees), 1, 0.03) << t;
    }
}

TEST(Welch, withoutVarianceOnlyEqualityCounts)
{
    const Image zero = constant(16, 16, glm::vec3(0));
    const Image a = constant(16, 16, glm::vec3(1));
    Image b = a;
    WelchResult result = welchTest({a, zero, 0}, {b, zero, 0});
    EXPECT_TRUE(result.tiles.empty());
    EXPECT_EQ(result.smallestP, 1);
    EXPECT_EQ(result.uniformP, 1);
    b.at(9, 2)[2] = 0.5f;
    result = welchTest({a, zero, 0}, {b, zero, 0});
    ASSERT_EQ(result.tiles.size(), 1u);
    EXPECT_EQ(result.tiles[0].x, 8u);
    EXPECT_EQ(result.tiles[0].y, 0u);
    EXPECT_EQ(result.largestTileZ, kCertain);
    EXPECT_EQ(result.smallestP, 0);
}

TEST(Welch, acceptsNoiseAlone)
{
    const NoisyImage a(128, 128, 32, 1, 11), b(128, 128, 64, 1, 12);
    const WelchResult result = welchTest(a.estimate(), b.estimate());
    EXPECT_EQ(result.tiles.size(), 256u);
    EXPECT_GT(result.smallestP, tests::kLevel);
    EXPECT_GT(result.uniformP, 1e-4);
    for (const WelchScore& score : result.image) EXPECT_LT(std::abs(score.z), tests::kScore);
    for (const double bias : result.detectableBias) EXPECT_LT(bias, 0.02);
    uint32_t sum = 0;
    for (const uint32_t count : result.histogram) sum += count;
    EXPECT_EQ(sum, 256u);
}

TEST(Welch, findsTheBiasThatItPromises)
{
    const NoisyImage b(128, 128, 64, 1, 14);
    const double promised = welchTest(b.estimate(), b.estimate()).detectableBias[1];
    EXPECT_LT(promised, 0.02);
    int found = 0;
    for (uint32_t seed = 20; seed < 26; ++seed) {
        const NoisyImage a(128, 128, 64, 1 + promised, seed);
        const WelchResult result = welchTest(a.estimate(), b.estimate());
        for (const WelchScore& score : result.image) found += score.z > tests::kScore;
    }
    EXPECT_GE(found, 17);  // of 18, each with 99 % power
}

TEST(Welch, findsOneWrongTileAndWrongVariances)
{
    NoisyImage a(64, 64, 64, 1, 31);
    const NoisyImage b(64, 64, 64, 1, 32);
    Image shifted = a.mean;
    for (uint32_t y = 16; y < 24; ++y)
        for (uint32_t x = 40; x < 48; ++x)
            for (int c = 0; c < 3; ++c) shifted.at(x, y)[c] *= 1.3f;
    const WelchResult local = welchTest({shifted, a.variance, 64}, b.estimate());
    EXPECT_GT(local.largestTileZ, tests::kScore);
    EXPECT_LT(local.smallestP, tests::kLevel);
    for (const WelchTile& tile : local.tiles)
        if (tile.channels[1].z > tests::kScore) {
            EXPECT_EQ(tile.x, 40u);
            EXPECT_EQ(tile.y, 16u);
        }
    // Variances too large by three: no mean is off, but the p-values crowd near one.
    for (float& v : a.variance.pixels) v *= 3;
    NoisyImage c = b;
    for (float& v : c.variance.pixels) v *= 3;
    EXPECT_LT(welchTest(a.estimate(), c.estimate(), 4).uniformP, 1e-4);
}

TEST(Welch, leavesOutWhatIsNotFinite)
{
    NoisyImage a(32, 32, 16, 1, 41);
    const NoisyImage b(32, 32, 16, 1, 42);
    a.mean.at(5, 5)[0] = std::numeric_limits<float>::quiet_NaN();
    a.variance.at(20, 9)[1] = std::numeric_limits<float>::infinity();
    const WelchResult result = welchTest(a.estimate(), b.estimate());
    for (const WelchScore& score : result.image) EXPECT_LT(std::abs(score.z), tests::kScore);
    EXPECT_EQ(result.tiles.size(), 16u);
}

TEST(Statistics, kolmogorovAgreesWithTheTestsOwn)
{
    std::mt19937 random(5);
    for (const size_t count : {size_t(5), size_t(40), size_t(1000)})
        for (const double power : {1.0, 1.2, 3.0}) {
            std::vector<double> values;
            for (size_t i = 0; i < count; ++i)
                values.push_back(std::pow(double(random()) * 0x1p-32, power));
            EXPECT_NEAR(kolmogorovUniformP(values), tests::kolmogorovUniformP(values), 1e-6);
        }
    EXPECT_EQ(kolmogorovUniformP({}), 1);
    EXPECT_NEAR(twoSidedP(1.959963985), 0.05, 1e-9);
    EXPECT_NEAR(twoSidedP(-4.21), 2.5537e-5, 1e-8);
}

}  // namespace
}  // namespace core
