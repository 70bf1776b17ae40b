// Reuse from frame to frame: a Cauchy lobe oscillates, as the mirror direction does at a point of a
// glossy surface that a camera circles, and each frame reuses the samples of those before.
#pragma once

#include <functional>
#include <stop_token>
#include <vector>

#include "app/lab/results.h"
#include "core/reuse/history.h"

namespace app::lab {

/// How history is treated from frame to frame.
enum class LobeMethod {
    reweightingAugmentation,  // absolute weights, R-A
    balanceHeuristic,         // absolute weights, MIS
    equalWeights,  // the obvious way: what is kept counts as exact samples of the last density
    accumulation,  // old pixel values averaged with the new one
};

struct LobeSettings {
    LobeMethod method = LobeMethod::reweightingAugmentation;
    double step = 0.01;  // the lobe's speed at the centre, per frame
    uint32_t n = 4, K = 32, k = 8;
    double cap = 0;         // of the nominal count N; 0: K
    double brightness = 0;  // eta: the score of a sample is u (p + eta f / I)
    uint32_t frames = 40;
    core::reuse::Resampling resampling = core::reuse::Resampling::threshold;
    uint64_t trials = 20000, seed = 1;
};

/// The integrand at frame t is p_t (1 + .8 sin 14 x), with p_t of width .08 about .5 + .2 sin(5
/// step t). Empty frames when stopped.
LobeSequence movingLobe(const LobeSettings& settings, std::stop_token stop = {});

}  // namespace app::lab
