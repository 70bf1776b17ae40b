// CPU traversal of the flat BVH: the loop of shaders/traverse.glsl, for picking and tests.
#pragma once

#include <array>

#include "core/base/check.h"
#include "core/trace/bvh.h"

namespace core {

/// What traversals have done so far.
struct TraversalCounts {
    uint64_t nodes = 0, triangles = 0, gridChanges = 0;
};

/// Visits leaves front to back; `leaf(slot)` returns true to stop, and may shorten `tMax`. Adds to
/// `counts` unless null.
template <class Leaf>
void traverse(const Bvh& bvh, glm::vec3 origin, glm::vec3 direction, float tMin, float& tMax,
              const Leaf& leaf, TraversalCounts* counts = nullptr)
{
    if (!shared::isTraceable(origin, direction)) return;
    TraversalCounts ignored;
    TraversalCounts& count = counts != nullptr ? *counts : ignored;
    shared::GridRay ray = shared::makeGridRay(origin, direction, bvh.gridLow, bvh.gridScale);
    std::array<uint32_t, shared::kBvhStackSize> stack;
    size_t top = 0;
    stack[top] = shared::kBvhDone;
    uint32_t node = 0;
    const int nearest = shared::boxBound(tMin);
    while (node != shared::kBvhDone) {
        if (node >= shared::kBvhChange) {
            const shared::uvec4* words = bvh.node(node & shared::kBvhIndexMask);
            const bool enters = words[0].w != shared::kBvhDone;
            ray = shared::makeGridRayOf(origin, direction, words[0], words[1]);
            ++count.gridChanges;
            if (enters && stack[top] != shared::kBvhDone) {
                CHECK(top + 1 < stack.size());
                stack[++top] = node + 1;  // the way back
            }
            node = enters ? words[0].w : stack[top--];
            continue;
        }
        if ((node & shared::kBvhLeaf) != 0) {
            const uint32_t end = (node >> shared::kBvhCountShift) & shared::kBvhCountMask;
            const uint32_t first = node & shared::kBvhIndexMask;
            for (uint32_t i = 0; i < end; ++i) {
                ++count.triangles;
                if (leaf(first + i)) return;
            }
            node = stack[top--];
            continue;
        }
        const shared::uvec4* children = bvh.node(node);
        const shared::uvec4 a = children[0], b = children[1];
        ++count.nodes;
        const int farthest = shared::boxBound(tMax);
        const glm::ivec2 ta = shared::intersectBox(ray, a, nearest, farthest);
        const glm::ivec2 tb = shared::intersectBox(ray, b, nearest, farthest);
        const bool hitA = ta.x <= ta.y, hitB = tb.x <= tb.y;
        if (hitA && hitB) {
            const bool swap = tb.x < ta.x;
            CHECK(top + 1 < stack.size());
            stack[++top] = swap ? a.w : b.w;
            node = swap ? b.w : a.w;
        } else if (hitA || hitB) {
            node = hitA ? a.w : b.w;
        } else {
            node = stack[top--];
        }
    }
}

}  // namespace core
