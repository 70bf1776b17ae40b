// One slice from its receivers to their radiance: visibility, sum, lost light. The sum is the CPU's
// or, later, that of a device.
#pragma once

#include "core/many_lights/slice_queue.h"

namespace core::many_lights {

/// Works on one slice after the other and keeps its memory: one per thread.
class SliceWorker {
public:
    /// Lights the receivers that `chosen` lists. False when `stop` came in between: then nothing of
    /// the results holds.
    bool run(const SliceJob& job, std::span<const Receiver> receivers,
             std::span<const uint32_t> chosen, uint32_t slice, const std::stop_token& stop);

    /// The same but for the sum, for which `queue` is given the slice in pieces. False also where
    /// the queue gives it up.
    bool run(const SliceJob& job, std::span<const Receiver> receivers,
             std::span<const uint32_t> chosen, uint32_t slice, const std::stop_token& stop,
             SliceQueue& queue);

    /// Of the last run without a queue: radiance that each of them sends to where it is seen from,
    /// and what it took.
    std::span<const glm::vec3> radiance() const { return radiance_; }
    const SliceStats& stats() const { return stats_; }

private:
    bool sum(const SliceJob& job, const std::stop_token& stop);
    void addVisible(const SliceJob& job, const Column& column, std::span<const uint64_t> visible);
    bool sumExtended(const SliceJob& job, std::span<const Receiver> receivers,
                     std::span<const uint32_t> chosen, const std::stop_token& stop);
    void addLost(const SliceJob& job, std::span<const Receiver> receivers,
                 std::span<const uint32_t> chosen);

    SliceVisibility visibility_;
    std::vector<float> weights_;
    std::vector<std::pair<uint32_t, float>> corrections_;  // of the weights of one column
    std::vector<ResidualEntry> residual_;                  // by column
    std::vector<glm::vec3> radiance_;
    SliceStats stats_;
};

}  // namespace core::many_lights
