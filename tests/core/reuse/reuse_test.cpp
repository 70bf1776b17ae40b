// The estimators of core/reuse: identities that hold sample by sample, and what happens at the
// edges.
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "app/lab/lab_change.h"
#include "core/reuse/estimators.h"
#include "core/reuse/history.h"

namespace core::reuse {
namespace {

using app::lab::LabChange;
using app::lab::LabPoint;
using app::lab::Pair;
using app::lab::pairs;

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

/// After a teleport nothing of the history is left, down to the random numbers.
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
    // What the old density covers infinitely better needs nothing new.
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

}  // namespace
}  // namespace core::reuse
