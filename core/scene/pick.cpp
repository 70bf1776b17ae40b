// One ray against every triangle. See pick.h.
#include "core/scene/pick.h"

#include <mutex>

#include "core/base/parallel.h"
#include "shared/camera.h"
#include "shared/intersect.h"

namespace core {

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

    std::mutex mutex;
    float nearest = shared::kInfinity;
    uint32_t found = shared::kNone;
    parallelFor(world.triangles.size(), 1 << 14, [&](size_t begin, size_t end) {
        float t = 0, best = shared::kInfinity;
        glm::vec2 barycentrics;
        uint32_t which = shared::kNone;
        for (size_t i = begin; i < end; ++i) {
            const WorldTriangle& triangle = world.triangles[i];
            if (!shared::intersectTriangle(
                    ray, world.positions[triangle.v0], world.positions[triangle.v1],
                    world.positions[triangle.v2], 0.0f, best, t, barycentrics))
                continue;
            best = t;
            which = static_cast<uint32_t>(i);
        }
        const std::lock_guard lock(mutex);
        // Equal distances go to the lower number, whatever the order of the blocks.
        if (which != shared::kNone && (best < nearest || (best == nearest && which < found))) {
            nearest = best;
            found = which;
        }
    });
    if (found == shared::kNone) return std::nullopt;
    const double distance = static_cast<double>(nearest);
    return Picked{glm::dvec3(origin) + distance * glm::dvec3(direction), distance, found,
                  world.triangles[found].material};
}

}  // namespace core
