// What guided kernels see beside what all path kernels do (shared/bindings.h): the guide, what
// roulette takes for pixels' values, and the records that come back to the host.
#pragma once

#include <span>
#include <vector>

#include "app/gpu/path_batches.h"
#include "core/guiding/guide.h"

namespace gpu {

class GuidedBuffers {
public:
    /// Recorded paths of a batch, at most; a batch has this many lanes times the stride.
    static constexpr uint32_t kMostRecorded = 1u << 16;

    explicit GuidedBuffers(Context& context) : context_(context) {}

    /// Makes room for pictures of that frame, and shows everything to the kernels; nothing is known
    /// of the pixels.
    void makeRoom(const Frame& frame, PathBatches& batches);

    /// From now on paths are sampled with these.
    void setGuide(const core::guiding::GuideTables& tables, PathBatches& batches);

    /// Luminance that each pixel is thought to have; empty: nothing is known.
    void setEstimates(std::span<const float> estimates);

    /// Appends what the recorded paths of a batch have left to the `records` of their tiles.
    void collect(const Frame& frame, const shared::Batch& batch,
                 std::span<core::guiding::PathRecords> records);

private:
    void grow(Buffer& buffer, uint32_t binding, const char* name, uint64_t bytes, VkFormat format,
              PathBatches& batches);

    Context& context_;
    Buffer nodes_, leaves_, directions_, estimates_, states_, records_, ends_;
    std::vector<shared::GuideRecord> readRecords_;
    std::vector<shared::GuidePathEnd> readEnds_;
    std::vector<float> zeros_;
};

}  // namespace gpu
