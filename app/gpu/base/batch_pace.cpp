// The rate is that of the slowest late batch, forgotten by a tenth per batch: tiles of sky would
// otherwise make batches that are too long for the hair behind them. A batch that was much smaller
// says little about a larger one, as the fixed cost of a submission is most of its time.
#include "app/gpu/base/batch_pace.h"

#include <algorithm>

namespace gpu {

uint32_t BatchPace::lanes(double seconds, uint32_t most) const
{
    double wanted = kGrowth * double(largest_);
    if (secondsPerLane_ > 0)
        wanted = std::min(wanted, std::min(seconds, kLongest) / secondsPerLane_);
    const auto groups = static_cast<uint32_t>(std::min(wanted, double(most)) / kGroup);
    return std::max(groups, 1u) * kGroup;
}

void BatchPace::measured(uint32_t lanes, double seconds)
{
    constexpr double kForgets = 0.9;
    if (lanes == 0) return;
    const double rate = std::max(seconds, 1e-7) / lanes;
    if (lanes >= 2 * measuredLanes_ || rate >= secondsPerLane_) {
        secondsPerLane_ = rate;
        measuredLanes_ = lanes;
    } else {
        secondsPerLane_ = std::max(rate, kForgets * secondsPerLane_);
        measuredLanes_ = std::max(measuredLanes_, lanes);
    }
    // What is left of a picture may be little: it does not make the next batch small.
    largest_ = std::max({largest_, lanes, kGroup});
}

}  // namespace gpu
