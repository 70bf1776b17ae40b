// Sample reuse when the density has changed from q to p: the fraction alpha of
// Reweighting-Augmentation and selection by thresholds, which the renderers use, and streaming RIS
// and the solver for c, which only the estimators of core/reuse do (a renderer's c is N / (N + n),
// and its candidates are drawn in reuse_new.h). After S. Wang, "Efficient Sample Usage in
// Photo-Realistic Rendering" (2022), chapter 7, and J. Talbot, D. Cline, P. Egbert, "Importance
// Resampling for Global Illumination" (2005). What differs from the thesis: c as solved is the root
// of c n = N R(c), and alpha is one function of (q, p), evaluated alike for old samples and
// candidates.
//
//   N, n   old samples (a nominal count), new samples (rays)
//   M      N / c, the size of their union
//   q, p   old and new density at one point of the new domain, per unit of the same measure
//   alpha  min(1, c q / p): the share of the new integral that old samples answer for
//   omega  1 - alpha: the resampling weight of a candidate drawn from p
//   u      absolute weight of a sample: E[sum u_i h(x_i)] = integral of h
//   v      u p, dimensionless, of mean sum one
//
// Functions over Real exist in GLSL for float, in C++ for float and double, in which references
// run.
#ifndef REKINDLE_SHARED_REUSE_H
#define REKINDLE_SHARED_REUSE_H

#include "lang.h"

#ifdef __cplusplus
#define REAL_FN template <class Real> SHARED_FN
#define REAL_STRUCT template <class Real>
#define OF_REAL(T) T<Real>
#define REAL_ARRAY(name, size) const Real* name
#else
#define Real float  // only in kernels that include this header
#define REAL_FN
#define REAL_STRUCT
#define OF_REAL(T) T
#define REAL_ARRAY(name, size) float name[size]
#endif

SHARED_BEGIN

SHARED_CONST float kReuseLeastC = 1e-6f;      // below it history is not worth its loop: discard
SHARED_CONST uint kReuseMaxCandidates = 16u;  // of the batch that c is solved on
#ifndef REKINDLE_MOST_SCORES
#define REKINDLE_MOST_SCORES 48u  // kernels know how many there are
#endif
SHARED_CONST uint kReuseMostScores = REKINDLE_MOST_SCORES;  // of a store that is cut down

SHARED_CONST float kReuseLeastDensity = 1.1754943508e-38f;  // the reciprocal is still a number

/// Whether a density can be worked with: positive, finite, a number. Deltas are none and never
/// reused; denormal numbers are none either, since devices may take them for 0.
REAL_FN bool usableDensity(Real density)
{
    return density >= Real(kReuseLeastDensity) && density < Real(kInfinity);
}

/// Whether a density is a mistake of whoever computed it: negative, infinite or not a number. To be
/// counted.
REAL_FN bool faultyDensity(Real density)
{
    return !(density >= Real(0.0f) && density < Real(kInfinity));
}

/// alpha in [0, 1]; 0 where either density is unusable or c is not positive.
REAL_FN Real reuseAlpha(Real c, Real q, Real p)
{
    if (!usableDensity(q) || !usableDensity(p) || !usableDensity(c)) {
        return Real(0.0f);
    }
    Real cq = c * q;
    return cq >= p ? Real(1.0f) : cq / p;
}

/// alpha / q without the division by a density that may be tiny: 1 / max(q, p / c). An old sample
/// of one step contributes f times this over N. 0 where alpha is.
REAL_FN Real reuseAlphaOverQ(Real c, Real q, Real p)
{
    if (!usableDensity(q) || !usableDensity(p) || !usableDensity(c)) {
        return Real(0.0f);
    }
    return Real(1.0f) / max(q, p / c);
}

/// q / p of a candidate z ~ p, for solveC; 0 (nothing to reuse there) where either is unusable. At
/// most kInfinity.
REAL_FN Real reuseRatio(Real q, Real p)
{
    return usableDensity(q) && usableDensity(p) ? min(q / p, Real(kInfinity)) : Real(0.0f);
}

/// Resampled importance sampling of one among k candidates, which come one by one.
REAL_STRUCT struct Ris {
    Real sum;    // of the weights so far
    Real omega;  // of the one picked
    Real p;      // its density; 0 while none is picked
    uint pick;   // its number
};

REAL_FN void risStart(OUT(OF_REAL(Ris)) r)
{
    r.sum = Real(0.0f);
    r.omega = Real(0.0f);
    r.p = Real(0.0f);
    r.pick = 0u;
}

