// Effective sample sizes: of weights (A. Kong, "A Note on Importance Sampling using Standardized
// Weights", 1992) and the surrogate from contributions. For allocation and health, never as an
// error bar: they know nothing of how f and the weights go together (V. Elvira, L. Martino, C.
// Robert, "Rethinking the Effective Sample Size", 2018).
#pragma once

#include <cstddef>
#include <span>

namespace core::reuse {

/// (sum w)^2 / sum w^2 from both sums; 0 without weights.
template <class Real> Real effectiveSampleSize(Real sum, Real squares)
{
    return squares > 0 ? sum * sum / squares : 0;
}

/// (sum w)^2 / sum w^2, between 1 and the number of weights, whatever their scale; 0 when all are
/// 0. Of weights v it is the number of equally weighted samples with the same variance of their
/// sum; of contributions x it is the surrogate "ESS-hat", 1 / (relative variance of their mean + 1
/// / N).
template <class Real> Real effectiveSampleSize(std::span<const Real> weights)
{
    Real largest = 0;
    for (const Real w : weights) largest = w > largest ? w : largest;
    if (!(largest > 0)) return 0;
    Real sum = 0, squares = 0;
    for (const Real w : weights) {
        const Real scaled = w / largest;  // squares of extreme weights overflow or vanish
        sum += scaled;
        squares += scaled * scaled;
    }
    return effectiveSampleSize(sum, squares);
}

/// Relative variance of the mean of N contributions, 1 / ESS - 1 / N, exactly (population
/// variance).
template <class Real> Real relativeVarianceOfMean(std::span<const Real> contributions)
{
    const Real ess = effectiveSampleSize(contributions);
    return ess > 0 ? 1 / ess - 1 / static_cast<Real>(contributions.size()) : 0;
}

}  // namespace core::reuse
