// A World in device memory: BVH, triangles in its order, attributes, materials, texels, emitters.
#pragma once

#include <array>

#include "app/gpu/base/pipeline.h"
#include "core/methods/renderer.h"
#include "core/trace/bvh.h"

namespace gpu {

class GpuScene {
public:
    /// Builds the BVH and uploads; nothing is kept on the host. Buffers that would be empty are not
    /// made.
    GpuScene(Device& device, const core::World& world, const core::Progress& progress);

    /// Points the texel bindings of a set here.
    void bind(Bindings& bindings) const;

    uint32_t features() const { return features_; }
    glm::vec3 gridLow() const { return gridLow_; }
    glm::vec3 gridScale() const { return gridScale_; }
    double buildSeconds() const { return buildSeconds_; }
    uint64_t bytes() const;

private:
    std::array<Buffer, shared::kTexelBindings> buffers_;
    uint32_t features_ = 0;
    glm::vec3 gridLow_{0}, gridScale_{1};
    double buildSeconds_ = 0;
};

}  // namespace gpu
