// Guided path tracing on all cores: the path tracer's loop with a guide that learns from its paths
// (shaders/shared/guided_path.h, core/guiding/guide.h). All samples are in the picture; each is
// unbiased, whatever the guide knew then. The guide learns between passes, so that the picture
// depends neither on threads nor on pauses; it goes on from view to view.
#include <array>

#include "core/methods/guide_maps.h"
#include "core/methods/guide_training.h"
#include "core/methods/guided_kernel.h"
#include "core/methods/method.h"
#include "core/methods/tiled_renderer.h"

namespace core {

std::span<const GuidedVariant> guidedVariants()
{
    using namespace shared;
    static constexpr GuidedVariant kVariants[] = {
        {kFeatureEmissiveTriangles | kFeatureManyEmitters, renderFlatGuidedTile},
        {~kFeatureEmitterTree, renderAnyGuidedTile},
        {0xffffffffu, renderAnyTreeGuidedTile},
    };
    return kVariants;
}

namespace {

/// Measured in cbox-diffuse.
constexpr guiding::PathCosts kCosts{.connection = 1, .look = 0.35, .choice = 0.85};

class GuidedPathTracer : public TiledRenderer {
public:
    void setWorld(std::shared_ptr<const World> world, const Progress& progress) override
    {
        training_.beginScene(kCosts.among(world->triangles.size()), guideBox(*world));
        TiledRenderer::setWorld(std::move(world), progress);
    }

    void setView(const View& view, Start start) override
    {
        TiledRenderer::setView(view, start);
        training_.begin(params_, view.size, start);
        const glm::uvec2 tiles = (view.size + kFilmTile - 1u) / kFilmTile;
        tilesPerRow_ = tiles.x;
        records_.assign(size_t(tiles.x) * tiles.y, {});
    }

    void advance(const Budget& budget, std::stop_token stop) override
    {
        if (!training_.isOn()) return film_.advance(budget, stop, plainTiles());
        training_.advance(
            budget, stop, [this] { return film_.progress().samples; },
            [&](const Budget& part) {
                const bool plain = training_.isIdleAfter(film_.progress().samples);
                film_.advance(part, stop, plain ? plainTiles() : guidedTiles());
            },
            [this](uint64_t samples) {
                training_.learn(records_, samples, film_.estimate(Reading::mean).mean);
            },
            [this] { return film_.estimate(Reading::everything); });
    }

    Estimate read(Reading what) override
    {
        if (!training_.pictures().isOn()) return film_.estimate(what);
        return training_.pictures().picture(film_.estimate(Reading::everything));
    }

    RenderStats stats() const override
    {
        RenderStats stats = TiledRenderer::stats();
        stats.details = training_.details();
        sky_.addTo(stats);
        return stats;
    }

    std::vector<Image> maps() override
    {
        if (film_.progress().samples == 0) return {};
        return makeGuideMaps(aovs(), frameCamera(), training_.guide());
    }

    std::shared_ptr<const PlaceProbe> probe() override
    {
        if (!training_.isOn()) return nullptr;
        return makeGuideProbe(aovs(), frameCamera(), training_.tables());
    }

private:
    void setParams(const AnyParams& params) override
    {
        params_ = params.as<GuidedParams>();
        drawSky(params_.sky);
    }

    PathJob pathJob() const
    {
        PathJob job;
        job.settings = frameSettings();
        job.settings.seed = training_.seed();
        job.settings.samplerKind = static_cast<uint32_t>(params_.sampler);
        job.settings.strategy =
            params_.nee == GuidedNee::none ? shared::kStrategyBsdf : shared::kStrategyMis;
        job.settings.maxDepth = params_.maxDepth;
        job.settings.rouletteDepth = params_.rouletteDepth;
        job.accel = accel_.get();
        job.scene = frameScene();
        job.camera = frameCamera();
        return job;
    }

    /// The path tracer's: where nobody follows the guide, to the bit what guided tiles are.
    TiledFilm::RenderTile plainTiles() const
    {
        const PathKernel kernel = leastAble(pathVariants(), frameFeatures()).kernel;
        return [job = pathJob(), kernel](const Tile& tile, uint32_t first, uint32_t count,
                                         Film& film) {
            PathJob part = job;
            part.firstSample = first;
            part.sampleCount = count;
            return kernel(part, tile, film);
        };
    }

    TiledFilm::RenderTile guidedTiles()
    {
        const auto tables = training_.tables();
        GuidedJob job;
        job.path = pathJob();
        job.guide = tables->view();
        job.image = training_.estimates();
        job.path.settings.guidedRules = training_.rulesAfter(film_.progress().samples);
        const GuidedKernel kernel = leastAble(guidedVariants(), frameFeatures()).kernel;
        return [this, tables, job, kernel](const Tile& tile, uint32_t first, uint32_t count,
                                           Film& film) {
            GuidedJob part = job;
            part.path.firstSample = first;
            part.path.sampleCount = count;
            const size_t index = size_t(tile.y0 / kFilmTile) * tilesPerRow_ + tile.x0 / kFilmTile;
            return kernel(part, tile, film, records_[index]);
        };
    }

    GuidedParams params_;
    GuideTraining training_;
    std::vector<guiding::PathRecords> records_;  // of each tile
    uint32_t tilesPerRow_ = 0;
};

}  // namespace

std::unique_ptr<Renderer> makeGuidedPathTracer()
{
    return std::make_unique<GuidedPathTracer>();
}

/// T. Mueller, M. Gross, J. Novak, "Practical Path Guiding for Efficient Light-Transport
/// Simulation" (2017). What differs: leaves cut in an iteration learn from their own records, and
/// `training`, half of the samples that are to be taken, is told and not found.
static GuidedParams ppg()
{
    return {.guide = GuideKind::tree,
            .use = GuideUse::always,
            .space = GuideSpace::plain,
            .target = GuideTarget::radiance,
            .memory = GuideMemory::reset,
            .schedule = GuideSchedule::doubling,
            .training = 32,
            .recordOneIn = 1,
            .recordsPerLeaf = 6000,
            .share = 0.5f,
            .nee = GuidedNee::none,
            .roulette = GuidedRoulette::none,
            .combine = Combine::samples,
            .combineLast = 1};
}

/// T. Mueller, "Path Guiding in Production" (SIGGRAPH course, 2019).
static GuidedParams ppgProduction()
{
    GuidedParams params = ppg();
    params.filter = GuideFilter::spread;
    params.recordsPerLeaf = 2000;
    params.share = 0;
    params.shareBy = ShareBy::adam;
    params.nee = GuidedNee::mixture;
    params.combine = Combine::inverseVariance;
    params.combineLast = 4;
    return params;
}

std::span<const MethodPreset> guidedPresets()
{
    static const std::array kPresets{
        MethodPreset{"guided", GuidedParams{}, "the defaults: learns, and guides where it pays"},
        MethodPreset{"finer", GuidedParams{.training = 128, .recordsPerLeaf = 250},
                     "smaller leaves, longer training: for pictures of many samples"},
        MethodPreset{"ppg", ppg(),
                     "practical path guiding as published in 2017, of half the budget"},
        MethodPreset{"ppg-production", ppgProduction(),
                     "the same as its authors improved it in 2019"},
        MethodPreset{"no guide", GuidedParams{.training = 0}, "the path tracer, to compare"},
    };
    return kPresets;
}

}  // namespace core
