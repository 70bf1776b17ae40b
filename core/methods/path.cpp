// The path tracer on all cores: reference for every other renderer, and `--device cpu`. The
// estimator is that of shaders/shared/path.h; a sample depends on seed, pixel and index alone.
#include <array>

#include "core/base/check.h"
#include "core/methods/method.h"
#include "core/methods/path_aovs.h"
#include "core/methods/path_kernel.h"
#include "core/methods/tiled_film.h"
#include "core/trace/scene_view.h"

namespace core {

std::span<const PathVariant> pathVariants()
{
    using namespace shared;
    static constexpr PathVariant kVariants[] = {
        {"flat", kFeatureEmissiveTriangles | kFeatureManyEmitters, renderFlatTile},
        {"any", 0xffffffffu, renderAnyTile},
    };
    return kVariants;
}

namespace {

shared::PathSettings settingsFor(const World& world, const PathParams& params, uint32_t width,
                                 uint32_t height)
{
    shared::PathSettings s = worldSettings(world);
    s.seed = params.seed;
    s.samplerKind = static_cast<uint32_t>(params.sampler);
    s.strategy = static_cast<uint32_t>(params.strategy);
    s.maxDepth = params.maxDepth;
    s.rouletteDepth = params.rouletteDepth;
    s.clampIndirect = params.clampIndirect;
    s.imageWidth = width;
    s.imageHeight = height;
    return s;
}

class PathTracer : public Renderer {
public:
    void setWorld(std::shared_ptr<const World> world, const Progress& progress) override
    {
        film_.reset(film_.size());
        takeWorld(accel_, std::move(world), progress);
    }

    /// Keeps nothing, however the view has changed.
    void setView(const View& view, Start) override
    {
        CHECK(view.size.x > 0 && view.size.y > 0);
        camera_ = view.camera;
        params_ = view.params.as<PathParams>();
        film_.reset(view.size);
    }

    /// Pieces are tiles, far below any wish.
    void setPace(const Pace&) override {}

    void advance(const Budget& budget, std::stop_token stop) override
    {
        CHECK(accel_ != nullptr);
        const glm::uvec2 size = film_.size();
        PathJob job;
        job.accel = accel_.get();
        job.scene = sceneView(accel_->world());
        job.settings = settingsFor(accel_->world(), params_, size.x, size.y);
        job.camera = cameraData(camera_, size.x, size.y);
        film_.advance(budget, stop,
                      [&, kernel = variant().kernel](const Tile& tile, uint32_t first,
                                                     uint32_t count, Film& film) {
                          PathJob part = job;
                          part.firstSample = first;
                          part.sampleCount = count;
                          return kernel(part, tile, film);
                      });
    }

    RenderProgress progress() const override { return film_.progress(); }
    Estimate read(Reading what) override { return film_.estimate(what); }

    Aovs aovs() override
    {
        CHECK(accel_ != nullptr);
        const glm::uvec2 size = film_.size();
        return traceAovs(*accel_, cameraData(camera_, size.x, size.y), size.x, size.y);
    }

    RenderStats stats() const override
    {
        RenderStats s;
        s.device = "cpu";
        s.driver = "Embree";
        s.buildSeconds = accel_ ? accel_->stats().buildSeconds : 0;
        s.details = {{"kernel", accel_ ? variant().name : ""}};
        film_.addTo(s);
        return s;
    }

private:
    /// The least able kernel that knows everything the scene and the camera hold.
    const PathVariant& variant() const
    {
        uint32_t needed = accel_->world().features & ~shared::kFeatureThinLens;
        if (camera_.apertureRadius > 0) needed |= shared::kFeatureThinLens;
        for (const PathVariant& v : pathVariants()) {
            if ((needed & ~v.features) == 0) return v;
        }
        return pathVariants().back();
    }

    std::unique_ptr<Accel> accel_;
    Camera camera_;
    PathParams params_;
    TiledFilm film_;
};

}  // namespace

std::unique_ptr<Renderer> makePathTracer()
{
    return std::make_unique<PathTracer>();
}

std::span<const MethodPreset> pathPresets()
{
    static const std::array kPresets{
        MethodPreset{"preview", PathParams{.maxDepth = 3},
                     "light and two bounces: quick, too dark indoors"},
        MethodPreset{"balanced", PathParams{}, "the defaults: eight events suffice for most rooms"},
        MethodPreset{"deep glass", PathParams{.maxDepth = 32},
                     "glass in glass, water, mirrors facing each other"},
        MethodPreset{"direct light", PathParams{.maxDepth = 1},
                     "emitters and what they light directly"},
        MethodPreset{"no fireflies", PathParams{.clampIndirect = 10},
                     "bounds indirect samples: calmer, darker, biased"},
        MethodPreset{"formulas", PathParams{.sampler = SamplerKind::independent},
                     "independent samples: error estimates and slopes hold exactly"},
    };
    return kPresets;
}

}  // namespace core
