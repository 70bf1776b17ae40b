// A path guide as both languages read it: where a path is (which leaf), which directions are worth
// going there (sampling and density), and how much light the place reflects. T. Mueller, M. Gross,
// J. Novak, "Practical Path Guiding for Efficient Light-Transport Simulation" (2017). What differs:
// a spatial tree for each dominant axis of the normal, planes wherever the records' mean lay,
// directions on the octahedral square, a fixed grid of 16x16 cells with sums over quarters above
// it, and the target f |cos| L rather than L: surfaces of one leaf look the same way, so that their
// cosine, and most of their f, is a function of the direction, too. How it is learnt:
// core/guiding/guide.h.
#ifndef REKINDLE_SHARED_GUIDE_H
#define REKINDLE_SHARED_GUIDE_H

#include "lang.h"
#include "warp.h"

SHARED_BEGIN

// Nodes: the first two words are the six roots. A reference is the index of a node's word, or of a
// leaf with the highest bit set. A node: where its plane is (as a float), its axis, the reference
// below the plane and that above.
SHARED_CONST uint kGuideLeafBit = 0x80000000u;
SHARED_CONST uint kGuideRoots = 6u;
SHARED_CONST uint kGuideRootWords = 2u;

// Directions: quarters of the square, four levels of them; each word holds the masses of the four
// quarters of one cell. Cells of a level are in Morton order, the finest level begins at the last
// of these.
SHARED_CONST uint kGuideLevels = 4u;
SHARED_CONST uint kGuideSide = 16u;  // cells of the finest level in a row
SHARED_CONST uint kGuideFinest = 21u;
SHARED_CONST uint kGuideQuads = 85u;  // words of one leaf

#ifdef __cplusplus

/// Pointers into core::guiding::GuideTables, which must outlive it.
struct GuideView {
    const uvec4* nodes;
    const uvec4* leaves;
    const vec4* quads;
};

inline uvec4 fetchGuideNode(const GuideView& guide, uint i)
{
    return guide.nodes[i];
}

inline uvec4 fetchGuideLeaf(const GuideView& guide, uint leaf)
{
    return guide.leaves[leaf];
}

inline vec4 fetchGuideQuad(const GuideView& guide, uint i)
{
    return guide.quads[i];
}

#else

struct GuideView {
    uint unused;
};

uvec4 fetchGuideNode(GuideView guide, uint i);
uvec4 fetchGuideLeaf(GuideView guide, uint leaf);
vec4 fetchGuideQuad(GuideView guide, uint i);

#endif

/// What is known of a place. `share` is that of the BSDF among sampled directions: 1 where the
/// guide is of no use. `reflected` is the mean of what leaves its surfaces, light that comes
/// straight from emitters included, as luminance: 0 while nothing is known.
struct GuideLeaf {
    uint index;
    uint firstQuad;
    float share;
    float reflected;
};

/// The tree for a surface whose normal is n: 0 to 5 for +x, -x, +y, -y, +z, -z, by its largest
/// component.
SHARED_FN uint guideRoot(vec3 n)
{
    const vec3 a = abs(n);
    if (a.x >= a.y && a.x >= a.z) return n.x < 0.0f ? 1u : 0u;
    if (a.y >= a.z) return n.y < 0.0f ? 3u : 2u;
    return n.z < 0.0f ? 5u : 4u;
}

/// Index of the leaf at p in one of the trees.
SHARED_FN uint findGuideLeaf(IN(GuideView) guide, vec3 p, uint root)
{
    const uvec4 word = fetchGuideNode(guide, root >> 2u);
    const uint k = root & 3u;
    uint reference = k == 0u ? word.x : (k == 1u ? word.y : (k == 2u ? word.z : word.w));
    while ((reference & kGuideLeafBit) == 0u) {
        const uvec4 node = fetchGuideNode(guide, reference);
        const float x = node.y == 0u ? p.x : (node.y == 1u ? p.y : p.z);
        reference = x < uintAsFloat(node.x) ? node.z : node.w;
    }
    return reference & ~kGuideLeafBit;
}

/// What is known at p of surfaces that look towards n (unit, on the side the light comes from).
SHARED_FN GuideLeaf guideAt(IN(GuideView) guide, vec3 p, vec3 n)
{
    GuideLeaf leaf;
    leaf.index = findGuideLeaf(guide, p, guideRoot(n));
    const uvec4 word = fetchGuideLeaf(guide, leaf.index);
    leaf.firstQuad = word.x;
    leaf.share = uintAsFloat(word.y);
    leaf.reflected = uintAsFloat(word.z);
    return leaf;
}

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

/// Density with which sampleGuide draws the direction wi (unit, world), in solid angle.
SHARED_FN float pdfGuide(IN(GuideView) guide, GuideLeaf leaf, vec3 wi)
{
    const vec2 p = guideSquare(wi) * float(kGuideSide);
    const uint last = kGuideSide - 1u;
    const uint cell =
        guideCell(uvec2(min(uint(max(p.x, 0.0f)), last), min(uint(max(p.y, 0.0f)), last)));
    const vec4 masses = fetchGuideQuad(guide, leaf.firstQuad + kGuideFinest + (cell >> 2u));
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

/// Draws a direction (unit, world) for u in [0,1)^2, one pair for all levels so that its
/// stratification survives; `pdf` in solid angle. False where the leaf knows no light.
SHARED_FN bool sampleGuide(IN(GuideView) guide, GuideLeaf leaf, vec2 u, OUT(vec3) wi,
                           OUT(float) pdf)
{
    uint cell = 0u;
    uint first = leaf.firstQuad;
    uvec2 at = uvec2(0u, 0u);
    float mass = 0.0f;
    for (uint level = 0u; level < kGuideLevels; ++level) {
        const vec4 masses = fetchGuideQuad(guide, first + cell);
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
