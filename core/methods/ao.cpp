// Ambient occlusion on all cores. The estimator is that of shaders/shared/ao.h; everything but the
// samples is TiledRenderer's.
#include <array>

#include "core/methods/method.h"
#include "core/methods/tiled_renderer.h"
#include "core/trace/scene_view.h"
#include "shared/ao.h"

namespace core {

namespace {

class AmbientOcclusion : public TiledRenderer {
public:
    void advance(const Budget& budget, std::stop_token stop) override
    {
        settings_ = frameSettings();
        eye_ = frameCamera();
        film_.advance(budget, stop,
                      [this](const Tile& tile, uint32_t first, uint32_t count, Film& film) {
                          TileTally tally;
                          for (uint32_t i = 0; i < count; ++i)
                              renderSample(tile, first + i, film, tally);
                          return tally;
                      });
    }

private:
    static constexpr size_t kWave = size_t(kFilmTile) * kFilmTile;

    /// One sample of every pixel of a tile: all camera rays together, then all others.
    void renderSample(const Tile& tile, uint32_t sample, Film& film, TileTally& tally) const
    {
        std::array<shared::SampleStream, kWave> streams;
        std::array<Ray, kWave> rays;
        std::array<shared::Hit, kWave> hits;
        std::array<float, kWave> open;
        std::array<uint16_t, kWave> owner;
        std::array<uint8_t, kWave> blocked;
        size_t count = 0;
        for (uint32_t y = tile.y0; y < tile.y1; ++y)
            for (uint32_t x = tile.x0; x < tile.x1; ++x, ++count) {
                streams[count] =
                    shared::makeStream(static_cast<uint32_t>(params_.sampler), params_.seed, {x, y},
                                       sample, shared::kPurposeOcclusion);
                const shared::PathState path =
                    shared::beginPath(eye_, settings_, {x, y}, streams[count]);
                rays[count] = {path.origin, shared::kInfinity, path.direction,
                               shared::alphaSeed(streams[count], 0, 0)};
            }
        accel_->closest({rays.data(), count}, hits.data(), true);

        const shared::SceneView scene = sceneView(accel_->world());
        size_t asked = 0;
        for (size_t i = 0; i < count; ++i) {
            const bool hit = hits[i].slot != shared::kNone;
            open[i] = hit ? 0.0f : 1.0f;
            shared::OcclusionRay ray;
            if (!hit ||
                !shared::occlusionRay(
                    scene, streams[i], hits[i], rays[i].direction,
                    params_.distance * static_cast<float>(accel_->world().placement.scale), ray))
                continue;
            rays[asked] = {ray.origin, ray.tMax, ray.direction,
                           shared::alphaSeed(streams[i], 0, 1)};
            owner[asked++] = static_cast<uint16_t>(i);
        }
        accel_->occluded({rays.data(), asked}, blocked.data());
        for (size_t i = 0; i < asked; ++i) open[owner[i]] = blocked[i] != 0 ? 0.0f : 1.0f;

        size_t i = 0;
        for (uint32_t y = tile.y0; y < tile.y1; ++y)
            for (uint32_t x = tile.x0; x < tile.x1; ++x, ++i)
                film.add(size_t(y) * film.width + x, glm::vec3(open[i]), tally.counters);
        tally.paths += count;
        tally.rays += count + asked;
    }

    void setParams(const AnyParams& params) override { params_ = params.as<AoParams>(); }

    AoParams params_;
    // Of the present advance.
    shared::PathSettings settings_{};
    shared::CameraData eye_{};
};

}  // namespace

std::unique_ptr<Renderer> makeAmbientOcclusion()
{
    return std::make_unique<AmbientOcclusion>();
}

std::span<const MethodPreset> aoPresets()
{
    static const std::array kPresets{
        MethodPreset{"open sky", AoParams{}, "everything occludes, however far"},
        MethodPreset{"creases", AoParams{.distance = 0.25f},
                     "what is near: corners, folds, contact"},
    };
    return kPresets;
}

}  // namespace core
