// Path tracing that keeps its samples when the camera moves: the kernels of reuse_passes.h go to
// the film (tiled_film.h), one sample per pixel and round. Once a view that rests has filled its
// history, batches of plain paths (path_batches.h) go on.
#include "app/gpu/methods/methods.h"
#include "app/gpu/path_batches.h"
#include "app/gpu/reuse_passes.h"
#include "core/base/check.h"
#include "core/base/time.h"
#include "core/methods/path_settings.h"
#include "core/methods/reuse_settings.h"
#include "core/scene/moved_pieces.h"

namespace gpu {

namespace {

class SampleReuse final : public core::Renderer {
public:
    explicit SampleReuse(const DeviceOptions& options)
        : context_(options), film_(context_), passes_(context_), plain_(context_)
    {}

    void setWorld(std::shared_ptr<const core::World> world, const core::Progress& progress) override
    {
        film_.drop();
        goesPlain_ = false;
        if (takeWorld(scene_, world_, std::move(world), context_, progress)) return;
        plain_.forgetScene();
        forget();
        kept_ = {};
        batchPace_.restart();
    }

    std::optional<core::Aovs> look(const core::View& view) override
    {
        CHECK(world_ != nullptr && view.size.x > 0 && view.size.y > 0);
        const auto& params = view.params.as<core::ReuseParams>();
        if (passes_.isCompiled(constantsFor(view, params), settingsFor(params)))
            return std::nullopt;
        shared::FrameData frame = frameOf(*world_, *scene_, view);
        core::setPathSettings(params, frame.settings);
        return film_.look(*scene_, frame, pace_.dispatchSeconds);
    }

    void setView(const core::View& view, core::Start start) override
    {
        CHECK(world_ != nullptr && view.size.x > 0 && view.size.y > 0);
        const core::ReuseParams& params = view.params.as<core::ReuseParams>();
        visibility_ = core::askedVisibility(params_, visibility_, film_.counts().reuse);
        perDeviation_ = core::partPerDeviation(params_, perDeviation_, film_.counts().reuse);
        samplesBefore_ += plainSamples_;
        plainSamples_ = 0;
        if (start == core::Start::anew) samplesBefore_ = 0;
        if (start == core::Start::anew || !(params == params_) || !takeMotion(params)) {
            forget();
            visibility_ = core::askedVisibility(params, 0, {});
            perDeviation_ = 0;
        }
        // Deeper paths, say, or more of them: the speed so far says nothing.
        if (!(params == params_))
            batchPace_.restart();
        else if (!pace_.whole)
            batchPace_.again();
        params_ = params;
        frame_ = frameOf(*world_, *scene_, view);
        shared::FrameData frame = frame_;
        core::setPathSettings(params, frame.settings);
        film_.reset(frame);
        shared::ReuseSettings settings = settingsFor(params);
        settings.visibility = visibility_;
        const bool chains = (scene_->features() & shared::kFeatureDelta) != 0;
        passes_.prepare(view.size, film_.frame().tileCount(), settings, raysOfPath(params),
                        perDeviation_, chains);
        for (DescriptorSet& set : passes_.filmSets())
            film_.begin(set, core::mostPathsOfPixel(params));
        constants_ = constantsFor(view, params);
        const core::Clock::time_point begin = core::Clock::now();
        if (passes_.compile(*scene_, film_.frame(), constants_))
            compileSeconds_ += core::secondsSince(begin);
        rounds_ = 0;
        goesPlain_ = false;
    }

    void setPace(const core::Pace& pace) override { pace_ = context_.paceFor(pace); }

