// Rays to measure with, and Embree's ray functions over them: the reference for the GPU's
// traversal.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "app/gpu/rays.h"
#include "core/scene/camera.h"
#include "core/scene/world.h"

namespace app {

/// Sets of rays through one view: primary in Morton order within 8x8 tiles; from where they hit, a
/// cosine-distributed bounce each; and a shadow ray each to a point of the emitting triangles, of
/// equal chance by triangle, or, in scenes without any, along the cosine distribution to infinity
/// (as to an environment).
struct BenchRays {
    std::vector<gpu::DeviceRay> primary, bounce, shadow;
};

/// Embree over a world, as the reference of measurements: rtcIntersect1, rtcOccluded1 and the
/// packets of sixteen, not robust, spatial splits allowed, alpha ignored. All functions run on all
/// cores.
class EmbreeRays {
public:
    explicit EmbreeRays(std::shared_ptr<const core::World> world);
    ~EmbreeRays();
    EmbreeRays(const EmbreeRays&) = delete;
    EmbreeRays& operator=(const EmbreeRays&) = delete;

    void closest1(std::span<const gpu::DeviceRay> rays, std::span<gpu::DeviceHit> hits) const;
    void closest16(std::span<const gpu::DeviceRay> rays, std::span<gpu::DeviceHit> hits) const;
    void any1(std::span<const gpu::DeviceRay> rays, std::span<gpu::DeviceHit> hits) const;
    void any16(std::span<const gpu::DeviceRay> rays, std::span<gpu::DeviceHit> hits) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Makes the sets; `embree` finds where the primary rays hit. `width`, `height` in pixels.
BenchRays makeBenchRays(const core::World& world, const EmbreeRays& embree,
                        const core::Camera& camera, uint32_t width, uint32_t height);

}  // namespace app
