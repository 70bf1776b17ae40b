// Guided path tracing on Vulkan: batches of paths (path_batches.h) with kernels that look into the
// guide, which learns on the host from what recorded paths have left (core/methods/
// guide_training.h). A finished guide takes the place of the last one between two batches.
#include "app/gpu/guided_buffers.h"
#include "app/gpu/methods/methods.h"
#include "app/gpu/tiled_film.h"
#include "core/base/check.h"
#include "core/methods/guide_maps.h"
#include "core/methods/guide_training.h"
#include "core/methods/sky_slot.h"
#include "spirv/guided_bounce.h"
#include "spirv/guided_megakernel.h"

namespace gpu {

namespace {

/// Measured on Mesa's software device, where lanes that leave the guide alone wait for those that
/// do not: a look takes nearly all of it.
constexpr core::guiding::PathCosts kCosts{.connection = 1, .look = 0.55, .choice = 0.22};

class GuidedPaths final : public core::Renderer {
public:
    explicit GuidedPaths(const DeviceOptions& options)
        : context_(options), film_(context_),
          batches_(context_, {k_guided_bounce, k_guided_megakernel}), buffers_(context_)
    {}

    void setWorld(std::shared_ptr<const core::World> world, const core::Progress& progress) override
    {
        film_.drop();
        sky_.forget();
        training_.beginScene(kCosts.among(world->triangles.size()), core::guideBox(*world));
        if (!takeWorld(scene_, world_, std::move(world), context_, progress))
            batches_.forgetScene();
    }

    void prepare(const core::AnyParams& params, const core::Progress& progress) override
    {
        sky_.prepare(params.as<core::GuidedParams>().sky, world_, progress);
    }

    std::optional<core::Aovs> look(const core::View& view) override
    {
        CHECK(world_ != nullptr && view.size.x > 0 && view.size.y > 0);
        const auto& params = view.params.as<core::GuidedParams>();
        PathConstants constants = constantsFor(view, params);
        constants.guided = core::guideKindOf(params);
        if (batches_.isCompiled(constants)) return std::nullopt;
        return film_.look(*scene_, frameFor(view, params), pace_.dispatchSeconds);
    }

    void setView(const core::View& view, core::Start start) override
    {
        CHECK(world_ != nullptr && view.size.x > 0 && view.size.y > 0);
        params_ = view.params.as<core::GuidedParams>();
        training_.begin(params_, view.size, start);
        scene_->setSky(sky_.take(params_.sky, world_));
        film_.reset(frameFor(view, params_));
        withoutGuide_ = withGuide_ = constantsFor(view, params_);
        withGuide_.guided = core::guideKindOf(params_);
        const bool rests = training_.isIdleAfter(0) && batches_.isCompiled(withoutGuide_);
        const PathWork work{scene_.get(),        &film_.frame(), rests ? withoutGuide_ : withGuide_,
                            core::Strategy::mis, params_.kernel, world_->triangles.size(),
                            pace_.whole};
        batches_.makeRoom(film_.frame());
        buffers_.makeRoom(film_.frame(), batches_);
        buffers_.setGuide(*training_.tables(), batches_);
        records_.assign(film_.frame().tileCount(), {});
        film_.begin(batches_.radiance());
        compileSeconds_ += batches_.prepare(work, film_.accumulate());
    }

    void setPace(const core::Pace& pace) override { pace_ = context_.paceFor(pace); }

    void advance(const core::Budget& budget, std::stop_token stop) override
    {
        if (!training_.isOn()) return render(budget, stop);
        training_.advance(
            budget, stop, [this] { return film_.progress().samples; },
            [&](const core::Budget& part) {
                setRules(training_.rulesAfter(film_.progress().samples));
                render(part, stop);
            },
            [this](uint64_t samples) { learn(samples); },
            [this] { return film_.read(core::Reading::everything); });
    }

    core::RenderProgress progress() const override { return film_.progress(); }
    core::Estimate read(core::Reading what) override
    {
        if (!training_.pictures().isOn()) return film_.read(what);
        return training_.pictures().picture(film_.read(core::Reading::everything));
    }
    core::Aovs aovs() override { return film_.aovs(*scene_, pace_.dispatchSeconds); }
    core::Aovs surfaces(const core::Camera& camera, glm::uvec2 size, core::Sight sight) override
    {
        return film_.surfaces(*scene_, frameOf(*world_, *scene_, {camera, size, {}}), sight,
                              pace_.dispatchSeconds);
    }
    void prepareAovs() override { film_.prepareAovs(*scene_); }

