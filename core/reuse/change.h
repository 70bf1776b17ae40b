// What the estimators of sample reuse are generic over, and what they return. Symbols as in
// shared/reuse.h.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>

#include "core/base/pcg32.h"
#include "core/reuse/ess.h"
#include "shared/reuse.h"

namespace core::reuse {

/// A change of density, over points of any domain with any measure (an interval, directions, pixel
/// x direction):
///   Real q(x), p(x)   old and new density per unit of the measure; p > 0 wherever f is not zero
///   Point sampleP(r)  a point of exactly that p; r() is uniform in [0, 1)
///   Value f(x)        the integrand: a number, a colour, ... ; the only thing that costs a ray
/// Points may carry what is already known of them, such as the stored radiance of an old sample.
template <class C>
concept Change = std::floating_point<typename C::Real> &&
    requires(const C& change, const typename C::Point& x, Pcg32& random)
{
    {
        change.q(x)
        } -> std::convertible_to<typename C::Real>;
    {
        change.p(x)
        } -> std::convertible_to<typename C::Real>;
    {
        change.f(x)
        } -> std::convertible_to<typename C::Value>;
    {
        change.sampleP(random)
        } -> std::convertible_to<typename C::Point>;
};

/// What an estimator found: the sum of u_i f(x_i), and what is known of its weights and its cost.
template <class Real, class Value> struct Estimate {
    Value value{};             // of the integral of f
    double weightSum = 0;      // sum of v_i: its mean is one where all of p is accounted for
    double weightSquares = 0;  // sum of v_i^2, which may leave the range of float
    uint32_t rays = 0;         // new evaluations of f
    uint32_t densities = 0;    // pairs (q, p) evaluated
    uint32_t faults = 0;       // densities that were negative, infinite or NaN: must stay 0

    /// Adds a sample of absolute weight u.
    void add(Real u, Real p, const Value& f)
    {
        value += f * u;
        if (!shared::usableDensity(p)) return;  // reweighting does not need p
        const double v = static_cast<double>(u * p);
        weightSum += v;
        weightSquares += v * v;
    }

    /// Effective sample size of the weights (Kong 1992); 0 without samples.
    double ess() const { return effectiveSampleSize(weightSum, weightSquares); }

    /// Takes out the noise of the weights themselves: value - beta (sum v - 1). Unbiased when
    /// `beta`, the expected value, comes from samples independent of these.
    Value corrected(const Value& beta) const
    {
        Value result = value;
        result += beta * static_cast<Real>(1 - weightSum);
        return result;
    }

    /// The same with its own mean as beta: value / sum v. Biased by O(1 / ESS); zero without
    /// samples.
    Value selfNormalised() const
    {
        return weightSum > 0 ? value * static_cast<Real>(1 / weightSum) : Value{};
    }
};

template <Change C> using EstimateOf = Estimate<typename C::Real, typename C::Value>;

/// Uniform in [0, 1) whatever the precision: rounding to float must not reach one.
template <std::floating_point Real, class Random> Real uniform(Random& random)
{
    return std::min(static_cast<Real>(random()), static_cast<Real>(shared::kOneMinusEpsilon));
}

/// Both densities at x, counted.
template <class Real> struct Densities {
    Real q, p;
};

template <Change C>
Densities<typename C::Real> densitiesAt(const C& change, const typename C::Point& x,
                                        EstimateOf<C>& estimate)
{
    const Densities<typename C::Real> d{change.q(x), change.p(x)};
    ++estimate.densities;
    if (shared::faultyDensity(d.q) || shared::faultyDensity(d.p)) ++estimate.faults;
    return d;
}

}  // namespace core::reuse
