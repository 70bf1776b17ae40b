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
    void makeRoom(uint64_t bytes);
    void compile(const GpuScene& scene, const Frame& frame);
    void trace(const GpuScene& scene, const Frame& frame, uint32_t endTile, shared::TileRange tiles,
               double seconds);

    Context& context_;
    Kernel<shared::TileRange, FeatureConstants> kernel_;
    DescriptorSet set_;
    Buffer found_;
    BatchPace pace_;
};

}  // namespace gpu
