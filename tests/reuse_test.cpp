// The estimators of core/reuse: identities that hold sample by sample, what happens at the edges,
// and resampling.
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>

#include "app/lab/lab_change.h"
#include "core/reuse/ess.h"
#include "core/reuse/estimators.h"
#include "core/reuse/history.h"
#include "stats.h"

namespace {

using app::lab::LabChange;
using app::lab::LabPoint;
using app::lab::Pair;
using app::lab::pairs;
using namespace core::reuse;
using core::Pcg32;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// Densities and integrand as given, over numbers drawn from [0, 1).
template <class R> struct Plain {
    using Point = R;
    using Real = R;
    using Value = R;
    std::function<R(R)> oldDensity, newDensity, integrand;

    R q(R x) const { return oldDensity(x); }
    R p(R x) const { return newDensity(x); }
    R f(R x) const { return integrand(x); }
    template <class Random> R sampleP(Random& random) const { return uniform<R>(random); }
};

template <class R> Plain<R> constant(R q, R p, R f)
{
    return {[=](R) { return q; }, [=](R) { return p; }, [=](R) { return f; }};
}

TEST(Reuse, AlphaIsTheFractionThatItSays)
{
    EXPECT_EQ(shared::reuseAlpha(0.5, 3.0, 2.0), 0.75);
    EXPECT_EQ(shared::reuseAlpha(0.5, 5.0, 2.0), 1.0);
    EXPECT_EQ(shared::reuseAlpha(0.5, 4.0, 2.0), 1.0);
    for (const double bad : {0.0, -1.0, kNaN, kInf, -kInf}) {
        EXPECT_EQ(shared::reuseAlpha(0.5, bad, 2.0), 0) << bad;
        EXPECT_EQ(shared::reuseAlpha(0.5, 3.0, bad), 0) << bad;
        EXPECT_EQ(shared::reuseAlpha(bad, 3.0, 2.0), 0) << bad;
        EXPECT_EQ(shared::reuseAlphaOverQ(0.5, bad, 2.0), 0) << bad;
        EXPECT_EQ(shared::reuseAlphaOverQ(0.5, 3.0, bad), 0) << bad;
        EXPECT_EQ(shared::reuseAlphaOverQ(bad, 3.0, 2.0), 0) << bad;
    }
}

template <class R> void expectOneFraction(const auto& fraction)
{
    Pcg32 random(11);
    const R tolerance = 8 * std::numeric_limits<R>::epsilon();
    for (int i = 0; i < 10000; ++i) {
        const R q = std::exp(R(40 * random() - 20)), p = std::exp(R(40 * random() - 20));
        const R alpha = fraction.alpha(q, p), overQ = fraction.alphaOverQ(q, p);
        ASSERT_GE(alpha, R(0));
        ASSERT_LE(alpha, R(1));
        ASSERT_NEAR(overQ * q, alpha, tolerance * alpha) << q << ' ' << p;
    }
}

TEST(Reuse, OldSamplesAndCandidatesSeeTheSameFraction)
{
    for (const double c : {1e-6, 0.3, 1.0, 7.0}) {
        expectOneFraction<double>(MinimumFraction<double>{c});
        expectOneFraction<float>(MinimumFraction<float>{static_cast<float>(c)});
    }
    expectOneFraction<double>(BalanceFraction<double>{8, 3});
    expectOneFraction<float>(BalanceFraction<float>{8, 3});
}

/// R-A with one candidate is MIS with weights alpha for the old and 1 - alpha for the new
/// technique.
TEST(Reuse, OneCandidateIsMultipleImportanceSampling)
{
    for (const Pair& pair : pairs()) {
        const LabChange change(pair);
        app::lab::OldSamples samples(change, 8);
        Pcg32 random(3, 1);
        for (const double c : {0.25, 1.0, 3.0}) {
            for (int trial = 0; trial < 200; ++trial) {
                const auto old = samples.draw(random);
                Pcg32 candidates(5, static_cast<uint64_t>(trial)), selection(6), same = candidates;
                const auto e = reweightingAugmentation(
                    change, old, 8.0, 5, 1, MinimumFraction<double>{c}, candidates, selection);
                app::lab::Values expected;
                for (const LabPoint& x : old)
                    if (x.p > 0)
                        expected += change.f(x) * (std::min(1.0, c * x.q / x.p) / (8 * x.q));
                for (int j = 0; j < 5; ++j) {
                    const LabPoint y = change.sampleP(same);
                    expected += change.f(y) * ((1 - std::min(1.0, c * y.q / y.p)) / (5 * y.p));
                }
                for (size_t f = 0; f < app::lab::kFunctions; ++f)
                    ASSERT_NEAR(e.value[f], expected[f], 1e-12 * (1 + std::abs(expected[f])))
                        << pair.id << ' ' << f;
            }
        }
    }
}

/// At the best c, and with exact samples of the residual, every sample has the weight of the
/// balance heuristic.
TEST(Reuse, AtTheBestScaleWeightsAreThoseOfTheBalanceHeuristic)
{
    for (const Pair& pair : pairs()) {
        for (const double n : {1.0, 2.0, 8.0, 30.0}) {
            constexpr double N = 8;
            const double c = pair.bestC(N, n), R = pair.residual(c);
            if (!(R > 0)) continue;
            Pcg32 random(4, 1);
            for (int i = 0; i < 1000; ++i) {
                const double x = (i % 2 ? pair.q : pair.p).sample(random());
                const double q = pair.q.pdf(x), p = pair.p.pdf(x);
                if (!(p > 0)) continue;
                const double residual = std::max(0.0, p - c * q) / R;
                const double balance = 1 / (N * q + n * residual);
                if (q > 0) {
                    ASSERT_NEAR(shared::reuseAlphaOverQ(c, q, p) / N, balance, 1e-10 * balance)
                        << pair.id << ' ' << n << ' ' << x;
                }
                // An exact residual sample weighs R / (n p), which is 1 / (M p).
                if (residual > 0) {
                    ASSERT_NEAR(R / (n * p), balance, 1e-10 * balance)
                        << pair.id << ' ' << n << ' ' << x;
                }
            }
        }
    }
}

TEST(Reuse, TheBalanceHeuristicIsWhatItSays)
{
    for (const Pair& pair : pairs()) {
        const LabChange change(pair);
        app::lab::OldSamples samples(change, 8);
        Pcg32 random(3, 2), candidates(7), same = candidates;
        const auto old = samples.draw(random);
        const auto e = balanceHeuristic(change, old, 8.0, 3, candidates);
        app::lab::Values expected;
        for (const LabPoint& x : old)
            if (x.p > 0) expected += change.f(x) * (1 / (8 * x.q + 3 * x.p));
        for (int j = 0; j < 3; ++j) {
            const LabPoint y = change.sampleP(same);
            expected += change.f(y) * (1 / (8 * y.q + 3 * y.p));
        }
        for (size_t f = 0; f < app::lab::kFunctions; ++f)
            EXPECT_NEAR(e.value[f], expected[f], 1e-12 * (1 + std::abs(expected[f]))) << pair.id;
    }
}

/// After a teleport nothing is left of history, down to the random numbers.
TEST(Reuse, WithoutHistoryItIsDiscardToTheBit)
{
    const LabChange change(pairs()[1]);
    app::lab::OldSamples samples(change, 8);
    Pcg32 random(1), a(9), b(9), c(9), selection(2);
    const auto old = samples.draw(random);
    const auto plain = discard(change, 6, a);
    const auto none = reweightingAugmentation(change, std::span<const LabPoint>(), 0.0, 6, 8,
                                              MinimumFraction<double>{0.5}, b, selection);
    const auto dropped =
        reweightingAugmentation(change, old, 8.0, 6, 8, MinimumFraction<double>{0}, c, selection);
    for (size_t f = 0; f < app::lab::kFunctions; ++f) {
        EXPECT_EQ(none.value[f], plain.value[f]);
        EXPECT_EQ(dropped.value[f], plain.value[f]);
    }

    History<LabPoint, double> history({6, 8, 16, 16});
    Pcg32 d(9), e(10), sameAsE(10), resampling(3);
    const auto first = history.advance(change, 0.0, d, selection, resampling);
    history.clear();
    const auto again = history.advance(change, 0.7, e, selection, resampling);
    const auto fresh = discard(change, 6, sameAsE);
    for (size_t f = 0; f < app::lab::kFunctions; ++f) {
        EXPECT_EQ(first.value[f], plain.value[f]);
        EXPECT_EQ(again.value[f], fresh.value[f]);
    }
}

/// The nominal count depends on c alone, and never on what happened to be kept.
TEST(Reuse, NominalCountOfAHistoryIsThatOfTheUnion)
{
    const LabChange change(pairs()[1]);
    Pcg32 a(1), b(2), d(3);
    History<LabPoint, double> history({4, 8, 6, 20});
    EXPECT_EQ(history.nominal(), 0);
    history.advance(change, 0.0, a, b, d);
    EXPECT_EQ(history.nominal(), 4);
    history.advance(change, 0.5, a, b, d);
    EXPECT_EQ(history.nominal(), 8);
    EXPECT_LE(history.samples().size(), 6u);
    history.advance(change, 0.8, a, b, d);
    EXPECT_EQ(history.nominal(), 10);
    history.advance(change, 0.25, a, b, d);
    EXPECT_EQ(history.nominal(), 20) << "the cap";
    history.advance(change, 0.0, a, b, d);
    EXPECT_EQ(history.nominal(), 4) << "history dropped";
    EXPECT_EQ(history.samples().size(), 4u);
}

template <class R> void expectFinite(const Estimate<R, R>& e, uint32_t faults, const char* what)
{
    EXPECT_TRUE(std::isfinite(e.value)) << what;
    EXPECT_TRUE(std::isfinite(e.weightSum)) << what;
    EXPECT_TRUE(std::isfinite(e.weightSquares)) << what;
    EXPECT_EQ(e.faults > 0, faults > 0) << what;
}

template <class R> void tryEverything(const Plain<R>& change, uint32_t faults, const char* what)
{
    const std::array<R, 4> points{R(0.1), R(0.4), R(0.6), R(0.9)};
    const std::span<const R> old(points);
    Pcg32 a(1), b(2), d(3);
    for (const uint32_t n : {1u, 4u}) {
        expectFinite(discard(change, n, a), std::isfinite(change.p(R(0.5))) ? 0 : faults, what);
        expectFinite(balanceHeuristic(change, old, R(4), n, a), faults, what);
        for (const R c : {R(1e-6), R(0.5), R(4) / R(n)}) {
            const MinimumFraction<R> fraction{c};
            for (const uint32_t k : {1u, 8u})
                expectFinite(reweightingAugmentation(change, old, R(4), n, k, fraction, a, b),
                             faults, what);
            History<R, R> history({n, 3, 4, 4});
            for (int frame = 0; frame < 4; ++frame)
                EXPECT_TRUE(std::isfinite(history.advance(change, frame ? c : 0, a, b, d).value))
                    << what;
        }
        expectFinite(thinnedReweightingAugmentation(change, old, R(4), 8, a, b), faults, what);
    }
    expectFinite(reweighting(change, old), faults, what);
    expectFinite(resampledOldSet(change, old, 3, b), faults, what);
    const R solved = solveCFromCandidates(change, R(4), 2, 8, a);
    EXPECT_TRUE(solved >= R(shared::kReuseLeastC) && solved <= R(2)) << what << ' ' << solved;
}

template <class R> void tryEdges()
{
    const R tiny = R(1e-18), huge = R(1e18);
    tryEverything<R>(constant<R>(1, 1, 2), 0, "p = q");
    tryEverything<R>(constant<R>(0, 1, 2), 0, "q = 0");
    tryEverything<R>(constant<R>(1, 0, 0), 0, "p = 0, f = 0");
    tryEverything<R>(constant<R>(tiny, 1, 2), 0, "q next to nothing");
    tryEverything<R>(constant<R>(huge, 1, 2), 0, "q a narrow lobe");
    tryEverything<R>(constant<R>(1, huge, huge), 0, "p a narrow lobe");
    tryEverything<R>(constant<R>(huge, huge, huge), 0, "both narrow");
    const R nan = std::numeric_limits<R>::quiet_NaN(), inf = std::numeric_limits<R>::infinity();
    tryEverything<R>(constant<R>(nan, 1, 2), 1, "q not a number");
    tryEverything<R>(constant<R>(inf, 1, 2), 1, "q a delta");
    tryEverything<R>(constant<R>(-1, 1, 2), 1, "q negative");
    tryEverything<R>(constant<R>(1, nan, 2), 1, "p not a number");
    tryEverything<R>(constant<R>(1, inf, 2), 1, "p a delta");
}

TEST(Reuse, EdgesGiveNumbersAndFaultsAreCounted)
{
    tryEdges<double>();
    tryEdges<float>();
}

TEST(Reuse, SolverIsExactOnItsCandidates)
{
    Pcg32 random(21);
    for (int trial = 0; trial < 5000; ++trial) {
        std::array<double, shared::kReuseMaxCandidates> ratios{};
        const uint32_t k = 1 + random.bits() % shared::kReuseMaxCandidates;
        for (uint32_t t = 0; t < k; ++t)
            ratios[t] = random() < 0.1 ? 0 : std::exp(12 * random() - 6);
        const double N = 1 + 63 * random(), n = 1 + 15 * random();
        const double c = shared::reuseSolveC(N, n, ratios.data(), k);
        double residual = 0;
        for (uint32_t t = 0; t < k; ++t) residual += std::max(0.0, 1 - c * ratios[t]) / k;
        ASSERT_NEAR(c * n, N * residual, 1e-12 * N) << trial;
        ASSERT_LE(c, N / n);
    }
    // What is infinitely better covered by the old density asks for nothing.
    std::array<double, shared::kReuseMaxCandidates> ratios{kInf, 1};
    EXPECT_NEAR(shared::reuseSolveC(4.0, 1.0, ratios.data(), 2), 4 * 1 / (2 + 4 * 1.0), 1e-12);
    EXPECT_EQ(shared::reuseSolveC(0.0, 1.0, ratios.data(), 2), 0);
}

TEST(Reuse, NoisierOldSamplesCountForLess)
{
    const Pair& pair = pairs()[1];
    const auto masses = [&](double c) { return pair.overSampled(c); };
    double before = 1e9;
    for (const double kappa : {0.5, 1.0, 2.0, 10.0}) {
        const double c = solveC(8, 8, masses, kappa);
        EXPECT_NEAR(c * 8 * kappa, 8 * pair.residual(c), 1e-12) << kappa;
        EXPECT_LT(c, before);
        before = c;
    }
}

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

/// Resamples one fixed set many times, by `resample(set, xi)`, and demands that its moments stay on
/// average.
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
