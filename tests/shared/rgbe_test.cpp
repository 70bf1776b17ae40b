// Colours in 32 bits: what comes back is right on average (stochastic rounding), close (nearest),
// and finite whatever went in.
#include "shared/rgbe.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "core/base/pcg32.h"
#include "tests/support/statistics/random_values.h"
#include "tests/support/statistics/stats.h"

namespace {

using core::Pcg32;
using glm::vec3;
using shared::packRgbe;
using shared::packRgbeNearest;
using shared::unpackRgbe;
using tests::logUniform;
using tests::uniform;

vec3 uniform3(Pcg32& random)
{
    const float x = uniform(random), y = uniform(random);
    return {x, y, uniform(random)};
}

/// Means of the stored channels in standard errors from the colour; channels that no rounding
/// changes give 0 or infinity.
vec3 scoresOfMean(vec3 colour, int count, bool stochastic, uint32_t seed)
{
    Pcg32 random(seed);
    std::array<tests::Moments, 3> moments;
    for (int i = 0; i < count; ++i) {
        const vec3 xi = uniform3(random);
        const vec3 back = unpackRgbe(stochastic ? packRgbe(colour, xi) : packRgbeNearest(colour));
        for (int c = 0; c < 3; ++c) moments[static_cast<size_t>(c)].add(double(back[c]));
    }
    vec3 scores(0);
    for (int c = 0; c < 3; ++c) {
        const tests::Moments& m = moments[static_cast<size_t>(c)];
        const double difference = m.mean() - double(colour[c]);
        const double error = std::sqrt(m.varianceOfMean());
        // Where all samples fell to one side the sample has no variance: what it would have had.
        const double step = double(shared::maxComponent(colour)) / 127.5;
        const double least = step / count;
        scores[c] =
            difference == 0 ? 0.0f : static_cast<float>(difference / std::max(error, least));
    }
    return scores;
}

TEST(Rgbe, StochasticRoundingIsRightOnAverage)
{
    std::vector<vec3> colours = {{1, 1e-4f, 1e-4f},        {1e-4f, 1, 0.3f},
                                 {0.999f, 0.998f, 1e-3f},  {255.5f, 255.7f, 255.9f},
                                 {3e-20f, 2e-23f, 1e-20f}, {7e30f, 6e27f, 1e30f}};
    Pcg32 random(301);
    while (colours.size() < 24) {
        const float scale = logUniform(random, 1e-6, 1e6);
        const float red = scale * logUniform(random, 1e-4, 1), green = scale * uniform(random);
        colours.emplace_back(red, green, scale);
    }
    for (size_t i = 0; i < colours.size(); ++i) {
        const vec3 z = scoresOfMean(colours[i], 100000, true, 400 + static_cast<uint32_t>(i));
        for (int c = 0; c < 3; ++c) {
            EXPECT_LT(std::abs(double(z[c])), 4.5) << "colour " << i << ": " << colours[i][c]
                                                   << " of " << shared::maxComponent(colours[i]);
        }
    }
}

TEST(Rgbe, NearestRoundingIsNotRightOnAverage)
{
    // What the test above must be able to see: a channel below half a step vanishes.
    const vec3 z = scoresOfMean({1, 1e-4f, 1e-3f}, 100000, false, 1);
    EXPECT_GT(std::abs(double(z.y)), 10);
    EXPECT_GT(std::abs(double(z.z)), 10);
    EXPECT_EQ(unpackRgbe(packRgbeNearest({1, 1e-4f, 1e-3f})).y, 0.0f);
}

TEST(Rgbe, ErrorsAreSmallInTheWholeRange)
{
    Pcg32 random(302);
    double nearest = 0, stochastic = 0;
    for (int i = 0; i < 200000; ++i) {
        const float scale = logUniform(random, 1.2e-38, 1.7e38);
        const vec3 colour = scale * uniform3(random);
        const float largest = shared::maxComponent(colour);
        if (largest < shared::kRgbeLeast) continue;
        const vec3 near = unpackRgbe(packRgbeNearest(colour));
        const vec3 other = unpackRgbe(packRgbe(colour, uniform3(random)));
        for (int c = 0; c < 3; ++c) {
            nearest =
                std::max(nearest, std::abs(double(near[c]) - double(colour[c])) / double(largest));
            stochastic = std::max(stochastic,
                                  std::abs(double(other[c]) - double(colour[c])) / double(largest));
        }
    }
    EXPECT_LE(nearest, 1.0 / 255 * (1 + 1e-6));
    EXPECT_GT(nearest, 0.9 / 255) << "the bound is not that of this format";
    EXPECT_LE(stochastic, 1.0 / 127.5 * (1 + 1e-6));
}

TEST(Rgbe, RoundingUpNeverCarries)
{
    // Colours whose mantissa rounds to 256 under the exponent of their largest channel.
    const float largestUniform = 1 - 0x1p-24f;
    for (int exponent = -126; exponent < 127; ++exponent) {
        for (double mantissa :
             {1.0, 1.5, 510.0 / 256, 510.5 / 256, 511.0 / 256, 511.5 / 256, 2 - 0x1p-23}) {
            const float x = static_cast<float>(std::ldexp(mantissa, exponent));
            for (float xi : {0.0f, 0.5f, largestUniform}) {
                const vec3 back = unpackRgbe(packRgbe({x, 0, x}, vec3(xi)));
                EXPECT_NEAR(double(back.x) / double(x), 1, 1 / 127.5) << x << ' ' << xi;
                EXPECT_EQ(back.y, 0.0f);
                EXPECT_EQ(back.z, back.x);
            }
        }
    }
}

TEST(Rgbe, WhatIsStoredComesBackTheSame)
{
    Pcg32 random(303);
    for (int i = 0; i < 100000; ++i) {
        const vec3 once = unpackRgbe(
            packRgbe(logUniform(random, 1e-30, 1e30) * uniform3(random), uniform3(random)));
        const vec3 twice = unpackRgbe(packRgbe(once, uniform3(random)));
        ASSERT_EQ(once, twice);
        ASSERT_EQ(once, unpackRgbe(packRgbeNearest(once)));
    }
}

TEST(Rgbe, WhatIsNoColourIsBlackOrSaturates)
{
    const float nan = std::numeric_limits<float>::quiet_NaN(),
                inf = std::numeric_limits<float>::infinity();
    EXPECT_EQ(packRgbeNearest(vec3(0)), 0u);
    EXPECT_EQ(unpackRgbe(0), vec3(0));
    EXPECT_EQ(packRgbe(vec3(-1, nan, -inf), vec3(0.9f)), 0u);
    EXPECT_EQ(packRgbe(vec3(1e-40f, 0, 1e-39f), vec3(0)), 0u);
    const vec3 mixed = unpackRgbe(packRgbeNearest({nan, 2, -3}));
    EXPECT_EQ(mixed, vec3(0, 2, 0));
    for (float huge : {inf, std::numeric_limits<float>::max(), 2e38f, shared::kRgbeMax}) {
        EXPECT_EQ(unpackRgbe(packRgbe({huge, 0, 1}, vec3(0.999f))), vec3(shared::kRgbeMax, 0, 0));
    }
    // Every word is a finite colour, but for the exponent that no colour gets.
    Pcg32 random(304);
    for (int i = 0; i < 100000; ++i) {
        const vec3 colour = unpackRgbe(random.bits() % 0xff000000u);
        for (int c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite(colour[c]) && colour[c] >= 0);
    }
}

}  // namespace
