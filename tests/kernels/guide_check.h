// A direction drawn from a guide and densities of it and of another: compiled for the device and
// for the host, whose answers must agree.
#ifndef REKINDLE_TESTS_GUIDE_CHECK_H
#define REKINDLE_TESTS_GUIDE_CHECK_H

#include "shared/guide.h"

SHARED_BEGIN

struct GuideCheckInput {
    vec3 position;
    vec3 normal;
    vec2 u;
    vec3 direction;
};

struct GuideCheckOutput {
    uint leaf;
    uint drawn;
    float share;
    float reflected;
    float density;  // of the input's direction
    vec3 wi;
    float pdf;
};

SHARED_FN GuideCheckOutput checkGuide(IN(GuideView) guide, GuideCheckInput a)
{
    const GuideLeaf leaf = guideAt(guide, a.position, a.normal);
    GuideCheckOutput r;
    r.leaf = leaf.index;
    r.share = leaf.share;
    r.reflected = leaf.reflected;
    r.density = pdfGuide(guide, leaf, a.direction);
    r.drawn = sampleGuide(guide, leaf, a.u, r.wi, r.pdf) ? 1u : 0u;
    if (r.pdf == kAsPdfGuide) r.pdf = pdfGuide(guide, leaf, r.wi);
    return r;
}

SHARED_END

#endif
