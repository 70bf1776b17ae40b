// Two renders of one scene against each other: Welch's test on tiles (Jung, Hanika, Dachsbacher,
// "Detecting Bias in Monte Carlo Renderers using Welch's t-test", 2020) and on the image mean, from
// the films' own sample variances.
#pragma once

#include <string>

#include "core/image/film.h"

namespace tests {

struct FilmComparison {
    double meanA = 0, meanB = 0;  // of the image, over channels
    double imageZ = 0;            // largest over the channels
    double detectable = 0;        // relative bias of the image mean seen with 99 % power
    double largestTileZ = 0;
    size_t tiles = 0;     // tests made: tiles times channels, those without any variance left out
    double uniformP = 1;  // Kolmogorov-Smirnov of the green tiles' p-values
    size_t exactMismatches = 0;  // tiles without variance whose means differ by over 1e-4 relative

    /// Every criterion at the level of the suite; the tiles' limit is corrected for their number
    /// (Sidak).
    bool agree() const;
    std::string describe() const;
};

/// Both films must hold independent samples (the independent sampler), at least 64 per pixel, from
/// different seeds.
FilmComparison compareFilms(const core::Estimate& a, const core::Estimate& b, uint32_t tile = 8);

}  // namespace tests
