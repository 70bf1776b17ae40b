// How many paths the next batch gets, so that no submission holds the device for longer than asked
// (V3): from the time that batches took, with the slowest of late counting most. Nothing of Vulkan
// in it.
#pragma once

#include <cstdint>

namespace gpu {

class BatchPace {
public:
    static constexpr uint32_t kGroup = 64;    // lanes come in whole groups
    static constexpr uint32_t kFirst = 1024;  // lanes of a batch of which nothing is known
    static constexpr double kLongest = 0.1;   // seconds that are never aimed above
    static constexpr uint32_t kGrowth = 4;    // from the largest batch to the next, at most

    /// Another scene or other kernels: nothing is known.
    void restart() { *this = {}; }

    /// Another view of the same: the next batch is small, a quarter of the largest so far, but the
    /// speed so far is a good guess.
    void again() { largest_ = largest_ / (kGrowth * kGrowth); }

    /// Lanes that should take `seconds`; whole groups, between one group and `most`.
    uint32_t lanes(double seconds, uint32_t most) const;

    /// A batch of so many lanes held the device for `seconds`.
    void measured(uint32_t lanes, double seconds);

private:
    double secondsPerLane_ = 0;            // 0: unknown
    uint32_t measuredLanes_ = 0;           // of the batch that this rate comes from
    uint32_t largest_ = kFirst / kGrowth;  // of this view, or that it begins as if there were
};

}  // namespace gpu
