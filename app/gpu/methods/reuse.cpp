// Path tracing that keeps its samples when the camera moves: the kernels of reuse_passes.h go to
// the film (tiled_film.h), one sample per pixel and round.
#include "app/gpu/methods/methods.h"
#include "app/gpu/reuse_passes.h"
#include "core/base/check.h"
#include "core/base/time.h"
#include "core/methods/reuse_settings.h"
#include "core/scene/moved_pieces.h"

namespace gpu {

namespace {

class SampleReuse final : public core::Renderer {
public:
    explicit SampleReuse(const DeviceOptions& options)
        : context_(options), film_(context_), passes_(context_)
    {}

    void setWorld(std::shared_ptr<const core::World> world, const core::Progress& progress) override
    {
        film_.drop();
        if (takeWorld(scene_, world_, std::move(world), context_, progress)) return;
        passes_.forget();
        kept_ = {};
        batchPace_.restart();
    }

    void setView(const core::View& view, core::Start start) override
    {
        CHECK(world_ != nullptr && view.size.x > 0 && view.size.y > 0);
        const core::ReuseParams& params = view.params.as<core::ReuseParams>();
        if (start == core::Start::anew) samplesBefore_ = 0;
        visibility_ = core::askedVisibility(params_, visibility_, film_.counts().reuse);
        perDeviation_ = core::partPerDeviation(params_, perDeviation_, film_.counts().reuse);
        if (start == core::Start::anew || !(params == params_) || !takeMotion(params)) {
            passes_.forget();
            visibility_ = core::askedVisibility(params, 0, {});
            perDeviation_ = 0;
        }
        params_ = params;
        shared::FrameData frame = frameOf(*world_, *scene_, view);
        core::setPathSettings(params, frame.settings);
        film_.reset(frame);
        shared::ReuseSettings settings = core::reuseSettings(params);
        settings.visibility = visibility_;
        settings.flags = core::reuseFlags(params, 0, core::mayMove(*world_));
        const bool chains = (scene_->features() & shared::kFeatureDelta) != 0;
        passes_.prepare(view.size, film_.frame().tileCount(), settings, perDeviation_, chains);
        for (DescriptorSet& set : passes_.filmSets())
            film_.begin(set, core::mostPathsOfPixel(params));
        constants_.features =
            scene_->features() & ~(shared::kFeatureEmitterTree | shared::kFeaturePanes);
        if (view.camera.apertureRadius > 0) constants_.features |= shared::kFeatureThinLens;
        if (core::mayMove(*world_) && core::followsMotion(params))
            constants_.features |= shared::kFeatureMoves;
        if (params.bias != core::ReuseBias::fast)
            constants_.features |= shared::kFeatureAsksVisibility;
        constants_.sampler = static_cast<uint32_t>(params.sampler);
        const core::Clock::time_point begin = core::Clock::now();
        if (passes_.compile(*scene_, film_.frame(), constants_))
            compileSeconds_ += core::secondsSince(begin);
        rounds_ = 0;
        batchPace_.again();
    }

    void setPace(const core::Pace& pace) override { pace_ = pace; }

    void advance(const core::Budget& budget, std::stop_token stop) override
    {
        // One sample per pixel and round: each round looks at what the one before has kept.
        const uint32_t most =
            std::min(passes_.mostLanes(), film_.frame().tileCount() * shared::kGroupSize);
        film_.advance(
            budget, stop, [this, most] { return batchPace_.lanes(pace_.dispatchSeconds, most); },
            [this](const shared::Batch& batch, const TiledFilm::Then&) { trace(batch); });
    }

    core::RenderProgress progress() const override { return film_.progress(); }
    core::Estimate read(core::Reading what) override { return film_.read(what); }
    core::Aovs aovs() override { return film_.aovs(*scene_, pace_.dispatchSeconds); }
    void prepareAovs() override { film_.prepareAovs(*scene_); }

    std::vector<core::Image> maps() override
    {
        if (rounds_ == 0) return {};
        return passes_.maps({film_.frame().width(), film_.frame().height()});
    }

    core::RenderStats stats() const override
    {
        core::RenderStats stats = context_.stats();
        if (scene_) scene_->addTo(stats);
        stats.compileSeconds = compileSeconds_;
        const core::ReuseFigures& figures = film_.counts().reuse;
        const double pixels = double(film_.frame().width()) * film_.frame().height();
        // Figures are of the round under way, too.
        stats.details = figures.details(params_, world_ && core::mayMove(*world_), visibility_,
                                        recordsOf(passes_.settings()),
                                        pixels * (rounds_ + film_.progress().fraction));
        film_.addTo(stats);
        stats.paths = static_cast<uint64_t>(figures.paths);
        return stats;
    }

private:
    /// The pose that what is kept belongs to.
    struct Kept {
        std::shared_ptr<const core::World> world;
        std::shared_ptr<const core::Bvh> hierarchy;
    };

    /// Finds what has moved since the last whole round; false where nothing of it may be kept.
    bool takeMotion(const core::ReuseParams& params)
    {
        passes_.rest();
        if (!kept_.world || kept_.world == world_) return true;
        if (!core::followsMotion(params)) return false;
        const auto pieces = core::movedPieces(*kept_.world, *world_);
        return pieces && passes_.takeMotion(*scene_, *kept_.world, *kept_.hierarchy, *pieces);
    }

    void trace(shared::Batch batch)
    {
        const uint32_t lanes = batch.tileCount * shared::kGroupSize;
        const bool last = batch.firstTile + batch.tileCount == film_.frame().tileCount();
        batch.firstSample = samplesBefore_;
        batchPace_.measured(
            lanes, passes_.run(*scene_, film_.frame(), constants_, batch,
                               core::reuseFlags(params_, rounds_, core::mayMove(*world_))));
        if (!last) return;
        passes_.commit(film_.frame().data().camera);
        kept_ = {world_, scene_->sharedHierarchy()};
        samplesBefore_ += core::samplesOfPass(params_, rounds_);
        ++rounds_;
    }

    Context context_;  // first: everything below is made on its device
    TiledFilm film_;
    ReusePasses passes_;
    std::unique_ptr<GpuScene> scene_;
    std::shared_ptr<const core::World> world_;
    Kept kept_;
    core::ReuseParams params_;
    ReuseConstants constants_;
    core::Pace pace_;
    BatchPace batchPace_;
    float visibility_ = 0;        // share of samples whose visibility is asked for again
    float perDeviation_ = 0;      // see shared::allocatedPart
    uint32_t rounds_ = 0;         // whole ones, of this view
    uint32_t samplesBefore_ = 0;  // of all views since the last that began anew
    double compileSeconds_ = 0;
};

}  // namespace

std::unique_ptr<core::Renderer> makeSampleReuse(const DeviceOptions& options)
{
    return std::make_unique<SampleReuse>(options);
}

}  // namespace gpu
