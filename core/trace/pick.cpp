// One ray against the hierarchy, or against every triangle. See pick.h.
#include "core/trace/pick.h"

#include <cmath>
#include <mutex>

#include "core/base/parallel.h"
#include "core/trace/bvh_traverse.h"
#include "core/trace/world_bvh.h"
#include "shared/camera.h"
#include "shared/intersect.h"

namespace core {

namespace {

/// The nearest triangle so far; equal distances go to the lower number, whatever the order.
struct Nearest {
    float t = shared::kInfinity;
    uint32_t triangle = shared::kNone;

    /// What is no nearer than this cannot count.
    float bound() const { return std::nextafter(t, shared::kInfinity); }
    void offer(float otherT, uint32_t other)
    {
        if (otherT < t || (otherT == t && other < triangle)) *this = {otherT, other};
    }
    void test(const World& world, const shared::ShearRay& ray, uint32_t candidate)
    {
        const WorldTriangle& v = world.triangles[candidate];
        float hit = 0;
        glm::vec2 barycentrics;
        if (shared::intersectTriangle(ray, world.positions[v.v0], world.positions[v.v1],
                                      world.positions[v.v2], 0.0f, bound(), hit, barycentrics))
            offer(hit, candidate);
    }
};

Nearest nearestOfAll(const World& world, const shared::ShearRay& ray)
{
    std::mutex mutex;
    Nearest nearest;
    parallelFor(world.triangles.size(), 1 << 14, [&](size_t begin, size_t end) {
        Nearest ofBlock;
        for (size_t i = begin; i < end; ++i) ofBlock.test(world, ray, static_cast<uint32_t>(i));
        const std::lock_guard lock(mutex);
        nearest.offer(ofBlock.t, ofBlock.triangle);
    });
    return nearest;
}

Nearest nearestThrough(const Bvh& bvh, const World& world, const shared::ShearRay& ray,
                       const glm::vec3& origin, const glm::vec3& direction)
{
    Nearest nearest;
    float tMax = nearest.bound();
    traverse(bvh, origin, direction, 0.0f, tMax, [&](uint32_t slot) {
        nearest.test(world, ray, bvh.triangle(slot));
        tMax = nearest.bound();
        return false;
    });
    return nearest;
}

}  // namespace

std::optional<Picked> pick(const World& world, const Camera& camera, glm::uvec2 imageSize,
                           glm::dvec2 position)
{
    shared::CameraData data = cameraData(camera, imageSize.x, imageSize.y);
    data.apertureRadius = 0;
    const glm::vec2 size(imageSize);
    glm::vec3 origin, direction;
    shared::cameraRay(data, glm::vec2(position) * size, size, glm::vec2(0.5f), origin, direction);
    if (!shared::isTraceable(origin, direction)) return std::nullopt;
    const shared::ShearRay ray = shared::makeShearRay(origin, direction);
    const std::shared_ptr<const Bvh> bvh = bvhIfMade(world);
    const Nearest found =
        bvh ? nearestThrough(*bvh, world, ray, origin, direction) : nearestOfAll(world, ray);
    if (found.triangle == shared::kNone) return std::nullopt;
    const double distance = static_cast<double>(found.t);
    return Picked{glm::dvec3(origin) + distance * glm::dvec3(direction), distance, found.triangle,
                  world.triangles[found.triangle].material};
}

}  // namespace core