    void advance(const core::Budget& budget, std::stop_token stop) override
    {
        const core::Clock::time_point begin = core::Clock::now();
        uint32_t samples = budget.samples;
        if (const uint32_t most = core::passesOfHistory(params_); rounds_ < most) {
            const uint32_t had = rounds_;
            takePasses({std::min(samples, most - had), budget.seconds}, stop);
            samples -= std::min(samples, rounds_ - had);
            const bool over = stop.stop_requested() || core::secondsSince(begin) >= budget.seconds;
            if (rounds_ < most || samples == 0 || over) return;
        }
        takePlainPaths({samples, budget.seconds - core::secondsSince(begin)}, stop);
    }

    core::RenderProgress progress() const override { return film_.progress(); }
    core::Estimate read(core::Reading what) override { return film_.read(what); }
    core::Aovs aovs() override { return film_.aovs(*scene_, pace_.dispatchSeconds); }
    core::Aovs surfaces(const core::Camera& camera, glm::uvec2 size, core::Sight sight) override
    {
        return film_.surfaces(*scene_, frameOf(*world_, *scene_, {camera, size, {}}), sight,
                              pace_.dispatchSeconds);
    }
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
        const double part = goesPlain_ ? 0 : film_.progress().fraction;
        stats.details = figures.details(params_, world_ && core::mayMove(*world_), visibility_,
                                        recordsOf(passes_.settings()), pixels * (rounds_ + part),
                                        plainSamples_);
        film_.addTo(stats);
        const uint64_t plain =
            goesPlain_ ? stats.paths - uint64_t(rounds_) * static_cast<uint64_t>(pixels) : 0;
        stats.paths = static_cast<uint64_t>(figures.paths) + plain;
        return stats;
    }

private:
    /// The pose that what is kept belongs to.
    struct Kept {
        std::shared_ptr<const core::World> world;
        std::shared_ptr<const core::Bvh> hierarchy;
    };

    ReuseConstants constantsFor(const core::View& view, const core::ReuseParams& params) const
    {
        ReuseConstants constants;
        constants.features =
            core::reuseFeatures(params, scene_->features(), core::mayMove(*world_));
        if (view.camera.hasLens()) constants.features |= shared::kFeatureThinLens;
        constants.sampler = static_cast<uint32_t>(params.sampler);
        return constants;
    }

    /// Of a view's first pass.
    shared::ReuseSettings settingsFor(const core::ReuseParams& params) const
    {
        shared::ReuseSettings settings = core::reuseSettings(params);
        settings.flags = core::reuseFlags(params, 0, core::mayMove(*world_));
        return settings;
    }

    /// Rays of a path at most: a connection through a pane takes three; few lie through several.
    uint32_t raysOfPath(const core::ReuseParams& params) const
    {
        const bool panes = core::connectsThroughPanes(scene_->features());
        return (panes ? 4 : 2) * params.maxDepth + 1;
    }

    /// Finds what has moved since the last whole round; false where nothing of it may be kept.
    bool takeMotion(const core::ReuseParams& params)
    {
        passes_.rest();
        if (!kept_.world) return true;
        // A pose may come back in another order, when it was built anew in between.
        if (kept_.world == world_ && kept_.hierarchy == scene_->sharedHierarchy()) return true;
        if (!core::followsMotion(params)) return false;
        const auto pieces = core::movedPieces(*kept_.world, *world_);
        return pieces && passes_.takeMotion(*scene_, *kept_.world, *kept_.hierarchy, *pieces);
    }

    void forget()
    {
        passes_.forget();
        history_ = 0;
    }

    /// New paths that a pixel may take in the pass that comes now: what the pace counts in, since
    /// `full` takes one in some passes, and as many as its history stands for in others.
    uint32_t pathsOfLane() const
    {
        if (rounds_ > 0) return 1;
        const bool full = params_.reuse == core::ReuseStrategy::full;
        return static_cast<uint32_t>(
            std::ceil(std::max(params_.rays, 1.0f) + (full ? history_ : 0.0f)));
    }

