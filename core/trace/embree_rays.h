// Embree's own ray functions over arrays of rays, the reference for the GPU's traversal in
// `bench throughput` and its tests, and Embree's version. Rendering goes through core::Accel.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "core/scene/world.h"

namespace core {

/// From tMin to tMax along `direction`, in its lengths; tMin is not negative. The kernels read the
/// same bytes.
struct RaySegment {
    glm::vec3 origin{0};
    float tMin = 0;
    glm::vec3 direction{0};
    float tMax = shared::kInfinity;
};
static_assert(sizeof(RaySegment) == 32);

/// Of any-hit rays only `triangle` means something: 1 blocked, 0 not.
struct SegmentHit {
    float t = 0;
    glm::vec2 barycentrics{0};
    uint32_t triangle = shared::kNone;
};
static_assert(sizeof(SegmentHit) == 16);

/// Embree over a world as the reference of measurements: rtcIntersect1, rtcOccluded1 and the
/// packets of sixteen, not robust, spatial splits allowed, alpha ignored. Of flat worlds only. All
/// functions run on all cores.
class EmbreeRays {
public:
    explicit EmbreeRays(std::shared_ptr<const World> world);
    ~EmbreeRays();
    EmbreeRays(const EmbreeRays&) = delete;
    EmbreeRays& operator=(const EmbreeRays&) = delete;

    void closest1(std::span<const RaySegment> rays, std::span<SegmentHit> hits) const;
    void closest16(std::span<const RaySegment> rays, std::span<SegmentHit> hits) const;
    void any1(std::span<const RaySegment> rays, std::span<SegmentHit> hits) const;
    void any16(std::span<const RaySegment> rays, std::span<SegmentHit> hits) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Embree's version: of the headers that were compiled in, and of the library in memory.
struct EmbreeVersion {
    std::string built, running;
};
EmbreeVersion embreeVersion();

}  // namespace core
