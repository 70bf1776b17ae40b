// What accompanies the estimators: effective sample sizes, resampling, roulette, and the generator.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/pcg32.h"
#include "core/reuse/ess.h"
#include "core/reuse/estimators.h"
#include "core/reuse/resample.h"
#include "tests/support/statistics/stats.h"

namespace core::reuse {
namespace {

TEST(Ess, Identities)
{
    const std::array<double, 4> w{1, 2, 3, 4};
    EXPECT_NEAR(effectiveSampleSize(std::span<const double>(w)), 100.0 / 30, 1e-12);
    const std::array<double, 5> equal{0.3, 0.3, 0.3, 0.3, 0.3}, single{0, 0, 7, 0, 0}, none{};
    EXPECT_NEAR(effectiveSampleSize(std::span<const double>(equal)), 5, 1e-12);
    EXPECT_NEAR(effectiveSampleSize(std::span<const double>(single)), 1, 1e-12);
    EXPECT_EQ(effectiveSampleSize(std::span<const double>(none)), 0);

    Pcg32 random(8);
    for (const double scale : {1e-200, 1.0, 1e200}) {
        std::vector<double> v(50), scaled(50);
        for (size_t i = 0; i < v.size(); ++i) {
            v[i] = std::exp(3 * random());
            scaled[i] = scale * v[i];
        }
        const double N = 50, mean = std::accumulate(v.begin(), v.end(), 0.0) / N;
        double variance = 0;
        for (const double x : v) variance += (x - mean) * (x - mean) / N;
        const double ess = effectiveSampleSize(std::span<const double>(scaled));
        EXPECT_NEAR(N / ess, 1 + variance / (mean * mean), 1e-12 * N) << scale;
        EXPECT_NEAR(relativeVarianceOfMean(std::span<const double>(scaled)),
                    variance / N / (mean * mean), 1e-12)
            << scale;
    }
}

struct Weighted {
    double x = 0, u = 0;
};

/// A set of uneven weights, with some that are zero.
std::vector<Weighted> unevenSet(Pcg32& random, size_t count, std::vector<double>& scores)
{
    std::vector<Weighted> set(count);
    scores.clear();
    for (Weighted& s : set) {
        s = {random(), random() < 0.1 ? 0 : std::exp(5 * random() - 2.5)};
        scores.push_back(s.u);
    }
    return set;
}

std::array<double, 3> moments(std::span<const Weighted> set)
{
    std::array<double, 3> m{};
    for (const Weighted& s : set) {
        m[0] += s.u;
        m[1] += s.u * s.x;
        m[2] += s.u * s.x * s.x;
    }
    return m;
}

/// Resamples one fixed set many times, by `resample(set, xi)`, and demands that its moments are
/// kept on average.
void expectMomentsKept(const std::vector<Weighted>& set, int repeats, const auto& resample)
{
    const std::array<double, 3> truth = moments(set);
    std::array<tests::Moments, 3> found;
    Pcg32 random(31);
    for (int i = 0; i < repeats; ++i) {
        const std::vector<Weighted> kept = resample(set, random());
        const std::array<double, 3> m = moments(kept);
        for (size_t h = 0; h < 3; ++h) found[h].add(m[h]);
    }
    for (size_t h = 0; h < 3; ++h) {
        const double error = std::sqrt(found[h].varianceOfMean());
        EXPECT_NEAR(found[h].mean(), truth[h], tests::kScore * error + 1e-12 * truth[h]) << h;
        EXPECT_LT(error, 0.01 * truth[h]) << "too few repeats to see a bias of 4 %";
    }
}

TEST(Resample, ThresholdKeepsMomentsHeavyOnesAndTheCount)
{
    Pcg32 random(17);
    for (const uint32_t keep : {1u, 3u, 8u, 15u}) {
        std::vector<double> scores;
        const std::vector<Weighted> set = unevenSet(random, 20, scores);
        const double kappa = resamplingThreshold(std::span<const double>(scores), keep);
        double sum = 0;
        for (const double a : scores) sum += std::min(1.0, a / kappa);
        EXPECT_NEAR(sum, keep, 1e-12 * keep);
        expectMomentsKept(set, 300000, [&](std::vector<Weighted> s, double xi) {
            s.resize(thresholdResample(std::span<Weighted>(s), std::span<const double>(scores),
                                       keep, xi));
            EXPECT_EQ(s.size(), keep);
            for (size_t i = 0; i < set.size(); ++i) {
                if (scores[i] < kappa) continue;
                const auto there = std::find_if(s.begin(), s.end(), [&](const Weighted& w) {
                    return w.x == set[i].x && w.u == set[i].u;
                });
                EXPECT_NE(there, s.end()) << "a heavy sample is gone";
            }
            return s;
        });
    }
}

TEST(Resample, FewSamplesStayAsTheyAre)
{
    Pcg32 random(18);
    std::vector<double> scores;
    std::vector<Weighted> set = unevenSet(random, 12, scores);
    const std::array<double, 3> before = moments(set);
    const size_t kept =
        thresholdResample(std::span<Weighted>(set), std::span<const double>(scores), 12, 0.37);
    EXPECT_EQ(kept, static_cast<size_t>(std::count_if(scores.begin(), scores.end(),
                                                      [](double a) { return a > 0; })));
    const std::array<double, 3> after = moments(std::span(set).first(kept));
    for (size_t h = 0; h < 3; ++h) EXPECT_NEAR(after[h], before[h], 1e-12 * before[h]);
    for (double& a : scores) a = 0;
    EXPECT_EQ(thresholdResample(std::span<Weighted>(set), std::span<const double>(scores), 3, 0.5),
              0u);
}

TEST(Resample, SystematicKeepsMoments)
{
    Pcg32 random(19);
    for (const size_t keep : {size_t{1}, size_t{5}, size_t{30}}) {
        std::vector<double> scores;
        const std::vector<Weighted> set = unevenSet(random, 20, scores);
        // Scores that are not the weights, so that the weights of the drawn differ.
        for (size_t i = 0; i < set.size(); ++i)
            if (scores[i] > 0) scores[i] *= 0.5 + set[i].x;
        expectMomentsKept(set, 300000, [&](const std::vector<Weighted>& s, double xi) {
            std::vector<Weighted> drawn(keep);
            drawn.resize(systematicResample(std::span<const Weighted>(s),
                                            std::span<const double>(scores),
                                            std::span<Weighted>(drawn), xi));
            EXPECT_EQ(drawn.size(), keep);
            return drawn;
        });
    }
}

TEST(Resample, RouletteKeepsMoments)
{
    Pcg32 random(20), coins(77);
    std::vector<double> scores;
    const std::vector<Weighted> set = unevenSet(random, 40, scores);
    size_t removed = 0;
    expectMomentsKept(set, 300000, [&](std::vector<Weighted> s, double) {
        s.resize(
            pruneByRoulette(std::span<Weighted>(s), std::span<const double>(scores), 0.5, coins));
        removed += set.size() - s.size();
        return s;
    });
    EXPECT_GT(removed, 900000u) << "nothing was pruned, so nothing was tried";
}

/// Random numbers that a float would round to one.
struct NearlyOne {
    double operator()() const { return 1 - 0x1p-32; }
};

TEST(Resample, RouletteSparesWhatWeighsEnoughInSinglePrecision)
{
    struct Light {
        float u;
    };
    std::array<Light, 3> set{{{1}, {2}, {3}}};
    const std::array<float, 3> v{1, 2, 3};
    NearlyOne random;
    EXPECT_EQ(pruneByRoulette(std::span<Light>(set), std::span<const float>(v), 0.1f, random), 3u);
}

TEST(Resample, RoundingAtRandomLeavesWholeNumbersAlone)
{
    NearlyOne random;
    EXPECT_EQ(roundAtRandom(8.0f, random), 8u);
    EXPECT_EQ(roundAtRandom(8.0, random), 8u);
    EXPECT_EQ(roundAtRandom(8.25f, random), 9u);
    Pcg32 coins(3);
    tests::Moments rounded;
    for (int i = 0; i < 100000; ++i) rounded.add(roundAtRandom(2.3f, coins));
    EXPECT_LT(std::abs(tests::againstExact(rounded, double(2.3f)).z), tests::kScore);
}

TEST(Pcg, IsUniformAndItsStreamsDiffer)
{
    // Values of the generator's reference implementation for seed 42, stream 54.
    Pcg32 reference(42, 54);
    for (const uint32_t expected : {0xa15c02b7u, 0x7b47f409u, 0xba1d3330u, 0x83d2f293u})
        EXPECT_EQ(reference.bits(), expected);
    constexpr int kCells = 64, kDraws = 640000;
    Pcg32 a(1, 1), b(1, 2);
    std::vector<double> joint(kCells), expected(kCells, double(kDraws) / kCells);
    for (int i = 0; i < kDraws; ++i)
        joint[static_cast<size_t>(a() * 8) * 8 + static_cast<size_t>(b() * 8)] += 1;
    EXPECT_GT(tests::chiSquareTest(joint, expected).p, tests::kLevel);
}

}  // namespace
}  // namespace core::reuse
