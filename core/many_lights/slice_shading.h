// One slice from its receivers to their radiance: cut, columns, visibility, sum.
#pragma once

#include "core/many_lights/lost_light.h"
#include "core/many_lights/slice_oracle.h"

namespace core::many_lights {

/// What all slices of a frame have in common.
struct SliceJob {
    ReceiverJob receivers;
    const LightSet* lights = nullptr;
    const LightTree* tree = nullptr;
    GatherSettings gather;
    CompletionParams completion;
    uint32_t clusters = 1000;
    bool compensates = true;  // finds the light that is lost otherwise (lost_light.h)
};

/// What slices took; seconds are those of threads, not of clocks.
struct SliceStats {
    CompletionStats completion;
    uint64_t slices = 0, rows = 0, clusters = 0, otherRays = 0;
    double cutSeconds = 0, orderSeconds = 0, shadingSeconds = 0, lostSeconds = 0;

    SliceStats& operator+=(const SliceStats& other);
};

/// Works on one slice after the other and keeps its memory: one per thread.
class SliceWorker {
public:
    /// Lights the receivers that `chosen` lists. False when `stop` came in between: then nothing of
    /// the results holds.
    bool run(const SliceJob& job, std::span<const Receiver> receivers,
             std::span<const uint32_t> chosen, uint32_t slice, const std::stop_token& stop);

    /// Of the last run: radiance that reaches the camera from each of them, and what it took.
    std::span<const glm::vec3> radiance() const { return radiance_; }
    const SliceStats& stats() const { return stats_; }

private:
    void makeColumns(const SliceJob& job);
    bool weighColumns(const SliceJob& job, const std::stop_token& stop);
    void orderColumns();
    bool sum(const SliceJob& job, const std::stop_token& stop);

    SliceRows rows_;
    CutMemory cutMemory_;
    std::vector<LightCluster> clusters_;
    std::vector<Column> columns_, ordered_;
    std::vector<float> brightness_, weights_;
    std::vector<uint32_t> octants_, order_;
    std::vector<std::pair<uint32_t, float>> corrections_;  // of the weights of one column
    std::vector<ColumnRange> ranges_;
    BitMatrix matters_, orderedMatters_;
    CompletedSlice completed_;
    std::vector<glm::vec3> radiance_;
    SliceStats stats_;
};

}  // namespace core::many_lights
