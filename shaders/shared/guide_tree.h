// Directions of a guide's leaf as a quadtree over the octahedral square, fine where light is.
// T. Mueller, M. Gross, J. Novak, "Practical Path Guiding for Efficient Light-Transport Simulation"
// (2017). What differs: the octahedron in place of the cylinder (no trigonometry, no seam), shares
// in 16 bits, and one pair of numbers for all levels, so that stratification survives.
#ifndef REKINDLE_SHARED_GUIDE_TREE_H
#define REKINDLE_SHARED_GUIDE_TREE_H

#include "guide_histogram.h"
#include "guide_tables.h"

SHARED_BEGIN

// A node is one word of the guide's nodes, one part for each quarter (bit 0 of its number is the
// half in x, bit 1 that in y): its share of the node below, in units that count relative to the
// other quarters only, and above 16 bits its own node, counted from the tree's first; 0: a leaf.
SHARED_CONST uint kGuideTreeDepth = 20u;

SHARED_FN uint guideQuarter(uvec4 node, uint k)
{
    return k == 0u ? node.x : (k == 1u ? node.y : (k == 2u ? node.z : node.w));
}

/// The shares of the quarters.
SHARED_FN vec4 guideShares(uvec4 node)
{
    return vec4(float(node.x & 0xffffu), float(node.y & 0xffffu), float(node.z & 0xffffu),
                float(node.w & 0xffffu));
}

/// Density with which sampleGuideTree draws wi, in solid angle; `first` is the tree's first node.
/// 0 where the leaf knows no light.
SHARED_FN float pdfGuideTree(IN(GuideView) guide, uint first, vec3 wi)
{
    vec2 p = guideSquare(wi);
    float density = 1.0f;
    uint at = 0u;
    for (uint level = 0u; level < kGuideTreeDepth; ++level) {
        const uvec4 node = fetchGuideNode(guide, first + at);
        const vec4 shares = guideShares(node);
        p *= 2.0f;
        const uint x = p.x >= 1.0f ? 1u : 0u;
        const uint y = p.y >= 1.0f ? 1u : 0u;
        p -= vec2(float(x), float(y));
        const uint quarter = guideQuarter(node, x | (y << 1u));
        const float all = (shares.x + shares.z) + (shares.y + shares.w);
        density *= all > 0.0f ? 4.0f * float(quarter & 0xffffu) / all : 0.0f;
        at = quarter >> 16u;
        if (at == 0u || !(density > 0.0f)) break;
    }
    return density * guideJacobian(wi);
}

/// Draws a direction for u in [0,1)^2, one pair for all levels; `pdf` in solid angle. False where
/// the leaf knows no light.
SHARED_FN bool sampleGuideTree(IN(GuideView) guide, uint first, vec2 u, OUT(vec3) wi,
                               OUT(float) pdf)
{
    vec2 corner = vec2(0.0f);
    float side = 1.0f;
    float density = 1.0f;
    uint at = 0u;
    for (uint level = 0u; level < kGuideTreeDepth; ++level) {
        const uvec4 node = fetchGuideNode(guide, first + at);
        const vec4 shares = guideShares(node);
        const float left = shares.x + shares.z;
        const float all = left + (shares.y + shares.w);
        const uint x = pickHalf(all > 0.0f ? left / all : 0.5f, u.x);
        const float lower = x != 0u ? shares.y : shares.x;
        const float upper = x != 0u ? shares.w : shares.z;
        const uint y = pickHalf(lower + upper > 0.0f ? lower / (lower + upper) : 0.5f, u.y);
        const uint quarter = guideQuarter(node, x | (y << 1u));
        density *= all > 0.0f ? 4.0f * float(quarter & 0xffffu) / all : 0.0f;
        side *= 0.5f;
        corner += side * vec2(float(x), float(y));
        at = quarter >> 16u;
        if (at == 0u || !(density > 0.0f)) break;
    }
    wi = octDecode((corner + side * u) * 2.0f - vec2(1.0f));
    pdf = density * guideJacobian(wi);
    return pdf > 0.0f;
}

SHARED_END

#endif
