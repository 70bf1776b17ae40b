#include "core/methods/tiled_renderer.h"

#include "core/base/check.h"
#include "core/methods/path_aovs.h"
#include "core/trace/scene_view.h"

namespace core {

void TiledRenderer::setWorld(std::shared_ptr<const World> world, const Progress& progress)
{
    film_.reset(film_.size());
    sky_.forget();
    takeWorld(accel_, std::move(world), progress);
}

void TiledRenderer::prepare(const AnyParams& params, const Progress& progress)
{
    CHECK(accel_ != nullptr);
    if (const auto* sampling = findParam<SkySampling>(params, "sky"))
        sky_.prepare(*sampling, *accel_, progress);
}

void TiledRenderer::setView(const View& view, Start)
{
    CHECK(view.size.x > 0 && view.size.y > 0);
    camera_ = view.camera;
    centred_ = view.centred;
    setParams(view.params);
    film_.reset(view.size);
}

shared::PathSettings TiledRenderer::frameSettings() const
{
    CHECK(accel_ != nullptr);
    shared::PathSettings settings = worldSettings(accel_->world());
    settings.imageWidth = film_.size().x;
    settings.imageHeight = film_.size().y;
    settings.skyRegions = sky_.taken() != nullptr ? 1 : 0;
    return settings;
}

void TiledRenderer::drawSky(SkySampling sampling)
{
    CHECK(accel_ != nullptr);
    sky_.take(sampling, *accel_);
}

shared::SceneView TiledRenderer::frameScene() const
{
    shared::SceneView scene = sceneView(accel_->world());
    if (sky_.taken() != nullptr) scene.skyRegions = sky_.taken()->words.data();
    return scene;
}

shared::CameraData TiledRenderer::frameCamera() const
{
    shared::CameraData data = cameraData(camera_, film_.size().x, film_.size().y);
    data.centred = centred_ ? 1 : 0;
    return data;
}

uint32_t TiledRenderer::frameFeatures() const
{
    const uint32_t features = accel_->world().features & ~shared::kFeatureThinLens;
    return camera_.hasLens() ? features | shared::kFeatureThinLens : features;
}

Aovs TiledRenderer::surfaces(const Camera& camera, glm::uvec2 size, Sight sight)
{
    CHECK(accel_ != nullptr);
    return traceAovs(*accel_, cameraData(camera, size.x, size.y), size.x, size.y, sight);
}

RenderStats TiledRenderer::stats() const
{
    RenderStats stats;
    stats.device = "cpu";
    stats.driver = "Embree";
    stats.buildSeconds = accel_ ? accel_->stats().buildSeconds : 0;
    film_.addTo(stats);
    return stats;
}

}  // namespace core
