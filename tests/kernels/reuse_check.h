// Every function of shared/reuse.h and shared/rgbe.h on one record of inputs: compiled for the
// device and for the host, whose answers must agree.
#ifndef REKINDLE_TESTS_REUSE_CHECK_H
#define REKINDLE_TESTS_REUSE_CHECK_H

#include "shared/reuse.h"
#include "shared/rgbe.h"

SHARED_BEGIN

/// Densities, weights and scores may have any value; xi and kappa are valid.
struct ReuseCheckInput {
    float c;
    float N;
    float n;
    uint k;
    float q[kReuseMaxCandidates];
    float p[kReuseMaxCandidates];
    float weight[kReuseMaxCandidates];  // for a second RIS, which does not take 1 - alpha
    float xi[kReuseMaxCandidates];
    float kappa;
    vec3 colour;
};

struct RisCheck {
    float sum;
    float omega;
    float p;
    float u;
    uint pick;
    uint accepted;  // a bit per candidate that was the pick when it came
};

struct ReuseCheckOutput {
    uint usable;  // a bit per q and, above, per p
    uint faulty;
    float alpha;
    float alphaOverQ;
    float ratio;
    float nextC;
    float solvedC;
    RisCheck residual;
    RisCheck weighted;
    uint kept;  // a bit per candidate, by threshold on `weight`
    float keepSum;
    float keepScale;
    uint rounded;
    uint nearest;
    vec3 unpacked;
};

REAL_FN RisCheck checkRis(REAL_ARRAY(omegas, kReuseMaxCandidates),
                          REAL_ARRAY(densities, kReuseMaxCandidates),
                          REAL_ARRAY(xis, kReuseMaxCandidates), uint k, Real n)
{
    OF_REAL(Ris) ris;
    risStart(ris);
    RisCheck r;
    r.accepted = 0u;
    for (uint t = 0u; t < k; ++t) {
        r.accepted |= risAdd(ris, omegas[t], densities[t], t, xis[t]) ? 1u << t : 0u;
    }
    r.sum = ris.sum;
    r.omega = ris.omega;
    r.p = ris.p;
    r.pick = ris.pick;
    r.u = risWeight(ris, Real(k), n);
    return r;
}

SHARED_FN ReuseCheckOutput checkReuse(ReuseCheckInput a)
{
    ReuseCheckOutput r;
    r.alpha = reuseAlpha(a.c, a.q[0], a.p[0]);
    r.alphaOverQ = reuseAlphaOverQ(a.c, a.q[0], a.p[0]);
    r.ratio = reuseRatio(a.q[0], a.p[0]);
    r.usable = 0u;
    r.faulty = 0u;
    float omegas[kReuseMaxCandidates];
    float ratios[kReuseMaxCandidates];
    float live = 0.0f;
    float liveSum = 0.0f;
    r.kept = 0u;
    r.keepSum = 0.0f;
    for (uint t = 0u; t < a.k; ++t) {
        r.usable |=
            (usableDensity(a.q[t]) ? 1u << t : 0u) | (usableDensity(a.p[t]) ? 65536u << t : 0u);
        r.faulty |=
            (faultyDensity(a.q[t]) ? 1u << t : 0u) | (faultyDensity(a.p[t]) ? 65536u << t : 0u);
        omegas[t] = 1.0f - reuseAlpha(a.c, a.q[t], a.p[t]);
        ratios[t] = reuseRatio(a.q[t], a.p[t]);
        if (ratios[t] < 1.0e6f) {
            live += 1.0f;
            liveSum += ratios[t];
        }
        r.kept |= reuseKeep(r.keepSum, a.weight[t], a.kappa, a.xi[0]) ? 1u << t : 0u;
    }
    r.keepScale = reuseKeepScale(a.weight[0], a.kappa);
    r.nextC = reuseNextC(a.N, a.n, float(a.k), live, liveSum);
    r.solvedC = reuseSolveC(a.N, a.n, ratios, a.k);
    r.residual = checkRis(omegas, a.p, a.xi, a.k, a.n);
    r.weighted = checkRis(a.weight, a.p, a.xi, a.k, a.n);
    r.rounded = packRgbe(a.colour, vec3(a.xi[0], a.xi[1], a.xi[2]));
    r.nearest = packRgbeNearest(a.colour);
    r.unpacked = unpackRgbe(r.rounded);
    return r;
}

SHARED_END

#endif
