// A device that is the CPU: sums slices by the twin of the kernel (core/many_lights/piece_sum.h).
#pragma once

#include "core/many_lights/slice_queue.h"
#include "core/scene/world.h"

namespace tests {

class SliceTwin final : public core::many_lights::BatchSum {
public:
    explicit SliceTwin(const core::World& world, uint64_t batchEntries = 1 << 20)
        : world_(world), entries_(batchEntries)
    {}

    uint64_t batchEntries() const override { return entries_; }
    double sum(std::span<const core::many_lights::SlicePiece> pieces,
               const core::many_lights::SumRules& rules, std::span<glm::vec3> radiance) override;

    size_t batches = 0, pieces = 0;

private:
    const core::World& world_;
    uint64_t entries_;
};

}  // namespace tests
