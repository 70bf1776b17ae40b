#include "core/methods/path_aovs.h"

#include "core/base/parallel.h"
#include "core/methods/first_hits.h"
#include "core/trace/scene_view.h"
#include "shared/camera.h"

namespace core {

Aovs traceAovs(const Accel& accel, const shared::CameraData& camera, uint32_t width,
               uint32_t height)
{
    Aovs aovs = emptyAovs(width, height);
    const shared::SceneView scene = sceneView(accel.world());
    const shared::PathSettings settings = worldSettings(accel.world());
    const glm::vec2 size(static_cast<float>(width), static_cast<float>(height));
    const auto body = [&](const Tile& tile) {
        for (uint32_t y = tile.y0; y < tile.y1; ++y) {
            for (uint32_t x = tile.x0; x < tile.x1; ++x) {
                const glm::vec2 film(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
                Ray ray;
                ray.seed = shared::kAlphaByHalf;
                shared::cameraRay(camera, film, size, glm::vec2(0.5f), ray.origin, ray.direction);
                shared::Hit hit;
                const shared::FirstHit found =
                    accel.closest(ray, hit) ? shared::makeFirstHit(scene, hit, ray.direction)
                                            : shared::noFirstHit(scene, settings, ray.direction);
                storeFirstHit(found, size_t(y) * width + x, aovs);
            }
        }
    };
    parallelTiles(width, height, 16, body);
    return aovs;
}

}  // namespace core