    std::vector<core::Image> maps() override
    {
        if (film_.progress().samples == 0) return {};
        return core::makeGuideMaps(aovs(), film_.frame().data().camera, training_.guide());
    }

    std::shared_ptr<const core::PlaceProbe> probe() override
    {
        if (!training_.isOn()) return nullptr;
        return core::makeGuideProbe(aovs(), film_.frame().data().camera, training_.tables());
    }

    core::RenderStats stats() const override
    {
        core::RenderStats stats = context_.stats();
        if (scene_) scene_->addTo(stats);
        stats.compileSeconds = compileSeconds_;
        stats.details = training_.details();
        std::string kernel = batches_.kernelName();
        if (!kernel.empty() && training_.isOn() && batches_.constants() == withoutGuide_)
            kernel += " without the guide";
        stats.details.push_back({"kernel", kernel});
        sky_.addTo(stats);
        film_.addTo(stats);
        return stats;
    }

private:
    PathConstants constantsFor(const core::View& view, const core::GuidedParams& params) const
    {
        PathConstants constants;
        constants.features = scene_->features();
        if (view.camera.hasLens()) constants.features |= shared::kFeatureThinLens;
        constants.sampler = static_cast<uint32_t>(params.sampler);
        constants.nee = core::neeOf(params);
        return constants;
    }

    shared::FrameData frameFor(const core::View& view, const core::GuidedParams& params) const
    {
        shared::FrameData frame = frameOf(*world_, *scene_, view);
        frame.settings.seed = training_.seed();
        frame.settings.samplerKind = static_cast<uint32_t>(params.sampler);
        frame.settings.strategy =
            params.nee == core::GuidedNee::none ? shared::kStrategyBsdf : shared::kStrategyMis;
        frame.settings.maxDepth = params.maxDepth;
        frame.settings.rouletteDepth = params.rouletteDepth;
        return frame;
    }

    /// Paths that have nothing to do with the guide give the same radiance without what it takes,
    /// for which the lanes of a software device wait whether or not they need it.
    void chooseKernels()
    {
        if (training_.isOn() && !training_.isIdleAfter(film_.progress().samples))
            batches_.exchange(withGuide_);
        else
            batches_.exchangeWhenCompiled(withoutGuide_);
        batches_.chooseKernel(lanes());
    }

    void setRules(uint32_t rules)
    {
        shared::FrameData data = film_.frame().data();
        if (data.settings.guidedRules == rules) return;
        data.settings.guidedRules = rules;
        film_.frame().write(data);
    }

    uint32_t lanes() const
    {
        const uint32_t stride = shared::recordStride(film_.frame().data().settings);
        const uint32_t most =
            stride > 0 ? GuidedBuffers::kMostRecorded * stride : batches_.mostLanes();
        return std::min(batches_.lanes(pace_.dispatchSeconds), most);
    }

    void render(const core::Budget& budget, const std::stop_token& stop)
    {
        film_.advance(
            budget, stop, [this] { return lanes(); },
            [this](const shared::Batch& batch, const TiledFilm::Then& then) {
                batches_.trace(batch, then);
                buffers_.collect(film_.frame(), batch, records_);
            },
            [this] { chooseKernels(); });
    }

    void learn(uint64_t samples)
    {
        training_.learn(records_, samples, film_.read(core::Reading::mean).mean);
        buffers_.setGuide(*training_.tables(), batches_);
        buffers_.setEstimates(training_.estimates());
    }

    Context context_;  // first: everything below is made on its device
    TiledFilm film_;
    PathBatches batches_;
    GuidedBuffers buffers_;
    PathConstants withGuide_, withoutGuide_;
    core::GuideTraining training_;
    core::GuidedParams params_;
    std::vector<core::guiding::PathRecords> records_;  // of each tile
    std::unique_ptr<GpuScene> scene_;
    core::SkySlot sky_;
    std::shared_ptr<const core::World> world_;
    core::Pace pace_;
    double compileSeconds_ = 0;
};

}  // namespace

std::unique_ptr<core::Renderer> makeGuidedPaths(const DeviceOptions& options)
{
    return std::make_unique<GuidedPaths>(options);
}

}  // namespace gpu
