// See path_aovs.h. Rays of a tile go in packets, those behind panes and mirrors one by one.
#include "core/methods/path_aovs.h"

#include <array>
#include <span>

#include "core/base/parallel.h"
#include "core/methods/first_hits.h"
#include "core/trace/scene_view.h"
#include "shared/camera.h"
#include "shared/seen.h"

namespace core {

namespace {

constexpr uint32_t kTileSide = 16;

Ray rayOf(const shared::SeenWay& way)
{
    Ray ray;
    ray.seed = shared::kAlphaByHalf;
    ray.origin = way.origin;
    ray.direction = way.direction;
    return ray;
}

/// Of a way whose next ray has met `hit`, or nothing (its slot is kNone).
shared::FirstHit seenAlong(const Accel& accel, const shared::SceneView& scene,
                           const shared::PathSettings& settings, shared::SeenWay way,
                           shared::Hit hit, Sight sight)
{
    while (hit.slot != shared::kNone) {
        shared::Arrival at;
        const shared::FirstHit found = shared::arriveAt(scene, hit, way, at);
        if (sight == Sight::first || !shared::goesOn(at, way)) return found;
        if (!accel.closest(rayOf(way), hit)) break;
    }
    return shared::seenNothing(scene, settings, way);
}

}  // namespace

Aovs traceAovs(const Accel& accel, const shared::CameraData& camera, uint32_t width,
               uint32_t height, Sight sight)
{
    Aovs aovs = emptyAovs(width, height);
    const shared::SceneView scene = sceneView(accel.world());
    const shared::PathSettings settings = worldSettings(accel.world());
    const glm::vec2 size(static_cast<float>(width), static_cast<float>(height));
    const auto body = [&](const Tile& tile) {
        std::array<Ray, kTileSide * kTileSide> rays;
        std::array<shared::Hit, kTileSide * kTileSide> hits;
        size_t count = 0;
        for (uint32_t y = tile.y0; y < tile.y1; ++y) {
            for (uint32_t x = tile.x0; x < tile.x1; ++x) {
                const glm::vec2 film(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
                glm::vec3 origin, direction;
                shared::cameraRay(camera, film, size, glm::vec2(0.5f), origin, direction);
                rays[count++] = rayOf(shared::seenAlong(origin, direction));
            }
        }
        accel.closest(std::span(rays.data(), count), hits.data(), true);
        size_t i = 0;
        for (uint32_t y = tile.y0; y < tile.y1; ++y) {
            for (uint32_t x = tile.x0; x < tile.x1; ++x, ++i) {
                const shared::SeenWay way = shared::seenAlong(rays[i].origin, rays[i].direction);
                storeFirstHit(seenAlong(accel, scene, settings, way, hits[i], sight),
                              size_t(y) * width + x, aovs);
            }
        }
    };
    parallelTiles(width, height, kTileSide, body);
    return aovs;
}

}  // namespace core
