// The best scale c of the old density in Reweighting-Augmentation: the root of c n = N R(c), where
// R(c) is the mass of (p - c q)+. At it the old and the residual samples are weighted by the
// balance heuristic.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "shared/reuse.h"

namespace core::reuse {

/// Probability of the set where p > c q, by p and by q. R(c) = p - c q, and R'(c) = -q.
struct Masses {
    double p = 0, q = 0;
};

/// `masses(c)` gives the masses for any c >= 0. Newton's method from c = 0: because R is convex,
/// every step stays at or below the root, and each is c <- N P / (n + N Q); the first is N / (N +
/// n) when q lies within the support of p. `kappa`: how many times noisier old contributions are
/// (conditional second moment). Result in [kReuseLeastC, N/n], accurate to rounding; 0 when there
/// is nothing to reuse (N = 0).
template <class F> double solveC(double N, double n, F&& masses, double kappa = 1)
{
    CHECK(N >= 0 && n > 0 && kappa > 0);
    if (N == 0) return 0;
    double c = 0;
    for (int i = 0; i < 100; ++i) {  // quadratic convergence: a handful suffices
        const Masses m = masses(c);
        const double next = N * m.p / (n * kappa + N * m.q);
        if (!(next > c * (1 + 1e-15))) break;
        c = next;
    }
    return std::clamp(c, double(shared::kReuseLeastC), N / (n * kappa));
}

}  // namespace core::reuse
