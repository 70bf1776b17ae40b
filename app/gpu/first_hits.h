// First hits at the pixel centres of a view: depth, normals, albedo and ids, without noise.
#pragma once

#include "app/gpu/base/batch_pace.h"
#include "app/gpu/context.h"
#include "app/gpu/frame.h"
#include "app/gpu/scene.h"
#include "core/methods/renderer.h"

namespace gpu {

class FirstHits {
public:
    explicit FirstHits(Context& context);

    /// Another scene: nothing is known of its speed.
    void forgetScene() { pace_.restart(); }

    /// Finds them all, in pieces that hold the device no longer than `seconds`.
    core::Aovs find(const GpuScene& scene, const Frame& frame, core::Sight sight, double seconds);

    /// Compiles the kernel for the scene, which software drivers do for seconds, so that find()
    /// need not.
    void prepare(const GpuScene& scene, const Frame& frame);

private:
    using TileKernel = Kernel<shared::TileRange, FeatureConstants>;

    void makeRoom(uint64_t pixels, uint64_t lanes);
    void compile(TileKernel& kernel, const DescriptorSet& own, const GpuScene& scene,
                 const Frame& frame);
    void compile(const GpuScene& scene, const Frame& frame, bool looksThrough);
    void trace(const GpuScene& scene, const Frame& frame, uint32_t endTile, shared::TileRange tiles,
               double seconds);
    void record(VkCommandBuffer commands, const GpuScene& scene, const Frame& frame,
                const shared::TileRange& tiles);

    Context& context_;
    TileKernel hits_, seen_;
    DescriptorSet hitsSet_, seenSet_;
    Buffer found_;
    Buffer lookingLanes_, lookingHead_;  // what the second kernel looks at again
    BatchPace pace_;
};

}  // namespace gpu
