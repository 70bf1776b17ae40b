// The fraction alpha of the new integral that old samples answer for. Any function of the point
// with values in [0, 1] that is 0 where no old sample could be keeps R-A unbiased, provided that
// the same one is evaluated at old samples and at candidates: these are all there are.
#pragma once

#include "shared/reuse.h"

namespace core::reuse {

/// min(1, c q / p): Reweighting-Augmentation.
template <class Real> struct MinimumFraction {
    Real c = 0;  // 0: nothing is reused

    bool reuses() const { return c > 0; }
    Real alpha(Real q, Real p) const { return shared::reuseAlpha(c, q, p); }
    Real alphaOverQ(Real q, Real p) const { return shared::reuseAlphaOverQ(c, q, p); }
};

/// N q / (N q + n p): with a single candidate, multiple importance sampling by the balance
/// heuristic (E. Veach, L. Guibas, "Optimally Combining Sampling Techniques for Monte Carlo
/// Rendering", 1995).
template <class Real> struct BalanceFraction {
    Real N = 0, n = 1;

    bool reuses() const { return N > 0; }
    Real alpha(Real q, Real p) const
    {
        if (!shared::usableDensity(q) || !shared::usableDensity(p)) return 0;
        return q > p ? N / (N + n * (p / q)) : N * (q / p) / (N * (q / p) + n);
    }
    Real alphaOverQ(Real q, Real p) const
    {
        if (!shared::usableDensity(q) || !shared::usableDensity(p)) return 0;
        return N / (N * q + n * p);
    }
};

}  // namespace core::reuse
