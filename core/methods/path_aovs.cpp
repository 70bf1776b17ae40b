#include "core/methods/path_aovs.h"

#include "core/base/parallel.h"
#include "core/methods/first_hits.h"
#include "core/trace/scene_view.h"
#include "shared/camera.h"
#include "shared/seen.h"

namespace core {

static shared::FirstHit seenAlong(const Accel& accel, const shared::SceneView& scene,
                                  const shared::PathSettings& settings, const glm::vec3& origin,
                                  const glm::vec3& direction, Sight sight)
{
    shared::SeenWay way = shared::seenAlong(origin, direction);
    for (;;) {
        Ray ray;
        ray.seed = shared::kAlphaByHalf;
        ray.origin = way.origin;
        ray.direction = way.direction;
        shared::Hit hit;
        if (!accel.closest(ray, hit)) return shared::seenNothing(scene, settings, way);
        shared::Arrival at;
        const shared::FirstHit found = shared::arriveAt(scene, hit, way, at);
        if (sight == Sight::first || !shared::goesOn(at, way)) return found;
    }
}

Aovs traceAovs(const Accel& accel, const shared::CameraData& camera, uint32_t width,
               uint32_t height, Sight sight)
{
    Aovs aovs = emptyAovs(width, height);
    const shared::SceneView scene = sceneView(accel.world());
    const shared::PathSettings settings = worldSettings(accel.world());
    const glm::vec2 size(static_cast<float>(width), static_cast<float>(height));
    const auto body = [&](const Tile& tile) {
        for (uint32_t y = tile.y0; y < tile.y1; ++y) {
            for (uint32_t x = tile.x0; x < tile.x1; ++x) {
                const glm::vec2 film(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
                glm::vec3 origin, direction;
                shared::cameraRay(camera, film, size, glm::vec2(0.5f), origin, direction);
                storeFirstHit(seenAlong(accel, scene, settings, origin, direction, sight),
                              size_t(y) * width + x, aovs);
            }
        }
    };
    parallelTiles(width, height, 16, body);
    return aovs;
}

}  // namespace core
