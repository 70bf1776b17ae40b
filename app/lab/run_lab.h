// Runs every experiment of the laboratory.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>

#include "app/lab/results.h"

namespace app::lab {

inline constexpr uint64_t kUsualTrials = 400000, kQuickTrials = 20000;
// Augmentation draws (a - 1) N new samples whatever it may spend. Where a is above this bound, one
// trial in so many is made.
inline constexpr uint32_t kMuchAugmentation = 8, kThinning = 16;

struct LabSettings {
    // Per cell of the table, but where augmentation is thinned; the other experiments scale with
    // it.
    uint64_t trials = kUsualTrials;
    uint64_t seed = 1;
    bool quick = false;  // only labels the report
};

/// `progress(stage, fraction)` is called from any thread, one call at a time. Nothing when `stop`
/// was requested before the end. The same settings give the same numbers on any number of threads.
std::optional<LabResults>
runLab(const LabSettings& settings,
       const std::function<void(const char* stage, double fraction)>& progress,
       std::stop_token stop = {});

}  // namespace app::lab