    /// One sample per pixel and round: each round looks at what the one before has kept.
    void takePasses(const core::Budget& budget, const std::stop_token& stop)
    {
        const uint32_t most =
            std::min(passes_.mostLanes(), film_.frame().tileCount() * shared::kGroupSize);
        film_.advance(
            budget, stop,
            [this, most] {
                const uint32_t paths = pathsOfLane();
                return batchPace_.lanes(pace_.dispatchSeconds, most * paths) / paths;
            },
            [this](const shared::Batch& batch, const TiledFilm::Then&) { trace(batch); });
    }

    void takePlainPaths(const core::Budget& budget, const std::stop_token& stop)
    {
        if (!goesPlain_) beginPlainPaths();
        const uint64_t had = film_.progress().samples;
        film_.advance(
            budget, stop, [this] { return plain_.lanes(pace_.dispatchSeconds); },
            [this](shared::Batch batch, const TiledFilm::Then& then) {
                batch.firstSample += samplesBefore_ - rounds_;
                plain_.trace(batch, then);
            },
            [this] { plain_.chooseKernel(plain_.lanes(pace_.dispatchSeconds)); });
        plainSamples_ += static_cast<uint32_t>(film_.progress().samples - had);
    }

    /// The film goes on as it is; its frame becomes that of plain paths.
    void beginPlainPaths()
    {
        const core::PathParams params = core::plainPaths(params_);
        core::setPathSettings(params, frame_.settings);
        film_.frame().write(frame_);
        plain_.makeRoom(film_.frame());
        film_.begin(plain_.radiance());
        PathConstants constants;
        constants.features = scene_->features() | (constants_.features & shared::kFeatureThinLens);
        constants.sampler = constants_.sampler;
        compileSeconds_ += plain_.prepare({scene_.get(), &film_.frame(), constants, params.strategy,
                                           params.kernel, world_->triangles.size(), pace_.whole},
                                          film_.accumulate());
        goesPlain_ = true;
    }

    void trace(shared::Batch batch)
    {
        const uint32_t lanes = batch.tileCount * shared::kGroupSize;
        const bool last = batch.firstTile + batch.tileCount == film_.frame().tileCount();
        batch.firstSample = samplesBefore_;
        batchPace_.measured(
            lanes * pathsOfLane(),
            passes_.run(*scene_, film_.frame(), constants_, batch,
                        core::reuseFlags(params_, rounds_, core::mayMove(*world_))));
        if (!last) return;
        passes_.commit(film_.frame().data().camera);
        kept_ = {world_, scene_->sharedHierarchy()};
        samplesBefore_ += core::samplesOfPass(params_, rounds_);
        history_ = std::min(history_ + (rounds_ > 0 ? 1.0f : std::max(params_.rays, 1.0f)),
                            core::reuseSettings(params_).cap);
        ++rounds_;
    }

    Context context_;  // first: everything below is made on its device
    TiledFilm film_;
    ReusePasses passes_;
    PathBatches plain_;
    std::unique_ptr<GpuScene> scene_;
    std::shared_ptr<const core::World> world_;
    Kept kept_;
    core::ReuseParams params_;
    shared::FrameData frame_{};  // of the view; methods have not added to it
    ReuseConstants constants_;
    core::Pace pace_;
    BatchPace batchPace_;
    float visibility_ = 0;        // share of samples whose visibility is asked for again
    float perDeviation_ = 0;      // see shared::allocatedPart
    float history_ = 0;           // N of what is kept, at most
    uint32_t rounds_ = 0;         // whole ones of this view that go to the history
    bool goesPlain_ = false;      // it has all that it can hold: paths of this view leave it alone
    uint32_t plainSamples_ = 0;   // of this view that have left the history alone
    uint32_t samplesBefore_ = 0;  // of all views since the last that began anew
    double compileSeconds_ = 0;
};

}  // namespace

std::unique_ptr<core::Renderer> makeSampleReuse(const DeviceOptions& options)
{
    return std::make_unique<SampleReuse>(options);
}

}  // namespace gpu
