// How fast a picture gets better, told by its first four samples: no faster than by chance where
// samples are independent, faster where they share out the light between them.
#include "core/guiding/convergence.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "core/base/pcg32.h"
#include "shared/guided_path.h"

namespace {

using core::Pcg32;
using core::guiding::Convergence;

constexpr uint32_t kConvergingSide = 96;

/// Pictures of one, two and four samples, which `draw` gives for a pixel.
template <class Draw> double factorOf(const Draw& draw, uint32_t stride = 0)
{
    constexpr size_t kPixels = size_t(kConvergingSide) * kConvergingSide;
    std::array<std::vector<float>, 5> pictures;
    for (auto& p : pictures) p.resize(3 * kPixels);
    Pcg32 random(11);
    for (size_t i = 0; i < kPixels; ++i) {
        const std::array<double, 4> samples = draw(random, i);
        double sum = 0;
        for (size_t n = 1; n <= 4; ++n) {
            sum += samples[n - 1];
            for (size_t c = 0; c < 3; ++c) pictures[n][3 * i + c] = float(sum / double(n));
        }
    }
    const std::vector<float> estimates(kPixels, 0.5f);
    Convergence convergence;
    convergence.begin();
    for (uint64_t n = 1; n <= 4; ++n)
        convergence.note(n, pictures[n], kConvergingSide, estimates, stride, 0.01);
    return convergence.factor();
}

std::array<double, 4> independentSamples(Pcg32& random, size_t)
{
    const double a = random(), b = random(), c = random();
    return {a, b, c, random()};
}

/// One in each half, then one in each quarter.
std::array<double, 4> stratifiedSamples(Pcg32& random, size_t)
{
    const uint32_t turn = random.bits() % 4;
    std::array<double, 4> x{};
    for (uint32_t k = 0; k < 4; ++k) {
        const uint32_t quarter = (((k & 1u) << 1u) | (k >> 1u)) ^ turn;
        x[k] = (double(quarter) + random()) / 4;
    }
    return x;
}

TEST(PictureConvergence, TellsStratifiedSamplesFromIndependentOnes)
{
    EXPECT_GT(factorOf(independentSamples), 0.88);
    EXPECT_EQ(factorOf(stratifiedSamples), 0.5);
}

/// A few bright pixels, of which one more is bright early than late, say nothing.
TEST(PictureConvergence, IsNotMisledByAFewBrightPixels)
{
    const auto withFireflies = [](Pcg32& random, size_t i) {
        std::array<double, 4> samples = independentSamples(random, i);
        if (i % 1000 == 7) samples[i / 1000 % 4] = 500;
        return samples;
    };
    EXPECT_EQ(factorOf(withFireflies), 1);
}

/// Pixels where another method had a hand in do not count; where it had in all, nothing is known.
TEST(PictureConvergence, PassesOverPixelsWithOtherPaths)
{
    const auto mixed = [](Pcg32& random, size_t i) {
        const auto x = uint32_t(i % kConvergingSide), y = uint32_t(i / kConvergingSide);
        const uint32_t lane = shared::guideCell({x & 7u, y & 7u});
        std::array<double, 4> samples = independentSamples(random, i);
        for (uint32_t k = 2; k < 4; ++k)
            if (shared::isRecorded(lane, k, 4)) samples[k] = 0.5;
        return samples;
    };
    EXPECT_GT(factorOf(mixed, 4), 0.85);
    EXPECT_EQ(factorOf(stratifiedSamples, 1), 1);
}

TEST(PictureConvergence, KnowsNothingOfAPictureThatItHasNotSeenFromTheStart)
{
    Convergence convergence;
    const std::vector<float> rgb(3 * 64, 1.0f), estimates(64, 1.0f);
    convergence.note(4, rgb, 8, estimates, 0, 0.01);
    EXPECT_EQ(convergence.factor(), 1);
}

}  // namespace
