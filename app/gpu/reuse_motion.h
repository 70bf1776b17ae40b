// What the kernels of sample reuse need to know of a pose that follows on another: the pieces that
// have moved, and where their triangles were (shared/motion.h).
#pragma once

#include <span>

#include "app/gpu/scene.h"
#include "shared/motion.h"

namespace gpu {

class ReuseMotion {
public:
    explicit ReuseMotion(Device& device) : device_(device) {}

    /// From now on nothing has moved.
    void rest() { count_ = 0; }

    /// These pieces have moved since `before`, another pose of the same topology, whose hierarchy
    /// was `hierarchyBefore`; in `sets` they are what the kernels see. False where slots have other
    /// meanings than they had there: then nothing can be kept, and nothing has moved.
    bool take(const GpuScene& scene, const core::World& before, const core::Bvh& hierarchyBefore,
              std::span<const shared::MovedPiece> pieces, std::span<DescriptorSet* const> sets);

    /// How many pieces have moved.
    uint32_t count() const { return count_; }

private:
    Buffer& room(uint32_t binding, Buffer& buffer, uint64_t bytes, VkFormat format,
                 std::span<DescriptorSet* const> sets);

    Device& device_;
    Buffer pieces_, trianglesBefore_, slotsNow_;
    uint32_t count_ = 0;
};

}  // namespace gpu
