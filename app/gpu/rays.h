// Arrays of rays through the traversal kernel alone: what is measured by `bench throughput` and
// tested against Embree.
#pragma once

#include <span>
#include <vector>

#include "app/gpu/frame.h"
#include "app/gpu/scene.h"
#include "core/trace/embree_rays.h"

namespace gpu {

using DeviceRay = core::RaySegment;  // as the kernels read it
using DeviceHit = core::SegmentHit;  // as they write it

class GpuRays {
public:
    /// Builds and uploads the scene. Kernels test alpha only when `alpha` says so and the scene
    /// needs it.
    GpuRays(Device& device, const core::World& world, bool alpha);

    /// Takes other rays. Throws core::Error when they do not fit.
    void setRays(std::span<const DeviceRay> rays);

    /// Traces all rays once; returns the seconds that the device was busy.
    double traceClosest() { return trace(closest_, closestSet_); }
    double traceAny() { return trace(any_, anySet_); }

    /// What the last trace found, one per ray.
    std::vector<DeviceHit> hits() const;

private:
    using RayKernel = Kernel<shared::ItemRange, FeatureConstants>;
    double trace(RayKernel& kernel, const DescriptorSet& set);

    Device& device_;
    SharedLayouts layouts_;
    GpuScene scene_;
    Frame frame_;
    RayKernel closest_, any_;
    DescriptorSet closestSet_, anySet_;
    FeatureConstants constants_;
    Buffer rays_, hits_;
    uint32_t count_ = 0;
};

}  // namespace gpu
