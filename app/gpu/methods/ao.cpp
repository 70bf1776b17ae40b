// Ambient occlusion: one kernel, two rays a lane; film, rounds and pauses are TiledFilm's.
#include <bit>

#include "app/gpu/base/batch_pace.h"
#include "app/gpu/methods/methods.h"
#include "app/gpu/tiled_film.h"
#include "core/base/check.h"
#include "core/base/time.h"
#include "shared/ao.h"
#include "spirv/occlusion.h"

namespace gpu {

namespace {

constexpr uint32_t kMaxLanes = 1u << 18;

/// What the kernel is specialised on.
struct OcclusionConstants {
    static constexpr uint32_t kFirst = 0;
    uint32_t features = 0xffffffffu;  // number 0: lang.h
    uint32_t sampler = 0;             // shared::kSpecializeSampler
};

class AmbientOcclusion final : public core::Renderer {
public:
    explicit AmbientOcclusion(const DeviceOptions& options)
        : context_(options), film_(context_),
          kernel_(context_.device, k_occlusion, &context_.layouts),
          set_(context_.device, kernel_.own())
    {}

    void setWorld(std::shared_ptr<const core::World> world, const core::Progress& progress) override
    {
        film_.drop();
        if (!takeWorld(scene_, world_, std::move(world), context_, progress)) batchPace_.restart();
    }

    void setView(const core::View& view, core::Start) override
    {
        CHECK(world_ != nullptr && view.size.x > 0 && view.size.y > 0);
        const core::AoParams& params = view.params.as<core::AoParams>();
        shared::FrameData frame = frameOf(*world_, *scene_, view);
        frame.settings.seed = params.seed;
        frame.settings.samplerKind = static_cast<uint32_t>(params.sampler);
        film_.reset(frame);
        makeRoom();
        film_.begin(radiance_);
        reach_ = params.distance * static_cast<float>(world_->placement.scale);
        constants_.features = scene_->features();
        if (view.camera.hasLens()) constants_.features |= shared::kFeatureThinLens;
        constants_.sampler = static_cast<uint32_t>(params.sampler);
        compile();
        if (!pace_.whole) batchPace_.again();
    }

    void setPace(const core::Pace& pace) override { pace_ = context_.paceFor(pace); }

    void advance(const core::Budget& budget, std::stop_token stop) override
    {
        const auto most = static_cast<uint32_t>(radiance_.bytes() / sizeof(glm::vec4));
        film_.advance(
            budget, stop, [this, most] { return batchPace_.lanes(pace_.dispatchSeconds, most); },
            [this](const shared::Batch& batch, const TiledFilm::Then& then) {
                const uint32_t lanes = batch.tileCount * batch.sampleCount * shared::kGroupSize;
                batchPace_.measured(lanes, trace(batch, then, "occlusion"));
            });
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
        core::RenderStats stats = context_.stats();
        if (scene_) scene_->addTo(stats);
        stats.compileSeconds = compileSeconds_;
        film_.addTo(stats);
        return stats;
    }

private:
    /// A word per lane, in few sizes: see PathBatches::makeRoom.
    void makeRoom()
    {
        const uint32_t wanted = film_.frame().tileCount() * shared::kGroupSize;
        const uint32_t lanes = std::bit_ceil(std::clamp(wanted, 1u << 16, kMaxLanes));
        if (radiance_.bytes() >= lanes * sizeof(glm::vec4)) return;
        radiance_ = {};
        radiance_ = Buffer(context_.device, "the occlusion", lanes * sizeof(glm::vec4));
        set_.bind(shared::kBindRadiance, radiance_);
    }

    /// Software drivers compile at the first dispatch: an empty batch makes them do it now.
    void compile()
    {
        if (kernel_.isCompiled(constants_)) return;
        const core::Clock::time_point start = core::Clock::now();
        trace({0, 1, 0, 0}, film_.accumulate(), "the compilation of the kernels");
        compileSeconds_ += core::secondsSince(start);
    }

    /// Returns the seconds that the device was busy.
    double trace(const shared::Batch& batch, const TiledFilm::Then& then, const char* what)
    {
        const Pipeline& pipeline = kernel_.pipeline(constants_);
        const KernelSets sets{&scene_->set(), &film_.frame().set(), &set_};
        const uint64_t lanes =
            uint64_t(batch.tileCount) * std::max(batch.sampleCount, 1u) * shared::kGroupSize;
        return context_.device.submit(
            [&](VkCommandBuffer commands) {
                kernel_.dispatch(commands, pipeline, sets, {batch, reach_}, groupsFor(lanes));
                barrier(commands);
                then(commands, batch);
            },
            what);
    }

    Context context_;  // first: everything below is made on its device
    TiledFilm film_;
    Kernel<shared::OcclusionBatch, OcclusionConstants> kernel_;
    DescriptorSet set_;
    Buffer radiance_;
    std::unique_ptr<GpuScene> scene_;
    std::shared_ptr<const core::World> world_;
    OcclusionConstants constants_;
    float reach_ = 0;
    core::Pace pace_;
    BatchPace batchPace_;
    double compileSeconds_ = 0;
};

}  // namespace

std::unique_ptr<core::Renderer> makeAmbientOcclusion(const DeviceOptions& options)
{
    return std::make_unique<AmbientOcclusion>(options);
}

}  // namespace gpu
