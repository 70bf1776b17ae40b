// Progressive path tracing: batches of paths (path_batches.h) go to the film (tiled_film.h).
#include "app/gpu/methods/path.h"

#include "app/gpu/path_batches.h"
#include "app/gpu/tiled_film.h"
#include "core/base/check.h"
#include "core/methods/path_settings.h"
#include "core/methods/sky_slot.h"

namespace gpu {

namespace {

shared::FrameData frameFor(const core::World& world, const GpuScene& scene, const core::View& view,
                           const core::PathParams& params)
{
    shared::FrameData frame = frameOf(world, scene, view);
    core::setPathSettings(params, frame.settings);
    return frame;
}

class PathRenderer final : public core::Renderer {
public:
    explicit PathRenderer(std::shared_ptr<Context> context)
        : context_(std::move(context)), film_(*context_), batches_(*context_)
    {}

    void setWorld(std::shared_ptr<const core::World> world, const core::Progress& progress) override
    {
        film_.drop();
        sky_.forget();
        if (!takeWorld(scene_, world_, std::move(world), *context_, progress))
            batches_.forgetScene();
    }

    void prepare(const core::AnyParams& params, const core::Progress& progress) override
    {
        sky_.prepare(params.as<core::PathParams>().sky, world_, progress);
    }

    std::optional<core::Aovs> look(const core::View& view) override
    {
        CHECK(world_ != nullptr && view.size.x > 0 && view.size.y > 0);
        const core::PathParams& params = view.params.as<core::PathParams>();
        if (batches_.isCompiled(constantsFor(view, params))) return std::nullopt;
        return film_.look(*scene_, frameFor(*world_, *scene_, view, params), pace_.dispatchSeconds);
    }

    /// A path keeps nothing of the view before.
    void setView(const core::View& view, core::Start) override
    {
        CHECK(world_ != nullptr && view.size.x > 0 && view.size.y > 0);
        const core::PathParams& params = view.params.as<core::PathParams>();
        scene_->setSky(sky_.take(params.sky, world_));
        film_.reset(frameFor(*world_, *scene_, view, params));
        const PathWork work{scene_.get(),    &film_.frame(), constantsFor(view, params),
                            params.strategy, params.kernel,  world_->triangles.size(),
                            pace_.whole};
        batches_.makeRoom(film_.frame());
        film_.begin(batches_.radiance());
        compileSeconds_ += batches_.prepare(work, film_.accumulate());
    }

    void setPace(const core::Pace& pace) override { pace_ = context_->paceFor(pace); }

    void advance(const core::Budget& budget, std::stop_token stop) override
    {
        film_.advance(
            budget, stop, [this] { return batches_.lanes(pace_.dispatchSeconds); },
            [this](const shared::Batch& batch, const TiledFilm::Then& then) {
                batches_.trace(batch, then);
            },
            [this] { batches_.chooseKernel(batches_.lanes(pace_.dispatchSeconds)); });
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

    core::RenderStats stats() const override
    {
        core::RenderStats stats = context_->stats();
        if (scene_) scene_->addTo(stats);
        stats.compileSeconds = compileSeconds_;
        stats.details = {{"kernel", std::string(batches_.kernelName())}};
        sky_.addTo(stats);
        film_.addTo(stats);
        return stats;
    }

private:
    PathConstants constantsFor(const core::View& view, const core::PathParams& params) const
    {
        PathConstants constants;
        constants.features = scene_->features();
        if (view.camera.hasLens()) constants.features |= shared::kFeatureThinLens;
        constants.sampler = static_cast<uint32_t>(params.sampler);
        return constants;
    }

    std::shared_ptr<Context> context_;  // first: everything below is made on its device
    TiledFilm film_;
    PathBatches batches_;
    std::unique_ptr<GpuScene> scene_;
    core::SkySlot sky_;
    std::shared_ptr<const core::World> world_;
    core::Pace pace_;
    double compileSeconds_ = 0;
};

}  // namespace

std::unique_ptr<core::Renderer> makePathRendererOn(std::shared_ptr<Context> context)
{
    return std::make_unique<PathRenderer>(std::move(context));
}

std::unique_ptr<core::Renderer> makePathRenderer(const DeviceOptions& options)
{
    return makePathRendererOn(std::make_shared<Context>(options));
}

}  // namespace gpu
