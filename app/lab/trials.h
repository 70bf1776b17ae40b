// Many independent trials of several estimators on one change of density: what the table and the
// sweeps are made of.
#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "app/lab/lab_change.h"
#include "app/lab/results.h"

namespace app::lab {

/// Independent random streams of one run within one block of trials.
struct Streams {
    core::Pcg32 candidates, selection;
};

/// One estimator with its settings. `cell` holds what is known of it before the trials (method, N,
/// n, k, c).
struct Run {
    using Estimate = core::reuse::EstimateOf<LabChange>;

    Cell cell;
    std::vector<Beta> betas{Beta::none};
    std::function<Estimate(const LabChange&, std::span<const LabPoint>, Streams&)> estimate;
    uint32_t thinning = 1;  // only every `thinning`-th trial is made: for costly runs
};

struct TrialSettings {
    uint64_t trials = 0, seed = 1;
    size_t oldSamples = 8;
    uint32_t experiment = 0;  // different ones have different random numbers
};

/// Makes the trials on all threads. Every run sees the same old samples and its own new ones.
/// Returns a cell per run, beta and function, in this order; nothing when stopped. `step(fraction)`
/// reports progress.
std::vector<Cell> runTrials(const Pair& pair, const std::vector<Run>& runs,
                            const TrialSettings& settings, const std::function<void(double)>& step,
                            std::stop_token stop);

}  // namespace app::lab
