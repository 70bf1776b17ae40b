// Directions of a guide's leaf as a mixture of eight von Mises-Fisher lobes, densities proportional
// to exp(kappa cos) about a mean direction. J. Vorba et al., "On-line Learning of Parametric
// Mixture Models for Light Transport Simulation" (2014); the lobe's sampling after W. Jakob,
// "Numerically stable sampling of the von Mises-Fisher distribution on S2 (and other tricks)"
// (2012). What differs: cosines by the chord and no difference of near numbers, so that lobes from
// the whole sphere to a hundredth of a radian keep their precision; the concentric disk in place of
// sine and cosine.
#ifndef REKINDLE_SHARED_GUIDE_LOBES_H
#define REKINDLE_SHARED_GUIDE_LOBES_H

#include "guide_tables.h"
#include "warp.h"

SHARED_BEGIN

SHARED_CONST uint kLobeCount = 8u;

// Words of a leaf, two of each kind, four lobes in each word: mean directions (x, y, z), kappa / 2,
// the density at the mean direction, the lobe's probability.
SHARED_CONST uint kLobeX = 0u;
SHARED_CONST uint kLobeY = 2u;
SHARED_CONST uint kLobeZ = 4u;
SHARED_CONST uint kLobeWidth = 6u;
SHARED_CONST uint kLobePeak = 8u;
SHARED_CONST uint kLobeMass = 10u;
SHARED_CONST uint kLobeWords = 12u;

SHARED_CONST float kLeastKappa = 1.0e-5f;  // below, a lobe is as good as the whole sphere

/// 1 - exp(-x) for x >= 0.
SHARED_FN float oneMinusExp(float x)
{
    const float series = x * (1.0f - x * (0.5f - x * (0.16666667f - x * 0.041666667f)));
    return x < 0.05f ? series : 1.0f - exp(-x);
}

/// The density of a lobe at its mean direction.
SHARED_FN float peakOfLobe(float kappa)
{
    const float k = max(kappa, kLeastKappa);
    return 0.5f * kInvPi * k / oneMinusExp(2.0f * k);
}

/// 1 - cos of the angle from the mean direction within which a lobe has the share x of its mass.
SHARED_FN float heightOfLobe(float kappa, float x)
{
    const float k = max(kappa, kLeastKappa);
    const float z = x * oneMinusExp(2.0f * k);
    // -log(1 - z); far out the last sample of 2^24 stands for all beyond it
    const float series = z * (1.0f + z * (0.5f + z * (0.33333333f + z * 0.25f)));
    const float outside = max((1.0f - x) + x * exp(-2.0f * k), 5.0e-8f);
    return min((z < 0.05f ? series : -log(outside)) / k, 2.0f);
}

/// A direction of the lobe about +z. The disk's radius becomes the angle, strata stay compact.
SHARED_FN vec3 sampleGuideLobe(float kappa, vec2 u)
{
    const vec2 p = sampleDisk(u);
    const float square = min(dot(p, p), 1.0f);
    const float height = heightOfLobe(kappa, square);
    const float across = sqrt(height * (2.0f - height));
    const float stretch = square > 0.0f ? across / sqrt(square) : 0.0f;
    return vec3(p.x * stretch, p.y * stretch, 1.0f - height);
}

/// exp(-x) within 3e-7 of itself, 0 from 2^7 log 2 on, for x from 0 to 10^9: in a form of which
/// compilers make vectors.
SHARED_FN float expMinus(float x)
{
    const float y = x * 1.442695041f;
    const int n = int(y + 0.5f);
    const float f = (float(n) - y) * 0.6931471806f;
    const float tail = 0.041666667f + f * (0.0083333333f + f * 0.0013888889f);
    const float p = 1.0f + f * (1.0f + f * (0.5f + f * (0.16666667f + f * tail)));
    return p * uintAsFloat(uint(max(127 - n, 0)) << 23u);
}

/// Density with which sampleGuideLobes draws wi, in solid angle; `first` is the leaf's first word.
SHARED_FN float pdfGuideLobes(IN(GuideView) guide, uint first, vec3 wi)
{
    const LobeRow x = fetchLobeRow(guide, first + kLobeX);
    const LobeRow y = fetchLobeRow(guide, first + kLobeY);
    const LobeRow z = fetchLobeRow(guide, first + kLobeZ);
    const LobeRow width = fetchLobeRow(guide, first + kLobeWidth);
    const LobeRow peak = fetchLobeRow(guide, first + kLobePeak);
    float density[8];
    for (uint k = 0u; k < kLobeCount; ++k) {
        const float dx = x.v[k] - wi.x;
        const float dy = y.v[k] - wi.y;
        const float dz = z.v[k] - wi.z;
        // The square of a chord is twice 1 - cos.
        density[k] = peak.v[k] * expMinus(width.v[k] * (dx * dx + dy * dy + dz * dz));
    }
    return ((density[0] + density[1]) + (density[2] + density[3])) +
           ((density[4] + density[5]) + (density[6] + density[7]));
}

SHARED_FN float fourthOf(vec4 v, uint k)
{
    return k == 0u ? v.x : (k == 1u ? v.y : (k == 2u ? v.z : v.w));
}

/// Draws a direction for u in [0,1)^2, one pair for the choice of the lobe and the direction. False
/// where the leaf knows no light.
SHARED_FN bool sampleGuideLobes(IN(GuideView) guide, uint first, vec2 u, OUT(vec3) wi)
{
    const vec4 lower = fetchGuideDirections(guide, first + kLobeMass);
    const vec4 upper = fetchGuideDirections(guide, first + kLobeMass + 1u);
    const float below = (lower.x + lower.y) + (lower.z + lower.w);
    const bool isUpper = u.x >= below;
    const vec4 masses = isUpper ? upper : lower;
    const float x = isUpper ? u.x - below : u.x;
    const vec4 sums = vec4(0.0f, masses.x, masses.x + masses.y, masses.x + masses.y + masses.z);
    const uint k = (x >= sums.y ? 1u : 0u) + (x >= sums.z ? 1u : 0u) + (x >= sums.w ? 1u : 0u);
    const float mass = fourthOf(masses, k);
    const float inLobe = mass > 0.0f ? (x - fourthOf(sums, k)) / mass : 0.0f;

    const uint word = first + (isUpper ? 1u : 0u);
    const vec3 mean = vec3(fourthOf(fetchGuideDirections(guide, word + kLobeX), k),
                           fourthOf(fetchGuideDirections(guide, word + kLobeY), k),
                           fourthOf(fetchGuideDirections(guide, word + kLobeZ), k));
    const float width = fourthOf(fetchGuideDirections(guide, word + kLobeWidth), k);
    const vec3 local =
        sampleGuideLobe(2.0f * width, vec2(clamp(inLobe, 0.0f, kOneMinusEpsilon), u.y));
    wi = toWorld(makeFrame(mean), local);
    return mass > 0.0f;
}

SHARED_END

#endif
