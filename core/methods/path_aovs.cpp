#include "core/methods/path_aovs.h"

#include "core/base/parallel.h"
#include "core/trace/scene_view.h"
#include "shared/camera.h"

namespace core {

namespace {

float asId(uint32_t id)
{
    return id == shared::kNone ? -1.0f : static_cast<float>(id);
}

void store(float* pixel, const glm::vec3& v)
{
    pixel[0] = v.x;
    pixel[1] = v.y;
    pixel[2] = v.z;
}

}  // namespace

Aovs traceAovs(const Accel& accel, const shared::CameraData& camera, uint32_t width,
               uint32_t height)
{
    Aovs aovs{Image(width, height, 1), Image(width, height, 3), Image(width, height, 3),
              Image(width, height, 3)};
    const shared::SceneView scene = sceneView(accel.world());
    const glm::vec2 size(static_cast<float>(width), static_cast<float>(height));
    const auto body = [&](const Tile& tile) {
        for (uint32_t y = tile.y0; y < tile.y1; ++y) {
            for (uint32_t x = tile.x0; x < tile.x1; ++x) {
                const glm::vec2 film(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
                Ray ray;
                shared::cameraRay(camera, film, size, glm::vec2(0.5f), ray.origin, ray.direction);
                shared::Hit hit;
                store(aovs.ids.at(x, y), glm::vec3(-1));
                if (!accel.closest(ray, hit)) continue;
                shared::SurfacePoint s = shared::makeSurfacePoint(scene, hit, ray.direction);
                const shared::Shading shading = shared::evaluateMaterial(scene, s, ray.direction);
                const shared::Bsdf bsdf = shared::makeBsdf(shading.inputs);
                *aovs.depth.at(x, y) = hit.t;
                store(aovs.normal.at(x, y), s.frame[2]);
                store(aovs.albedo.at(x, y),
                      shared::albedoBsdf(bsdf, shared::toLocal(s.frame, -ray.direction)));
                store(aovs.ids.at(x, y), {asId(s.triangle), asId(s.material), asId(s.emitter)});
            }
        }
    };
    parallelTiles(width, height, 16, body);
    return aovs;
}

}  // namespace core
