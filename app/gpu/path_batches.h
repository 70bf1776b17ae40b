// Batches of paths on the device, by one of two kernels: one launch per bounce with the surviving
// paths closed up in between (Laine, Karras, Aila, "Megakernels Considered Harmful", 2013, with the
// stages fused), or one launch for whole paths. Both run the same text in the same order per path
// and give the same image. Which is faster is measured; how large a batch may be follows from the
// time that the last ones took (batch_pace.h).
#pragma once

#include <array>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <tuple>

#include "app/gpu/base/batch_pace.h"
#include "app/gpu/context.h"
#include "app/gpu/frame.h"
#include "app/gpu/scene.h"
#include "core/methods/path_params.h"

namespace gpu {

/// What path kernels are specialised on.
struct PathConstants {
    static constexpr uint32_t kFirst = 0;
    uint32_t features = 0xffffffffu;  // number 0: lang.h
    uint32_t sampler = 0;             // shared::kSpecializeSampler
    uint32_t guided = 0;              // shared::kSpecializeGuided
    uint32_t nee = 0;                 // shared::kSpecializeNee
    friend auto operator<=>(const PathConstants&, const PathConstants&) = default;
};

/// The view whose paths are traced; scene and frame are borrowed.
struct PathWork {
    const GpuScene* scene = nullptr;
    Frame* frame = nullptr;
    PathConstants constants;
    core::Strategy strategy = core::Strategy::mis;
    core::Kernel kernel = core::Kernel::automatic;
    size_t triangleCount = 0;  // for messages
    bool whole = false;        // see core::Pace
};

/// SPIR-V of the two kernels, which must outlive them.
struct PathKernels {
    std::span<const uint32_t> bounce, megakernel;
};

class PathBatches {
public:
    /// Records what is done with the radiance of a batch once it is there.
    using Then = std::function<void(VkCommandBuffer, const shared::Batch&)>;

    /// With the kernels of plain paths.
    explicit PathBatches(Context& context);
    PathBatches(Context& context, const PathKernels& kernels);

    /// Shows a buffer to those kernels that know the binding.
    void bind(uint32_t binding, const Buffer& buffer);

    /// Another scene: nothing is known of its speed.
    void forgetScene();

    /// Makes room for the paths of an image of that size. radiance() may be another buffer then.
    void makeRoom(const Frame& frame);

    /// Whether prepare() has compiled one of the kernels for these constants.
    bool isCompiled(const PathConstants& constants) const
    {
        return bounce_.isCompiled(constants) || megakernel_.isCompiled(constants);
    }

    /// Takes a view for which there is room: compiles the kernel that it begins with, together with
    /// what `then` records. Returns the seconds that compiling took.
    double prepare(const PathWork& work, const Then& then);

    /// Goes on with kernels of other constants, which give the same radiance.
    void exchange(const PathConstants& constants);

    /// The same once they are compiled, which happens beside what is traced, after enough of that
    /// for it to pay.
    void exchangeWhenCompiled(const PathConstants& constants);

    /// What the kernels are specialised on.
    const PathConstants& constants() const { return work_.constants; }

    /// Measures which kernel is the faster one, if that is open and enough has been traced of this
    /// view for it to pay; `lanes` is what a batch may have. The second kernel is compiled beside
    /// what is traced until then.
    void chooseKernel(uint32_t lanes);

    /// Lanes that a batch may have to take `seconds`.
    uint32_t lanes(double seconds) const;

    /// Traces a batch, then does what `then` records. Returns when all is done.
    void trace(const shared::Batch& batch, const Then& then);

    /// "wavefront" or "megakernel"; empty without a view.
    const char* kernelName() const
    {
        return choice_ == nullptr ? "" : wavefront_ ? "wavefront" : "megakernel";
    }

    /// A vec4 per lane.
    const Buffer& radiance() const { return radiance_; }
    /// The most lanes that a batch may have.
    uint32_t mostLanes() const { return uint32_t(radiance_.bytes() / sizeof(glm::vec4)); }

private:
    /// Which kernel is faster, for one scene and one kind of work.
    struct Choice {
        uint64_t lanes = 0;  // traced in this view
        double seconds = 0;  // that they took
        bool made = false, wavefront = true;
        bool cut = false;  // the device does not follow whole paths to their ends
    };
    /// What the choice depends on: constants, depth, strategy, and whether the image is small.
    using WorkKind = std::tuple<PathConstants, uint32_t, core::Strategy, bool>;

    /// What says how many rays a path takes.
    struct Length {
        uint32_t maxDepth = 0, rouletteDepth = 0;
        core::Strategy strategy = core::Strategy::mis;
        bool mayBeMoreThan(const Length& other) const
        {
            return maxDepth > other.maxDepth || rouletteDepth > other.rouletteDepth ||
                   strategy != other.strategy;
        }
    };

    WorkKind kindOfWork() const;
    uint32_t maxDepth() const { return work_.frame->data().settings.maxDepth; }
    KernelSets sets(const DescriptorSet& own) const;
    bool compile(const Then& then);
    bool takeChoice();
    bool isWorth(uint64_t lanes, double seconds, double compilations) const;
    double run(const shared::Batch& batch, const Then& then);
    double runWhole(const shared::Batch& batch, const Then& then);
    double runWatched(const shared::Batch& batch, const Then& then);
    double runBounces(const shared::Batch& batch, const Then& then);
    std::string describe(const char* kernel, const shared::Batch& batch) const;

    Context& context_;
    Kernel<shared::BounceBatch, PathConstants> bounce_;
    Kernel<shared::Batch, PathConstants> megakernel_;
    // They differ in which buffer of paths is read and which is written
    std::array<DescriptorSet, 2> bounceSets_;
    DescriptorSet megakernelSet_;
    std::array<Buffer, 2> states_;
    Buffer radiance_, queues_;
    PathWork work_;
    BatchPace pace_;
    Length length_;                       // of the paths that it knows
    std::map<WorkKind, Choice> choices_;  // for the present scene
    Choice* choice_ = nullptr;
    bool wavefront_ = true;
    double compileSeconds_ = 0;  // of the last kernel that was waited for
    bool waits_ = false;         // for kernels of other constants
    uint64_t waitedLanes_ = 0;   // that were traced meanwhile, in all views
    double waitedSeconds_ = 0;   // that they took
};

}  // namespace gpu
