// Reweighting-Augmentation: old samples of q stay, with the share alpha of the integral; the rest
// comes from n new samples, each resampled among k candidates of p with weight 1 - alpha. After S.
// Wang, "Efficient Sample Usage in Photo-Realistic Rendering" (2022), chapter 7. What differs: n is
// free (it need not be M R(c)), the residual mass is never asked for, and alpha may be any fraction
// of fraction.h, which makes MIS the same code.
#pragma once

#include <array>
#include <span>

#include "core/base/check.h"
#include "core/reuse/change.h"
#include "core/reuse/fraction.h"

namespace core::reuse {

/// A new sample of the density p and its absolute weight.
template <Change C> struct Draw {
    typename C::Point y{};
    typename C::Real u = 0;  // 0: not worth a ray, counts as zero (drawing again would be biased)
    typename C::Real p = 0;
    typename C::Real omega = 1;  // the resampling weight that it was picked with
};

/// One of n plain samples of p: u = 1 / (n p).
template <Change C, class Random>
Draw<C> drawFresh(EstimateOf<C>& estimate, const C& change, uint32_t n, Random& candidates)
{
    Draw<C> draw{change.sampleP(candidates)};
    draw.p = change.p(draw.y);
    if (shared::faultyDensity(draw.p)) ++estimate.faults;
    if (shared::usableDensity(draw.p)) draw.u = 1 / (static_cast<typename C::Real>(n) * draw.p);
    return draw;
}

/// Adds the sample, which costs the ray.
template <Change C> void trace(EstimateOf<C>& estimate, const C& change, const Draw<C>& draw)
{
    if (!(draw.u > 0)) return;
    ++estimate.rays;
    estimate.add(draw.u, draw.p, change.f(draw.y));
}

/// Adds the old samples with their share: each counts f alpha / (N q). `N` is the nominal number
/// that the samples are the outcome of, which differs from how many there are when that is random.
template <Change C, class Fraction>
void addOld(EstimateOf<C>& estimate, const C& change, std::span<const typename C::Point> old,
            typename C::Real N, const Fraction& fraction)
{
    for (const typename C::Point& x : old) {
        const auto [q, p] = densitiesAt(change, x, estimate);
        const auto u = fraction.alphaOverQ(q, p) / N;
        if (u > 0) estimate.add(u, p, change.f(x));
    }
}

/// One of n samples of the residual: the pick among k candidates, u = mean(omega) / (n p).
/// `leastOmega` > 0 keeps a chance for every candidate, for fractions that are only known after the
/// ray (postTrace).
template <Change C, class Fraction, class RandomA, class RandomB>
Draw<C> drawResidual(EstimateOf<C>& estimate, const C& change, uint32_t n, uint32_t k,
                     const Fraction& fraction, RandomA& candidates, RandomB& selection,
                     typename C::Real leastOmega = 0)
{
    using Real = typename C::Real;
    Draw<C> draw;
    shared::Ris<Real> ris;
    shared::risStart(ris);
    for (uint32_t t = 0; t < k; ++t) {
        const typename C::Point z = change.sampleP(candidates);
        const auto [q, p] = densitiesAt(change, z, estimate);
        const Real omega = std::max(1 - fraction.alpha(q, p), leastOmega);
        // Drawn for k = 1 too, so that streams stay aligned between runs that differ in k.
        if (shared::risAdd(ris, omega, p, t, uniform<Real>(selection))) draw.y = z;
    }
    draw.u = shared::risWeight(ris, static_cast<Real>(k), static_cast<Real>(n));
    draw.p = ris.p;
    draw.omega = ris.omega;
    return draw;
}

/// One step of R-A from N old samples of q to the integral of f, with n new rays and k candidates
/// for each. Unbiased for any fraction, n >= 1, k >= 1; needs p > 0 wherever f is not zero. Where
/// nothing is reused it is Discard, to the bit. `candidates` and `selection` are independent
/// streams; c must not depend on them. At the best c (solve_c.h) and k without bound the weights
/// are those of the balance heuristic between q and the residual density.
template <Change C, class Fraction, class RandomA, class RandomB>
EstimateOf<C> reweightingAugmentation(const C& change, std::span<const typename C::Point> old,
                                      typename C::Real N, uint32_t n, uint32_t k,
                                      const Fraction& fraction, RandomA& candidates,
                                      RandomB& selection)
{
    CHECK(n >= 1 && k >= 1);
    EstimateOf<C> estimate;
    if (!(N > 0) || !fraction.reuses()) {
        for (uint32_t j = 0; j < n; ++j)
            trace(estimate, change, drawFresh(estimate, change, n, candidates));
        return estimate;
    }
    addOld(estimate, change, old, N, fraction);
    for (uint32_t j = 0; j < n; ++j) {
        trace(estimate, change,
              drawResidual(estimate, change, n, k, fraction, candidates, selection));
    }
    return estimate;
}

/// Multiple importance sampling of old and new samples by the balance heuristic: f / (N q + n p)
/// each.
template <Change C, class Random>
EstimateOf<C> balanceHeuristic(const C& change, std::span<const typename C::Point> old,
                               typename C::Real N, uint32_t n, Random& candidates)
{
    using Real = typename C::Real;
    struct {
        Real operator()() const { return 0; }
    } always;  // a single candidate is always the pick
    return reweightingAugmentation(
        change, old, N, n, 1, BalanceFraction<Real>{N, static_cast<Real>(n)}, candidates, always);
}

/// R-A whose fraction is known only where a ray has been: alpha(y) = alpha_0(y) rho(y), with rho in
/// [0, 1] a function of the point and what the ray found. Candidates are resampled with max(1 -
/// alpha_0, leastOmega), and the traced one is paid for the difference. leastOmega > 0, or what rho
/// takes from old samples is lost where alpha_0 = 1.
template <Change C, class Fraction, class Rho, class RandomA, class RandomB>
EstimateOf<C> postTraceReweightingAugmentation(const C& change,
                                               std::span<const typename C::Point> old,
                                               typename C::Real N, uint32_t n, uint32_t k,
                                               const Fraction& fraction, const Rho& rho,
                                               typename C::Real leastOmega, RandomA& candidates,
                                               RandomB& selection)
{
    using Real = typename C::Real;
    CHECK(n >= 1 && k >= 1 && N > 0);
    EstimateOf<C> estimate;
    for (const typename C::Point& x : old) {
        const auto [q, p] = densitiesAt(change, x, estimate);
        const Real u = fraction.alphaOverQ(q, p) * rho(x) / N;
        if (u > 0) estimate.add(u, p, change.f(x));
    }
    for (uint32_t j = 0; j < n; ++j) {
        const Draw<C> draw =
            drawResidual(estimate, change, n, k, fraction, candidates, selection, leastOmega);
        if (!(draw.u > 0)) continue;
        ++estimate.rays;
        const auto [q, p] = densitiesAt(change, draw.y, estimate);
        const Real share = 1 - fraction.alpha(q, p) * rho(draw.y);
        estimate.add(draw.u * share / draw.omega, draw.p, change.f(draw.y));
    }
    return estimate;
}

/// R-A by thinning: `candidates` M of p, each traced with probability 1 - alpha at c = N / M. The
/// traced are exact samples of the residual density, M R(c) of them on average. Unbiased; no
/// resampling, no residual mass, a random number of rays.
template <Change C, class RandomA, class RandomB>
EstimateOf<C>
thinnedReweightingAugmentation(const C& change, std::span<const typename C::Point> old,
                               typename C::Real N, uint32_t M, RandomA& candidates, RandomB& coins)
{
    using Real = typename C::Real;
    CHECK(M >= 1 && N > 0);
    EstimateOf<C> estimate;
    const Real size = static_cast<Real>(M);
    const MinimumFraction<Real> fraction{N / size};
    addOld(estimate, change, old, N, fraction);
    for (uint32_t t = 0; t < M; ++t) {
        const typename C::Point z = change.sampleP(candidates);
        const auto [q, p] = densitiesAt(change, z, estimate);
        if (!(uniform<Real>(coins) < 1 - fraction.alpha(q, p)) || !shared::usableDensity(p))
            continue;
        ++estimate.rays;
        estimate.add(1 / (size * p), p, change.f(z));
    }
    return estimate;
}

/// The best c for N old and n new samples, from `k` <= kReuseMaxCandidates candidates that are used
/// for nothing else: resampling the residual with the same ones would be biased.
template <Change C, class Random>
typename C::Real solveCFromCandidates(const C& change, typename C::Real N, uint32_t n, uint32_t k,
                                      Random& candidates)
{
    using Real = typename C::Real;
    CHECK(n >= 1 && k >= 1 && k <= shared::kReuseMaxCandidates);
    std::array<Real, shared::kReuseMaxCandidates> ratios;
    for (uint32_t t = 0; t < k; ++t) {
        const typename C::Point z = change.sampleP(candidates);
        ratios[t] = shared::reuseRatio<Real>(change.q(z), change.p(z));
    }
    return shared::reuseSolveC(N, static_cast<Real>(n), ratios.data(), k);
}

}  // namespace core::reuse
