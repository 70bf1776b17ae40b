// CPU traversal of the flat BVH: the loop of shaders/traverse.glsl, for picking and tests.
#pragma once

#include <array>

#include "core/base/check.h"
#include "core/trace/bvh.h"

namespace core {

/// What traversals have done so far.
struct TraversalCounts {
    uint64_t nodes = 0, triangles = 0, gridChanges = 0, instances = 0;
};

/// The words of the way into an instance, for rays in the world (see Bvh): `way` is the node that
/// leads to its prototype's root, `number` counts from 1.
std::array<shared::uvec4, 4> wayInto(const shared::InstanceMatrix& matrix, uint32_t way,
                                     uint32_t slotOffset, uint32_t number);

/// A ray in the space of the triangles that it is among: the world, or a prototype whose slots are
/// `offset` away from those of the `instance` (an index; kNone: of none).
struct LocalRay {
    glm::vec3 origin, direction;
    shared::ShearRay shear;
    uint32_t offset = 0, instance = shared::kNone;

    LocalRay(glm::vec3 o, glm::vec3 d) : origin(o), direction(d), shear(shared::makeShearRay(o, d))
    {}

    /// The ray in the world as an instance sees it, which four words describe: see wayInto.
    static LocalRay inInstance(glm::vec3 o, glm::vec3 d, const shared::uvec4* words)
    {
        const auto row = [&](size_t i) {
            return glm::vec3(shared::uintAsFloat(words[i].x), shared::uintAsFloat(words[i].y),
                             shared::uintAsFloat(words[i].z));
        };
        const auto times = [&](glm::vec3 v) {
            return glm::vec3(glm::dot(row(0), v), glm::dot(row(1), v), glm::dot(row(2), v));
        };
        LocalRay ray(times(o) + row(3), times(d));
        ray.offset = words[2].w;
        ray.instance = words[3].w - 1;
        return ray;
    }
};

/// Visits leaves front to back; `leaf(slot, ray)` returns true to stop, and may shorten `tMax`;
/// slot
/// + ray.offset is that of the hit. Adds to `counts` unless null.
template <class Leaf>
void traverse(const Bvh& bvh, glm::vec3 origin, glm::vec3 direction, float tMin, float& tMax,
              const Leaf& leaf, TraversalCounts* counts = nullptr)
{
    if (!shared::isTraceable(origin, direction)) return;
    TraversalCounts ignored;
    TraversalCounts& count = counts != nullptr ? *counts : ignored;
    LocalRay ray(origin, direction);
    const shared::BvhEntry entry = entryOf(bvh);
    shared::GridRay grid = shared::makeGridRay(origin, direction, entry.gridLow, entry.gridScale);
    std::array<uint32_t, shared::kBvhStackSize> stack;
    size_t top = 0;
    stack[top] = shared::kBvhDone;
    if (entry.way != shared::kBvhDone) stack[++top] = entry.way;
    uint32_t node = entry.node;
    const int nearest = shared::boxBound(tMin);
    while (node != shared::kBvhDone) {
        if (node == entry.way) {
            const bool outside = shared::goesOutside(entry, origin, direction, nearest,
                                                     shared::boxBound(tMax), grid);
            node = outside ? entry.surroundings.w : shared::kBvhDone;
            top = 0;
            ++count.gridChanges;
            continue;
        }
        if (node >= shared::kBvhChange) {
            const shared::uvec4* words = bvh.node(node & shared::kBvhIndexMask);
            const bool enters = words[0].w != shared::kBvhDone;
            uint32_t back = node + 1;
            if (words[1].w == shared::kBvhInstance) {
                ray = LocalRay::inInstance(origin, direction, words);
                words = bvh.node(words[0].w);
                back = node + 2;
                ++count.instances;
            } else if (words[1].w == shared::kBvhWorld) {
                ray = LocalRay(origin, direction);
            }
            grid = shared::makeGridRayOf(ray.origin, ray.direction, words[0], words[1]);
            ++count.gridChanges;
            if (enters && stack[top] != shared::kBvhDone) {
                CHECK(top + 1 < stack.size());
                stack[++top] = back;
            }
            node = enters ? words[0].w : stack[top--];
            continue;
        }
        if ((node & shared::kBvhLeaf) != 0) {
            const uint32_t end = (node >> shared::kBvhCountShift) & shared::kBvhCountMask;
            const uint32_t first = node & shared::kBvhIndexMask;
            for (uint32_t i = 0; i < end; ++i) {
                ++count.triangles;
                if (leaf(first + i, ray)) return;
            }
            node = stack[top--];
            continue;
        }
        const shared::uvec4* children = bvh.node(node);
        const shared::uvec4 a = children[0], b = children[1];
        ++count.nodes;
        const int farthest = shared::boxBound(tMax);
        const glm::ivec2 ta = shared::intersectBox(grid, a, nearest, farthest);
        const glm::ivec2 tb = shared::intersectBox(grid, b, nearest, farthest);
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
