// CPU traversal of the flat BVH: the loop of shaders/traverse.glsl, for picking and tests.
#pragma once

#include <array>

#include "core/base/check.h"
#include "core/trace/bvh.h"

namespace core {

/// Visits leaves front to back; `leaf(slot)` returns true to stop, and may shorten `tMax`.
template <class Leaf>
void traverse(const Bvh& bvh, glm::vec3 origin, glm::vec3 direction, float tMin, float& tMax,
              const Leaf& leaf)
{
    if (!shared::isTraceable(origin, direction)) return;
    const shared::GridRay ray = shared::makeGridRay(origin, direction, bvh.gridLow, bvh.gridScale);
    std::array<uint32_t, shared::kBvhStackSize> stack;
    size_t top = 0;
    stack[top] = shared::kBvhDone;
    uint32_t node = 0;
    const int nearest = shared::boxBound(tMin);
    while (node != shared::kBvhDone) {
        if ((node & shared::kBvhLeaf) != 0) {
            const uint32_t count = (node >> shared::kBvhCountShift) & shared::kBvhCountMask;
            const uint32_t first = node & shared::kBvhIndexMask;
            for (uint32_t i = 0; i < count; ++i) {
                if (leaf(first + i)) return;
            }
            node = stack[top--];
            continue;
        }
        const shared::uvec4* children = bvh.node(node);
        const shared::uvec4 a = children[0], b = children[1];
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
