// Directions of a guide's leaf as a histogram on the octahedral square: a fixed grid of 16x16 cells
// with sums over quarters above it, down which samples go. An octahedron has no seam but the
// square's rim and needs no trigonometry.
#ifndef REKINDLE_SHARED_GUIDE_HISTOGRAM_H
#define REKINDLE_SHARED_GUIDE_HISTOGRAM_H

#include "guide_tables.h"
#include "warp.h"

SHARED_BEGIN

// Quarters of the square, four levels of them; each word holds the masses of the four quarters of
// one cell. Cells of a level are in Morton order, the finest level begins at the last of these.
SHARED_CONST uint kGuideLevels = 4u;
SHARED_CONST uint kGuideSide = 16u;  // cells of the finest level in a row
SHARED_CONST uint kGuideFinest = 21u;
SHARED_CONST uint kHistogramWords = 85u;

/// The unit square on which directions are learnt, without a seam but for its rim.
SHARED_FN vec2 guideSquare(vec3 wi)
{
    return octEncode(wi) * 0.5f + vec2(0.5f);
}

/// Solid angle takes this many times the density of the square.
SHARED_FN float guideJacobian(vec3 wi)
{
    const float s = abs(wi.x) + abs(wi.y) + abs(wi.z);
    return 1.0f / (4.0f * s * s * s);
}

/// The four low bits of x, two apart.
SHARED_FN uint spreadBits(uint x)
{
    const uint y = (x | (x << 2u)) & 0x33u;
    return (y | (y << 1u)) & 0x55u;
}

/// Index of a cell of the finest level in Morton order.
SHARED_FN uint guideCell(uvec2 cell)
{
    return spreadBits(cell.x) | (spreadBits(cell.y) << 1u);
}

/// Density with which sampleHistogram draws wi, in solid angle; `first` is the leaf's first word.
SHARED_FN float pdfHistogram(IN(GuideView) guide, uint first, vec3 wi)
{
    const vec2 p = guideSquare(wi) * float(kGuideSide);
    const uint last = kGuideSide - 1u;
    const uint cell =
        guideCell(uvec2(min(uint(max(p.x, 0.0f)), last), min(uint(max(p.y, 0.0f)), last)));
    const vec4 masses = fetchGuideDirections(guide, first + kGuideFinest + (cell >> 2u));
    const uint k = cell & 3u;
    const float mass = k == 0u ? masses.x : (k == 1u ? masses.y : (k == 2u ? masses.z : masses.w));
    return mass * float(kGuideSide * kGuideSide) * guideJacobian(wi);
}

/// Picks the half of a cell that u falls into, the lower one with probability `lower`, and leaves
/// in u where in the half it is.
SHARED_FN uint pickHalf(float lower, INOUT(float) u)
{
    const bool upper = u >= lower;
    u = upper ? (u - lower) / (1.0f - lower) : u / lower;
    u = clamp(u, 0.0f, kOneMinusEpsilon);
    return upper ? 1u : 0u;
}

/// Draws a direction for u in [0,1)^2, one pair for all levels; `pdf` in solid angle. False where
/// the leaf knows no light.
SHARED_FN bool sampleHistogram(IN(GuideView) guide, uint firstWord, vec2 u, OUT(vec3) wi,
                               OUT(float) pdf)
{
    uint cell = 0u;
    uint first = firstWord;
    uvec2 at = uvec2(0u, 0u);
    float mass = 0.0f;
    for (uint level = 0u; level < kGuideLevels; ++level) {
        const vec4 masses = fetchGuideDirections(guide, first + cell);
        const float left = masses.x + masses.z;
        const float all = left + masses.y + masses.w;
        const uint x = pickHalf(all > 0.0f ? left / all : 0.5f, u.x);
        const float lower = x != 0u ? masses.y : masses.x;
        const float upper = x != 0u ? masses.w : masses.z;
        const uint y = pickHalf(lower + upper > 0.0f ? lower / (lower + upper) : 0.5f, u.y);
        mass = y != 0u ? upper : lower;
        at = at * 2u + uvec2(x, y);
        first += 1u << (2u * level);
        cell = 4u * cell + (x | (y << 1u));
    }
    const vec2 p = (vec2(float(at.x), float(at.y)) + u) * (2.0f / float(kGuideSide)) - vec2(1.0f);
    wi = octDecode(p);
    pdf = mass * float(kGuideSide * kGuideSide) * guideJacobian(wi);
    return pdf > 0.0f;
}

SHARED_END

#endif
