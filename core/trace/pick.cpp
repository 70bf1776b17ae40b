// One ray against the hierarchy, or against every triangle. See pick.h.
#include "core/trace/pick.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <tuple>

#include "core/base/parallel.h"
#include "core/scene/features.h"
#include "core/trace/bvh_traverse.h"
#include "core/trace/scene_view.h"
#include "core/trace/world_bvh.h"
#include "shared/camera.h"
#include "shared/instances.h"
#include "shared/intersect.h"
#include "shared/surface.h"

namespace core {

namespace {

/// The nearest triangle so far; equal distances go to the lower number, whatever the order.
struct Nearest {
    float t = shared::kInfinity;
    uint32_t triangle = shared::kNone, instance = shared::kNone;

    /// What is no nearer than this cannot count.
    float bound() const { return std::nextafter(t, shared::kInfinity); }
    void offer(const Nearest& other)
    {
        const auto order = [](const Nearest& n) { return std::tuple(n.t, n.triangle, n.instance); };
        if (order(other) < order(*this)) *this = other;
    }
    /// What blends or is masked is there where alpha is a half or more, as in first hits.
    void test(const World& world, const shared::ShearRay& ray, uint32_t candidate,
              uint32_t inInstance)
    {
        const WorldTriangle& v = world.triangles[candidate];
        float hit = 0;
        glm::vec2 barycentrics;
        if (shared::intersectTriangle(ray, world.positions[v.v0], world.positions[v.v1],
                                      world.positions[v.v2], 0.0f, bound(), hit, barycentrics) &&
            (!hasAlphaTest(world.materials[v.material]) ||
             shared::surfaceAlpha(sceneView(world), candidate, barycentrics) >= 0.5f))
            offer({hit, candidate, inInstance});
    }
};

Nearest nearestOf(const World& world, const IndexRange& triangles, const shared::ShearRay& ray,
                  uint32_t instance)
{
    std::mutex mutex;
    Nearest nearest;
    parallelFor(triangles.size(), 1 << 14, [&](size_t begin, size_t end) {
        Nearest ofBlock;
        for (size_t i = begin; i < end; ++i)
            ofBlock.test(world, ray, triangles.begin + static_cast<uint32_t>(i), instance);
        const std::lock_guard lock(mutex);
        nearest.offer(ofBlock);
    });
    return nearest;
}

/// Whether the ray meets the bounds of a prototype at all, roughly.
bool meetsBounds(const glm::vec3& low, const glm::vec3& high, const glm::vec3& origin,
                 const glm::vec3& direction)
{
    const glm::vec3 margin = 1e-3f * (high - low) + 1e-6f;
    const glm::vec3 a = (low - margin - origin) / direction;
    const glm::vec3 b = (high + margin - origin) / direction;
    const glm::vec3 first = glm::min(a, b), last = glm::max(a, b);
    return !(std::max({first.x, first.y, first.z, 0.0f}) > std::min({last.x, last.y, last.z}));
}

void lookAtInstances(const World& world, const Prototype& prototype, const glm::vec3& origin,
                     const glm::vec3& direction, Nearest& nearest)
{
    glm::vec3 low(shared::kInfinity), high(-shared::kInfinity);
    for (uint32_t i = prototype.triangles.begin; i < prototype.triangles.end; ++i) {
        const WorldTriangle& t = world.triangles[i];
        for (const uint32_t v : {t.v0, t.v1, t.v2}) {
            low = glm::min(low, world.positions[v]);
            high = glm::max(high, world.positions[v]);
        }
    }
    for (uint32_t i = prototype.instances.begin; i < prototype.instances.end; ++i) {
        const auto words = wayInto(world.instances[i], 0, 0, i + 1);
        const LocalRay ray = LocalRay::inInstance(origin, direction, words.data());
        if (meetsBounds(low, high, ray.origin, ray.direction))
            nearest.offer(nearestOf(world, prototype.triangles, ray.shear, i));
    }
}

Nearest nearestOfAll(const World& world, const glm::vec3& origin, const glm::vec3& direction)
{
    Nearest nearest = nearestOf(world, {0, flatTriangles(world)},
                                shared::makeShearRay(origin, direction), shared::kNone);
    for (const Prototype& prototype : world.prototypes)
        lookAtInstances(world, prototype, origin, direction, nearest);
    return nearest;
}

Nearest nearestThrough(const Bvh& bvh, const World& world, const glm::vec3& origin,
                       const glm::vec3& direction)
{
    Nearest nearest;
    float tMax = nearest.bound();
    traverse(bvh, origin, direction, 0.0f, tMax, [&](uint32_t slot, const LocalRay& ray) {
        nearest.test(world, ray.shear, bvh.triangle(slot), ray.instance);
        tMax = nearest.bound();
        return false;
    });
    return nearest;
}

glm::dvec3 normalAt(const World& world, const Nearest& found)
{
    const WorldTriangle& v = world.triangles[found.triangle];
    const auto vertex = [&](uint32_t i) {
        const glm::vec3& p = world.positions[i];
        return glm::dvec3(found.instance == shared::kNone
                              ? p
                              : shared::transformPoint(world.instances[found.instance], p));
    };
    const glm::dvec3 a = vertex(v.v0);
    return glm::cross(vertex(v.v1) - a, vertex(v.v2) - a);
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
    const std::shared_ptr<const Bvh> bvh = bvhIfMade(world);
    const Nearest found = bvh ? nearestThrough(*bvh, world, origin, direction)
                              : nearestOfAll(world, origin, direction);
    if (found.triangle == shared::kNone) return std::nullopt;
    const double distance = static_cast<double>(found.t);
    return Picked{glm::dvec3(origin) + distance * glm::dvec3(direction),
                  distance,
                  found.triangle,
                  world.triangles[found.triangle].material,
                  found.instance,
                  normalAt(world, found)};
}

}  // namespace core
