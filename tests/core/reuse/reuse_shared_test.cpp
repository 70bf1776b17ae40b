// The solver for c on a batch of candidates, shared by kernels and CPU: the root that bisection
// finds, whatever the ratios.
#include "shared/reuse.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "core/base/pcg32.h"
#include "core/methods/path_kernel.h"
#include "core/methods/reuse_estimator.h"
#include "core/methods/reuse_settings.h"

namespace {

using core::Pcg32;

/// The root of c n = N mean(1 - c r)+ in double, by bisection.
double bisected(double N, double n, const float* ratios, uint32_t k)
{
    double low = 0, high = N / n;
    for (int i = 0; i < 200; ++i) {
        const double c = (low + high) / 2;
        double residual = 0;
        for (uint32_t t = 0; t < k; ++t) residual += std::max(0.0, 1 - c * double(ratios[t])) / k;
        (c * n < N * residual ? low : high) = c;
    }
    return std::min(std::max(low, double(shared::kReuseLeastC)), N / n);
}

TEST(ReuseShared, SolvesForCOnABatch)
{
    Pcg32 random(511);
    for (int i = 0; i < 20000; ++i) {
        const uint32_t k = 1 + random.bits() % shared::kReuseMaxCandidates;
        const double N = std::floor(std::pow(10, 3 * random())),
                     n = std::floor(std::pow(10, 3 * random()));
        const double spread = std::pow(10, 38 * random() * random());
        float ratios[shared::kReuseMaxCandidates];
        for (uint32_t t = 0; t < k; ++t) {
            const float q =
                random() < 0.1 ? 0.0f : static_cast<float>(std::pow(spread, 2 * random() - 1));
            ratios[t] = shared::reuseRatio(q, 1.0f);
            ASSERT_LE(ratios[t], shared::kInfinity);
        }
        const double expected = bisected(N, n, ratios, k);
        const float single =
            shared::reuseSolveC(static_cast<float>(N), static_cast<float>(n), ratios, k);
        ASSERT_NEAR(double(single) / expected, 1, 1e-5)
            << "k " << k << " N " << N << " n " << n << " of case " << i;
        double doubles[shared::kReuseMaxCandidates];
        std::copy(ratios, ratios + k, doubles);
        ASSERT_NEAR(shared::reuseSolveC(N, n, doubles, k) / expected, 1, 1e-10) << "case " << i;
    }
}

/// What a path brings that is no number is in one picture, not in those that follow.
TEST(ReuseShared, AMeanForgetsWhatIsNoNumber)
{
    shared::ReuseSums sums = shared::noReuseSums();
    sums.nominal = 4;
    sums.taken = 1;
    sums.plain = {1, std::numeric_limits<float>::quiet_NaN(), 2};
    const glm::vec3 before(3, 4, 5);
    const glm::vec3 first = shared::naiveMean(sums, before);
    EXPECT_TRUE(std::isnan(first.y)) << "the film has to drop it, and count it";
    const glm::vec3 kept = shared::keptMean(first, before);
    EXPECT_EQ(kept, before);
    sums.plain = {8, 9, 10};
    const glm::vec3 second = shared::keptMean(shared::naiveMean(sums, kept), kept);
    EXPECT_EQ(second, shared::naiveMean(sums, before));
    sums.plain.x = std::numeric_limits<float>::infinity();
    EXPECT_EQ(shared::keptMean(shared::naiveMean(sums, second), second), second);
    sums.nominal = 0;  // where there is nothing to go on with
    EXPECT_EQ(shared::keptMean(shared::naiveMean(sums, glm::vec3(0)), glm::vec3(0)), glm::vec3(0));
}

TEST(ReuseShared, SolvesForCAtTheEdges)
{
    const float disjoint[] = {0, 0, 0, 0}, same[] = {1, 1, 1, 1};
    const float huge[] = {3e38f, 3e38f, 2e38f, shared::kInfinity},
                mixed[] = {3e38f, 2e38f, 0.5f, 0.5f};
    EXPECT_FLOAT_EQ(shared::reuseSolveC(8.0f, 2.0f, disjoint, 4u), 4);  // N / n
    EXPECT_FLOAT_EQ(shared::reuseSolveC(8.0f, 2.0f, same, 4u), 0.8f);   // N / (N + n)
    EXPECT_FLOAT_EQ(shared::reuseSolveC(8.0f, 2.0f, huge, 4u), shared::kReuseLeastC);
    EXPECT_FLOAT_EQ(shared::reuseSolveC(8.0f, 2.0f, mixed, 4u), 1.0f);  // 2 c = 8 (1 - c/2) / 2
    EXPECT_EQ(shared::reuseSolveC(0.0f, 2.0f, same, 4u), 0);
    // More new samples than 1e6 per old one: N / n is the bound that counts.
    EXPECT_FLOAT_EQ(shared::reuseSolveC(1.0f, 1e7f, disjoint, 4u), 1e-7f);
}

TEST(ReuseShared, WhatCannotBeUsedIsNotUsed)
{
    const float nan = std::numeric_limits<float>::quiet_NaN(),
                inf = std::numeric_limits<float>::infinity();
    for (float bad : {0.0f, -1.0f, nan, inf, -inf, 1e-40f, 3e38f}) {
        EXPECT_FALSE(shared::usableDensity(bad));
        EXPECT_FALSE(shared::usableDensity(double(bad)));
        for (float good : {1e-20f, 1.0f, 1e20f}) {
            EXPECT_EQ(shared::reuseAlpha(0.5f, bad, good), 0);
            EXPECT_EQ(shared::reuseAlpha(0.5f, good, bad), 0);
            EXPECT_EQ(shared::reuseAlpha(bad, good, good), 0);
            EXPECT_EQ(shared::reuseAlphaOverQ(0.5f, bad, good), 0);
            EXPECT_EQ(shared::reuseAlphaOverQ(0.5f, good, bad), 0);
            EXPECT_EQ(shared::reuseRatio(bad, good), 0);
            EXPECT_EQ(shared::reuseRatio(good, bad), 0);
        }
        float sum = 0.25f;
        EXPECT_FALSE(shared::reuseKeep(sum, bad, 2.0f, 0.0f));
        EXPECT_EQ(sum, 0.25f);
        EXPECT_EQ(shared::reuseKeepScale(bad, 2.0f), 1);
    }
    for (float mistake : {-1.0f, nan, inf, -inf}) EXPECT_TRUE(shared::faultyDensity(mistake));
    for (float none : {0.0f, -0.0f, 1e-40f, 1.0f}) EXPECT_FALSE(shared::faultyDensity(none));
}

TEST(ReuseShared, AnOldSampleCountsAsItsShare)
{
    // alpha / q, both ways, over the whole range; and never more than c / p or 1 / q.
    Pcg32 random(512);
    for (int i = 0; i < 100000; ++i) {
        const double q = std::pow(10, 40 * random() - 20), p = std::pow(10, 40 * random() - 20);
        const double c = std::pow(10, 7 * random() - 6);
        const double direct = shared::reuseAlphaOverQ(c, q, p);
        ASSERT_NEAR(direct / (shared::reuseAlpha(c, q, p) / q), 1, 1e-13);
        ASSERT_NEAR(direct / std::min(1 / q, c / p), 1, 1e-13);
    }
}

/// What is left of paths that were due is packed after each pass: nothing of it may be cut off, or
/// fewer paths are taken than weights are divided by.
TEST(ReuseShared, PathsThatAreDueAreTaken)
{
    for (const float rays : {0.1f, 0.12f, 0.15f, 0.3f, 0.7f, 1.3f}) {
        core::ReuseParams params;
        params.rays = rays;
        const shared::ReuseSettings settings = core::reuseSettings(params);
        EXPECT_NEAR(settings.rays, rays, 5e-4);
        shared::ReuseHistory history = shared::noHistory();
        history.nominal = 16;
        constexpr int kPasses = 20000;
        double taken = 0;
        for (int i = 0; i < kPasses; ++i) {
            taken += shared::takeRays(settings, settings.rays, history);
            history = shared::unpackHistory(
                shared::packHistory(shared::grownHistory(settings, history, settings.rays, 1.0f)));
        }
        EXPECT_NEAR(taken / kPasses, double(settings.rays), 1.01 / kPasses) << rays;
    }
}

/// The width of a lobe is kept in eight bits: those that are just no mirrors are still known.
TEST(ReuseShared, NarrowLobesKeepTheirWidth)
{
    shared::ReuseHistory history = shared::noHistory();
    for (const float width : {shared::kDeltaAlpha, 0.002f, 0.0038f, 0.014f, 0.25f, 1.0f}) {
        history.width = width;
        const float kept = shared::unpackHistory(shared::packHistory(history)).width;
        EXPECT_NEAR(kept, width, 0.13f * width);
    }
}

/// Whatever the strategy keeps: diffuse walls under lamps need no more than that.
TEST(ReuseShared, SimpleScenesRunTheSimpleKernel)
{
    for (uint32_t k = 0; k < core::EnumNames<core::ReuseStrategy>::names.size(); ++k) {
        core::ReuseParams params;
        params.reuse = core::ReuseStrategy(k);
        const auto kernelFor = [&](uint32_t ofScene, bool mayMove) {
            const uint32_t features = core::reuseFeatures(params, ofScene, mayMove);
            return core::leastAble(core::reuseVariants(), features).kernel;
        };
        constexpr uint32_t kLamps = shared::kFeatureEmissiveTriangles;
        EXPECT_EQ(kernelFor(kLamps, false), core::estimateFlatReuseTile) << k;
        EXPECT_EQ(kernelFor(kLamps | shared::kFeatureDelta, false), core::estimateAnyReuseTile);
        EXPECT_EQ(kernelFor(kLamps, true), core::estimateAnyReuseTile) << k;
    }
}

/// Whatever the first picture of a view counts as, its variance is that of N + n paths.
TEST(ReuseShared, TellsTheVarianceOfWhatItKnows)
{
    shared::ReuseSums s = shared::noReuseSums();
    s.beta = glm::vec3(0.5f);
    s.nominal = 24;
    s.rays = s.part = 1;
    s.around = glm::vec3(0.7f);
    s.aroundSquares = glm::vec3(2.5f);
    const glm::vec3 mean = shared::reusedRadiance(s);
    EXPECT_EQ(shared::weightAtRest(s, 0.1f), 13);  // at most twelve old ones
    EXPECT_EQ(shared::weightAtRest(s, 9), 9);
    for (const float magnified : {1.0f, 4.0f, 64.0f}) {
        const float weight = shared::weightAtRest(s, magnified);
        const glm::vec3 variance = (shared::reusedSquares(s, weight) - mean * mean) * (1 / weight);
        EXPECT_NEAR(variance.x, 0.25 * (2.5 - 0.49) / 25, 1e-6) << magnified;
    }
}

}  // namespace
