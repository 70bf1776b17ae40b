// The estimators that Reweighting-Augmentation is compared with: discard, reweighting, rejection
// ("filtering"), resampling of the old set, augmentation, and the mix of both. J. Zhang, M.
// Shields, "Probability Measure Changes in Monte Carlo Simulation" (2018); collected in S. Wang,
// "Efficient Sample Usage in Photo-Realistic Rendering" (2022), chapter 7.
#pragma once

#include <cmath>
#include <span>

#include "core/reuse/reweighting_augmentation.h"

namespace core::reuse {

/// n fresh samples of p, nothing reused: (1/n) sum f / p. With n = M it is the ceiling that reuse
/// can reach.
template <Change C, class Random>
EstimateOf<C> discard(const C& change, uint32_t n, Random& candidates)
{
    EstimateOf<C> estimate;
    for (uint32_t j = 0; j < n; ++j)
        trace(estimate, change, drawFresh(estimate, change, n, candidates));
    return estimate;
}

/// (1/N) sum f / q. Loses the energy where q = 0 and f is not. Its selfNormalised() is the biased
/// variant.
template <Change C>
EstimateOf<C> reweighting(const C& change, std::span<const typename C::Point> old)
{
    using Real = typename C::Real;
    EstimateOf<C> estimate;
    for (const typename C::Point& x : old) {
        const auto [q, p] = densitiesAt(change, x, estimate);
        if (shared::usableDensity(q))
            estimate.add(1 / (static_cast<Real>(old.size()) * q), p, change.f(x));
    }
    return estimate;
}

/// Accepts each old sample with probability p / (b q), and divides by the expected number N / b.
/// `b` >= sup p/q, finite: to be known, never estimated from the samples.
template <Change C, class Random>
EstimateOf<C> rejection(const C& change, std::span<const typename C::Point> old, typename C::Real b,
                        Random& coins)
{
    using Real = typename C::Real;
    CHECK(std::isfinite(b) && b >= 1);
    EstimateOf<C> estimate;
    const Real expected = static_cast<Real>(old.size()) / b;
    for (const typename C::Point& x : old) {
        const auto [q, p] = densitiesAt(change, x, estimate);
        if (uniform<Real>(coins) * (b * q) < p && shared::usableDensity(p))
            estimate.add(1 / (expected * p), p, change.f(x));
    }
    return estimate;
}

/// Resampled importance sampling with the old samples as candidates and p as target: `picks` of
/// them, drawn with replacement with probability proportional to w = p / q, each of weight mean(w)
/// / (picks p). Zero when all w are.
template <Change C, class Random>
EstimateOf<C> resampledOldSet(const C& change, std::span<const typename C::Point> old,
                              uint32_t picks, Random& selection)
{
    using Real = typename C::Real;
    CHECK(picks >= 1);
    EstimateOf<C> estimate;
    for (uint32_t j = 0; j < picks; ++j) {
        shared::Ris<Real> ris;
        shared::risStart(ris);
        for (uint32_t i = 0; i < old.size(); ++i) {
            const auto [q, p] = densitiesAt(change, old[i], estimate);
            shared::risAdd(ris, shared::reuseRatio(p, q), p, i, uniform<Real>(selection));
        }
        const Real u =
            shared::risWeight(ris, static_cast<Real>(old.size()), static_cast<Real>(picks));
        if (u > 0) estimate.add(u, ris.p, change.f(old[ris.pick]));
    }
    return estimate;
}

/// A whole number whose mean is x >= 0.
template <class Real, class Random> uint32_t roundAtRandom(Real x, Random& random)
{
    // Not floor(x + xi): the sum would round, and in single precision a whole number go up.
    const Real whole = std::floor(x);
    return static_cast<uint32_t>(whole) + (uniform<Real>(random) >= 1 - (x - whole) ? 1u : 0u);
}

/// Draws `count` exact samples of the residual density (p - c q)+ / R by rejection from p, each of
/// weight 1 / (M p). Candidates are given up after `kMostTrials` in a row and counted as faults:
/// the residual mass was then not what the caller believed.
template <Change C, class RandomA, class RandomB>
void addExactResidual(EstimateOf<C>& estimate, const C& change, uint32_t count, typename C::Real c,
                      typename C::Real M, RandomA& candidates, RandomB& coins)
{
    using Real = typename C::Real;
    constexpr uint32_t kMostTrials = 1u << 20;
    const MinimumFraction<Real> fraction{c};
    for (uint32_t j = 0; j < count; ++j) {
        for (uint32_t trial = 0;; ++trial) {
            if (trial == kMostTrials) {
                ++estimate.faults;
                return;
            }
            const typename C::Point z = change.sampleP(candidates);
            const auto [q, p] = densitiesAt(change, z, estimate);
            if (!(uniform<Real>(coins) < 1 - fraction.alpha(q, p)) || !shared::usableDensity(p))
                continue;
            ++estimate.rays;
            estimate.add(1 / (M * p), p, change.f(z));
            break;
        }
    }
}

/// Keeps all N old samples and adds (a - 1) N of the density (a p - q) / (a - 1), so that the union
/// are aN samples of p. `a` >= sup q/p, finite. The number added is rounded at random.
template <Change C, class RandomA, class RandomB>
EstimateOf<C> augmentation(const C& change, std::span<const typename C::Point> old,
                           typename C::Real a, RandomA& candidates, RandomB& coins)
{
    using Real = typename C::Real;
    CHECK(std::isfinite(a) && a >= 1);
    EstimateOf<C> estimate;
    const Real M = a * static_cast<Real>(old.size());
    for (const typename C::Point& x : old) {
        const auto [q, p] = densitiesAt(change, x, estimate);
        if (shared::usableDensity(p)) estimate.add(1 / (M * p), p, change.f(x));
    }
    const uint32_t added = roundAtRandom(M - static_cast<Real>(old.size()), coins);
    addExactResidual(estimate, change, added, 1 / a, M, candidates, coins);
    return estimate;
}

/// Keeps each old sample with probability min(1, p / (c q)) and adds M R(c) samples of the residual
/// density, M = N/c: the union is a sample set of p of expected size M. `residual` is R(c), exact.
/// The number added is rounded at random.
template <Change C, class RandomA, class RandomB>
EstimateOf<C> rejectionAugmentation(const C& change, std::span<const typename C::Point> old,
                                    typename C::Real c, typename C::Real residual,
                                    RandomA& candidates, RandomB& coins)
{
    using Real = typename C::Real;
    CHECK(c > 0 && residual >= 0 && residual <= 1);
    EstimateOf<C> estimate;
    const Real M = static_cast<Real>(old.size()) / c;
    for (const typename C::Point& x : old) {
        const auto [q, p] = densitiesAt(change, x, estimate);
        if (uniform<Real>(coins) * (c * q) < p && shared::usableDensity(p))
            estimate.add(1 / (M * p), p, change.f(x));
    }
    const uint32_t added = roundAtRandom(M * residual, coins);
    addExactResidual(estimate, change, added, c, M, candidates, coins);
    return estimate;
}

}  // namespace core::reuse