/// Offers candidate `id` of weight omega and density p; xi is uniform in [0, 1). Returns whether it
/// is the pick now. What has no usable density or no positive weight never wins, and counts as a
/// candidate of weight 0.
REAL_FN bool risAdd(INOUT(OF_REAL(Ris)) r, Real omega, Real p, uint id, Real xi)
{
    if (!usableDensity(omega) || !usableDensity(p)) {
        return false;
    }
    r.sum += omega;
    if (xi * r.sum < omega) {
        r.omega = omega;
        r.p = p;
        r.pick = id;
        return true;
    }
    return false;
}

/// The absolute weight u of the pick among k candidates, when n such picks are made: (sum / k) / (n
/// p), to be multiplied by f (RIS of the residual has the target omega p, which cancels to this). 0
/// when none was picked.
REAL_FN Real risWeight(OF_REAL(Ris) r, Real k, Real n)
{
    return usableDensity(r.p) ? r.sum / (k * n * r.p) : Real(0.0f);
}

/// One step of Newton's method towards c n = N R(c), for R the mean of (1 - c r_t)+ over k ratios
/// r_t = q / p at candidates of p: from the number and the sum of those with c r_t < 1. No step
/// overshoots, and since R is piecewise linear the last one is exact.
REAL_FN Real reuseNextC(Real N, Real n, Real k, Real liveCount, Real liveSum)
{
    return N * liveCount / (k * n + N * liveSum);
}

/// The root of c n = N R(c) for R as above, in [kReuseLeastC, N / n]; 0 when N is 0. The candidates
/// must not be those that the residual is then sampled with: that would be biased. 1 <= k <=
/// kReuseMaxCandidates.
REAL_FN Real reuseSolveC(Real N, Real n, REAL_ARRAY(ratios, kReuseMaxCandidates), uint k)
{
    if (!usableDensity(N)) {
        return Real(0.0f);
    }
    Real c = Real(kReuseLeastC);  // not 0: there the sum over all ratios may overflow
    uint before = k + 1u;
    for (uint step = 0u; step <= k; ++step) {
        uint live = 0u;
        Real sum = Real(0.0f);
        for (uint t = 0u; t < k; ++t) {
            if (c * ratios[t] < Real(1.0f)) {
                ++live;
                sum += ratios[t];
            }
        }
        if (live == before) {
            break;  // the set did not shrink: c solves it exactly
        }
        before = live;
        c = max(c, reuseNextC(N, n, Real(k), Real(live), sum));  // less only by rounding
    }
    return min(c, N / n);
}

/// The kappa with sum min(1, a_i / kappa) = keep over `count` scores; 0 when no more than `keep` of
/// them are positive (then all of these stay). What reaches kappa leaves the sum until nothing more
/// does, which is exact and needs no sorting. keep >= 1.
REAL_FN Real reuseThreshold(REAL_ARRAY(scores, kReuseMostScores), uint count, uint keep)
{
    Real kappa = Real(kInfinity);
    uint before = count + 1u;
    for (uint pass = 0u; pass <= count + 1u; ++pass) {
        uint light = 0u;
        uint heavy = 0u;
        Real sum = Real(0.0f);
        for (uint i = 0u; i < count; ++i) {
            if (!usableDensity(scores[i])) continue;
            if (scores[i] < kappa) {
                ++light;
                sum += scores[i];
            } else {
                ++heavy;
            }
        }
        if (light + heavy <= keep) return Real(0.0f);
        // None has left the sum; or rounding only: the light ones together weigh nothing.
        if (light == before || heavy >= keep) break;
        before = light;
        kappa = sum / Real(keep - heavy);
    }
    return kappa;
}

/// Threshold resampling in one pass (Fearnhead & Clifford, 2003): items of score a are kept with
/// probability min(1, a / kappa) by systematic sampling, where kappa makes these sum to K: then
/// exactly K are kept. Kept items multiply their u by reuseKeepScale. `xi` uniform in [0, 1), one
/// for all items; `sum` starts at 0. What has no usable score is never kept.
REAL_FN bool reuseKeep(INOUT(Real) sum, Real score, Real kappa, Real xi)
{
    if (!usableDensity(score)) {
        return false;
    }
    if (score >= kappa) {
        return true;  // a whole step leaves the phase as it is
    }
    Real before = sum;
    sum += score / kappa;
    return floor(sum - xi) != floor(before - xi);
}

REAL_FN Real reuseKeepScale(Real score, Real kappa)
{
    return usableDensity(score) && score < kappa ? min(kappa / score, Real(kInfinity)) : Real(1.0f);
}

SHARED_END

#endif
