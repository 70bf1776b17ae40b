// The visibility of a slice by prediction: some rows of each column are traced, the others
// predicted in several ways, more rows traced to see which way errs least, and columns in which it
// errs too often go on (Y. Huo et al., "A Matrix Sampling-and-Recovery Approach for Many-Lights
// Rendering", 2015). Biased: what has not been traced is a guess.
#pragma once

#include <stop_token>

#include "core/completion/completion.h"
#include "core/completion/visibility_predictors.h"

namespace core::many_lights {

struct PredictionSettings {
    double rate = 0.05;   // rows of a column that a round traces, of those that matter
    double error = 0.02;  // which part of predictions may be wrong
    uint32_t rounds = 10;
};

/// Where receivers and lights are, in scene units; lights infinitely far away stand far off in
/// their direction.
struct SlicePlaces {
    std::span<const glm::vec3> rows, columns;
};

/// Traces and predicts the bits between all rows and columns; fills `visible` and `stats` of `out`,
/// where a column counts as matched when a prediction was good enough, and as repaired when none
/// was after the last round. False when `stop` came in between. A function of the oracle's answers,
/// the places, the settings and the seed alone.
bool predictVisibility(VisibilityOracle& oracle, const SlicePlaces& places,
                       const PredictionSettings& settings, uint64_t seed,
                       const std::stop_token& stop, CompletedSlice& out);

}  // namespace core::many_lights
