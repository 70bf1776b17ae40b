// What a path guide is made of, as both languages reach it: nodes of the trees, leaves, and words
// that say which directions are worth going in a leaf. guide.h reads the first two, the last
// belongs to one of three representations: guide_histogram.h, guide_lobes.h, guide_tree.h.
#ifndef REKINDLE_SHARED_GUIDE_TABLES_H
#define REKINDLE_SHARED_GUIDE_TABLES_H

#include "lang.h"

#ifdef __cplusplus
#include <cstring>
#endif

SHARED_BEGIN

// How a guide knows directions; 0 where there is none.
SHARED_CONST uint kGuideHistogram = 1u;
SHARED_CONST uint kGuideLobes = 2u;
SHARED_CONST uint kGuideTree = 3u;

/// One number of each of eight lobes.
struct LobeRow {
    float v[8];
};

#ifdef __cplusplus

/// Pointers into core::guiding::GuideTables, which must outlive it.
struct GuideView {
    const uvec4* nodes;
    const uvec4* leaves;
    const vec4* directions;
    uint kind;
};

inline uvec4 fetchGuideNode(const GuideView& guide, uint i)
{
    return guide.nodes[i];
}

inline uvec4 fetchGuideLeaf(const GuideView& guide, uint leaf)
{
    return guide.leaves[leaf];
}

inline vec4 fetchGuideDirections(const GuideView& guide, uint i)
{
    return guide.directions[i];
}

/// Two words from the i-th on; one load where registers are as wide.
inline LobeRow fetchLobeRow(const GuideView& guide, uint i)
{
    LobeRow row;
    std::memcpy(row.v, guide.directions + i, sizeof(row.v));
    return row;
}

#else

struct GuideView {
    uint kind;
};

uvec4 fetchGuideNode(GuideView guide, uint i);
uvec4 fetchGuideLeaf(GuideView guide, uint leaf);
vec4 fetchGuideDirections(GuideView guide, uint i);

LobeRow fetchLobeRow(GuideView guide, uint i)
{
    const vec4 a = fetchGuideDirections(guide, i);
    const vec4 b = fetchGuideDirections(guide, i + 1u);
    return LobeRow(float[8](a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w));
}

#endif

SHARED_END

#endif
