// A path guide as both languages read it: where a path is (which leaf), which directions are worth
// going there (sampling and density), and how much light the place reflects. T. Mueller, M. Gross,
// J. Novak, "Practical Path Guiding for Efficient Light-Transport Simulation" (2017). What differs:
// a spatial tree for each dominant axis of the normal, planes wherever the records' mean lay,
// two other representations of directions beside the paper's quadtree (guide_histogram.h,
// guide_lobes.h, guide_tree.h), and the target f |cos| L rather than L: surfaces of one leaf look
// the same way, so that their cosine, and most of their f, is a function of the direction, too. How
// it is learnt, and switches back to what the paper has: core/guiding/guide.h.
#ifndef REKINDLE_SHARED_GUIDE_H
#define REKINDLE_SHARED_GUIDE_H

#include "guide_histogram.h"
#include "guide_lobes.h"
#include "guide_tables.h"
#include "guide_tree.h"
#include "lang.h"

SHARED_BEGIN

// Nodes: the first two words are the six roots. A reference is the index of a node's word, or of a
// leaf with the highest bit set. A node: where its plane is (as a float), its axis, the reference
// below the plane and that above.
SHARED_CONST uint kGuideLeafBit = 0x80000000u;
SHARED_CONST uint kGuideRoots = 6u;
SHARED_CONST uint kGuideRootWords = 2u;

/// What is known of a place. `share` is that of the BSDF among sampled directions: 1 where the
/// guide is of no use. `reflected` is the mean of what leaves its surfaces, light that comes
/// straight from emitters included, as luminance: 0 while nothing is known.
struct GuideLeaf {
    uint index;
    uint firstWord;
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
    leaf.firstWord = word.x;
    leaf.share = uintAsFloat(word.y);
    leaf.reflected = uintAsFloat(word.z);
    return leaf;
}

/// Words of directions in a leaf of that kind of guide; those of trees differ in number, and lie
/// among the nodes.
SHARED_FN uint guideWords(uint kind)
{
    return kind == kGuideLobes ? kLobeWords : (kind == kGuideTree ? 0u : kHistogramWords);
}

/// Density with which sampleGuide draws the direction wi (unit, world), in solid angle.
SHARED_FN float pdfGuide(IN(GuideView) guide, GuideLeaf leaf, vec3 wi)
{
    if (guide.kind == kGuideLobes) return pdfGuideLobes(guide, leaf.firstWord, wi);
    if (guide.kind == kGuideTree) return pdfGuideTree(guide, leaf.firstWord, wi);
    return pdfHistogram(guide, leaf.firstWord, wi);
}

// A density that is what pdfGuide says of the direction.
SHARED_CONST float kAsPdfGuide = -1.0f;

/// Draws a direction (unit, world) for u in [0,1)^2, one pair for all choices so that its
/// stratification survives; `pdf` in solid angle. That of lobes is kAsPdfGuide: whoever asks for
/// directions that were drawn otherwise, too, asks once for all. Of cells it comes with the
/// direction, which rounding may take over a rim. False where the leaf knows no light.
SHARED_FN bool sampleGuide(IN(GuideView) guide, GuideLeaf leaf, vec2 u, OUT(vec3) wi,
                           OUT(float) pdf)
{
    pdf = kAsPdfGuide;
    if (guide.kind == kGuideLobes) return sampleGuideLobes(guide, leaf.firstWord, u, wi);
    if (guide.kind == kGuideTree) return sampleGuideTree(guide, leaf.firstWord, u, wi, pdf);
    return sampleHistogram(guide, leaf.firstWord, u, wi, pdf);
}

SHARED_END

#endif
