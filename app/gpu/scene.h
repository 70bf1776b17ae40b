// A World in device memory: BVH, triangles in its order, attributes, materials, texels, emitters.
#pragma once

#include <array>

#include "app/gpu/base/descriptors.h"
#include "core/methods/renderer.h"
#include "core/trace/bvh.h"
#include "shared/bindings.h"

namespace gpu {

class GpuScene {
public:
    /// Builds the BVH and uploads; nothing is kept on the host. Buffers that would be empty are not
    /// made.
    GpuScene(Device& device, const SharedLayouts& layouts, const core::World& world,
             const core::Progress& progress);

    /// Set 0 of the kernels that look at the scene.
    const DescriptorSet& set() const { return set_; }

    uint32_t features() const { return features_; }
    glm::vec3 gridLow() const { return gridLow_; }
    glm::vec3 gridScale() const { return gridScale_; }
    double buildSeconds() const { return buildSeconds_; }
    uint64_t bytes() const;

private:
    std::array<Buffer, shared::kSceneBindings> buffers_;
    DescriptorSet set_;
    uint32_t features_ = 0;
    glm::vec3 gridLow_{0}, gridScale_{1};
    double buildSeconds_ = 0;
};

}  // namespace gpu
