// Takes samples until a limit is reached: a number of them, a time, an error against a reference, a
// budget, or a stop request.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>

#include "core/image/film.h"
#include "core/image/image.h"
#include "core/methods/renderer.h"

namespace app {

inline constexpr uint64_t kMaxSpp = 2147483647;  // so many are no limit

/// Where to stop; whatever comes first. `spp` is at least one.
struct Goal {
    uint64_t spp = 64;
    double seconds = 0;  // of rendering, 0 = no limit; at least one sample is taken
    const core::Image* reference = nullptr;
    double rmse = 0;   // against `reference`, over all pixels and channels; 0 = not a goal
    double noise = 0;  // the RMSE that the spread of the samples leads to expect; 0 = not a goal
    // What is to be spent and no more: a sample that would probably run past it is not begun, but
    // for the first. 0 = no limit.
    double budgetSeconds = 0, budgetRays = 0;
};

enum class Ended { spp, time, target, stopped, budget };

struct Outcome {
    Ended ended = Ended::spp;
    uint64_t samples = 0;
    double seconds = 0;                 // in the renderer, without the time of error measurements
    std::optional<double> rmse, noise;  // the last that were measured
};

/// Called after every step with what has come of it so far.
using LoopProgress = std::function<void(const Outcome&)>;

/// Advances `renderer` from where it stands. Steps grow until one takes about a quarter of a
/// second, so that stopping and progress are prompt; the image does not depend on them. With a
/// target, the error or the noise is measured whenever the samples have grown by a fifth.
Outcome renderUntil(core::Renderer& renderer, const Goal& goal, const std::stop_token& stop,
                    const LoopProgress& progress);

}  // namespace app
