// The path tracer on all cores: reference for every other renderer, and `--device cpu`. The
// estimator is that of shaders/shared/path.h; a sample depends on seed, pixel and index alone.
#include <array>

#include "core/methods/method.h"
#include "core/methods/path_kernel.h"
#include "core/methods/path_settings.h"
#include "core/methods/tiled_renderer.h"

namespace core {

std::span<const PathVariant> pathVariants()
{
    using namespace shared;
    static constexpr PathVariant kVariants[] = {
        {"flat", kFeatureEmissiveTriangles | kFeatureManyEmitters, renderFlatTile},
        {"flat, emitters by place",
         kFeatureEmissiveTriangles | kFeatureManyEmitters | kFeatureEmitterTree,
         renderFlatTreeTile},
        {"any", ~kFeatureEmitterTree, renderAnyTile},
        {"any, emitters by place", 0xffffffffu, renderAnyTreeTile},
    };
    return kVariants;
}

namespace {

class PathTracer : public TiledRenderer {
public:
    void advance(const Budget& budget, std::stop_token stop) override
    {
        PathJob job;
        job.settings = pathSettings();
        job.accel = accel_.get();
        job.scene = frameScene();
        job.camera = frameCamera();
        film_.advance(budget, stop,
                      [&, kernel = variant().kernel](const Tile& tile, uint32_t first,
                                                     uint32_t count, Film& film) {
                          PathJob part = job;
                          part.firstSample = first;
                          part.sampleCount = count;
                          return kernel(part, tile, film);
                      });
    }

    RenderStats stats() const override
    {
        RenderStats stats = TiledRenderer::stats();
        stats.details = {{"kernel", accel_ ? variant().name : ""}};
        sky_.addTo(stats);
        return stats;
    }

private:
    const PathVariant& variant() const { return leastAble(pathVariants(), frameFeatures()); }

    void setParams(const AnyParams& params) override
    {
        params_ = params.as<PathParams>();
        drawSky(params_.sky);
    }

    shared::PathSettings pathSettings() const
    {
        shared::PathSettings s = frameSettings();
        setPathSettings(params_, s);
        return s;
    }

    PathParams params_;
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
