// The kernels of sample reuse (shaders/reuse), one after the other over some tiles: first hits
// and backprojection, new samples, old samples and what is kept. New samples are paths that begin,
// bounce closed up, and end, a kernel each. Two stores take turns; what a pass has written becomes
// what the next one reads only when the pass is whole.
#pragma once

#include <array>
#include <vector>

#include "app/gpu/base/batch_pace.h"
#include "app/gpu/context.h"
#include "app/gpu/reuse_motion.h"
#include "app/gpu/tiled_film.h"
#include "core/image/image.h"

namespace gpu {

/// What the kernels are specialised on.
struct ReuseConstants {
    static constexpr uint32_t kFirst = 0;
    uint32_t features = 0xffffffffu;  // number 0: lang.h
    uint32_t sampler = 0;             // shared::kSpecializeSampler
    uint32_t records = 0;             // these by ReusePasses: see shared::kSpecializeRecords
    uint32_t lights = 0;
    uint32_t fresh = 0;
};

class ReusePasses {
public:
    using TwoSets = std::array<DescriptorSet, 2>;

    explicit ReusePasses(Context& context);

    /// Forgets what is kept.
    void forget()
    {
        camera_ = {};
        motion_.rest();
    }

    /// Nothing has moved since the last whole pass.
    void rest() { motion_.rest(); }

    /// These pieces have moved since `before`, of which what is kept is; see ReuseMotion::take.
    bool takeMotion(const GpuScene& scene, const core::World& before,
                    const core::Bvh& hierarchyBefore, std::span<const shared::MovedPiece> pieces);

    /// Makes room for a picture of that size and so many tiles, and takes settings; what is kept is
    /// lost when there are to be more or fewer records, and stays when the size changes; a strategy
    /// without samples, or without remainders, has no memory for them. Fewer records than asked for
    /// are kept where a buffer of the device cannot hold them. `raysOfPath`: at most. `chains`:
    /// there are surfaces without a density. `perDeviation`: see shared::allocatedPart.
    void prepare(glm::uvec2 size, uint32_t tiles, const shared::ReuseSettings& settings,
                 uint32_t raysOfPath, float perDeviation, bool chains);

    /// What the settings have become.
    const shared::ReuseSettings& settings() const { return settings_; }

    /// The set of the kernel that adds to the film, for a pass that begins now.
    TwoSets& filmSets() { return oldSets_; }

    /// Whether compile() would have nothing to do with these settings, or those that it has, which
    /// may be of fewer records than were asked for.
    bool isCompiled(const ReuseConstants& constants, const shared::ReuseSettings& settings) const
    {
        return hasKernels(constants, settings) || hasKernels(constants, settings_);
    }

    /// Compiles what has not been compiled. Returns whether anything was.
    bool compile(const GpuScene& scene, const Frame& frame, const ReuseConstants& constants);

    /// Runs all kernels over the tiles of a batch, with kReuse flags; returns the seconds that the
    /// device was busy.
    double run(const GpuScene& scene, const Frame& frame, const ReuseConstants& constants,
               const shared::Batch& batch, uint32_t flags);

    /// The pass is whole: its store is the one to read from now on.
    void commit(const shared::CameraData& camera);

    /// Maps of the last whole pass, as core::reuseMaps() lists them; `size` is that of its picture.
    std::vector<core::Image> maps(glm::uvec2 size) const;

    /// Lanes of the largest batch.
    uint32_t mostLanes() const { return lanes_; }

private:
    /// What one frame leaves to the next.
    struct Store {
        Buffer pixels, places, arriving, lights, means, remainders;
        glm::uvec2 size{0};  // of the picture that it was last made for
    };
    using ReuseKernel = Kernel<shared::ReuseBatch, ReuseConstants>;
    using BounceKernel = Kernel<shared::ReuseBounceBatch, ReuseConstants>;

    /// A kernel that scenes in which connections lie through panes have in a form of their own.
    /// Both forms have the same bindings.
    template <class OneKernel> struct TwoForms {
        OneKernel plain, panes;

        OneKernel& of(const ReuseConstants& constants)
        {
            return (constants.features & shared::kFeaturePanes) != 0 ? panes : plain;
        }
        const OneKernel& of(const ReuseConstants& constants) const
        {
            return (constants.features & shared::kFeaturePanes) != 0 ? panes : plain;
        }
    };

    void makeStore(uint32_t side);
    void bindStore(uint32_t side);
    void makeScratch(uint32_t tiles, uint32_t rays, bool chains);
    void bindScratch();
    void makePipelines(const ReuseConstants& constants);
    bool hasKernels(const ReuseConstants& constants, const shared::ReuseSettings& settings) const;
    bool takesAll() const { return settings_.strategy == shared::kReuseFull; }
    void record(VkCommandBuffer commands, const GpuScene& scene, const Frame& frame,
                const ReuseConstants& constants, const shared::ReuseBatch& push, uint32_t groups);
    void recordNewPaths(VkCommandBuffer commands, const GpuScene& scene, const Frame& frame,
                        const ReuseConstants& constants, const shared::ReuseBatch& push);

    Context& context_;
    ReuseKernel hits_, weigh_;
    TwoForms<ReuseKernel> new_, full_, old_;
    TwoForms<BounceKernel> bounce_;
    // By which store is written.
    TwoSets hitsSets_, newSets_, weighSets_, fullSets_, oldSets_;
    TwoSets bounceSets_;  // by which paths are read
    std::array<Store, 2> stores_;
    ReuseMotion motion_;
    Buffer newSamples_, waiting_, waitingHead_, firstNew_, chains_;
    Buffer trails_, gathered_, queues_;  // of new paths; `full` has none
    std::array<Buffer, 2> paths_;        // under way
    shared::ReuseSettings settings_{};
    float perDeviation_ = 0;
    shared::CameraData camera_{};        // of what is kept; all zero: nothing is
    glm::uvec2 size_{0};                 // of the present picture
    uint32_t lanes_ = 0, mostRays_ = 0;  // that the scratch is for: paths per lane
    bool hasTrails_ = false;             // and whether it has room for what `full` has none of
    uint32_t side_ = 0;                  // of the store that is written
};

}  // namespace gpu
