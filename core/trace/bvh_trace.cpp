// The nearest hit and any hit through the flat BVH on the CPU; see bvh.h.
#include "core/trace/bvh.h"
#include "core/trace/bvh_traverse.h"

namespace core {

bool traceClosest(const Bvh& bvh, std::span<const glm::vec3> positions,
                  std::span<const WorldTriangle> triangles, glm::vec3 origin, glm::vec3 direction,
                  float tMin, float tMax, BvhHit& hit)
{
    hit = BvhHit{};
    if (!shared::isTraceable(origin, direction)) return false;
    traverse(bvh, origin, direction, tMin, tMax, [&](uint32_t slot, const LocalRay& ray) {
        const WorldTriangle& t = triangles[bvh.triangle(slot)];
        BvhHit h;
        if (shared::intersectTriangle(ray.shear, positions[t.v0], positions[t.v1], positions[t.v2],
                                      tMin, tMax, h.t, h.barycentrics)) {
            h.slot = slot + ray.offset;
            hit = h;
            tMax = h.t;
        }
        return false;
    });
    return hit.slot != shared::kNone;
}

bool traceAny(const Bvh& bvh, std::span<const glm::vec3> positions,
              std::span<const WorldTriangle> triangles, glm::vec3 origin, glm::vec3 direction,
              float tMin, float tMax)
{
    if (!shared::isTraceable(origin, direction)) return false;
    bool found = false;
    traverse(bvh, origin, direction, tMin, tMax, [&](uint32_t slot, const LocalRay& ray) {
        const WorldTriangle& t = triangles[bvh.triangle(slot)];
        BvhHit h;
        found = shared::intersectTriangle(ray.shear, positions[t.v0], positions[t.v1],
                                          positions[t.v2], tMin, tMax, h.t, h.barycentrics);
        return found;
    });
    return found;
}

}  // namespace core
