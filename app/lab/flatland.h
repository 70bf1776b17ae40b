// Flatland: a two-dimensional scene in which stored samples are projected into another camera
// exactly. The ground is y = 0; a sample is a point x of the ground, seen through a position u on
// the image line, and a direction t = sin(angle) drawn from a lobe about the mirror direction. The
// domain is (pixel) x (direction).
#pragma once

#include <functional>
#include <stop_token>
#include <vector>

#include "app/lab/results.h"

namespace app::lab {

struct FlatCamera {
    double x, height;

    /// Image coordinate of the ground point g, and back.
    double project(double g) const { return (g - x) / height; }
    double ground(double u) const { return x + u * height; }
};
inline constexpr FlatCamera kOldCamera{-0.5, 1.0}, kNewCamera{0.0, 0.8};

/// The ground that something thin hides from the old camera.
struct GroundInterval {
    double low, high;
};
inline constexpr GroundInterval kHiddenFromOld{0.10, 0.13};

/// What the projection of old samples takes into account.
struct Projection {
    bool jacobian = true;    // the density of old samples on the new image: du_old / du_new
    bool visibility = true;  // where the old camera saw nothing of the ground there are none
};

struct FlatlandSettings {
    uint32_t N = 8, n = 4, k = 6;  // old samples per old pixel, new ones, candidates for each
    double c = 0.6;                // 0: Discard
    Projection projection;
    Beta beta = Beta::none;
    double betaValue = 1.3;  // for Beta::ideal: the value, as a neighbour would estimate it
    double pixelLow = 0.1, pixelWidth = 0.1;  // the new pixel on its image line
    uint64_t trials = 400000, seed = 1;
};

/// The pixel's value, by quadrature; or what its ground looks like from another camera.
double flatlandTruth(const FlatlandSettings& settings, const FlatCamera& seenFrom = kNewCamera);

/// Mean, variance (of the estimate, not times N) and mean sum of weights over many trials.
FlatlandResult flatland(const FlatlandSettings& settings, std::stop_token stop = {});

/// The right way, its corrections, the two wrong ways, and Discard: what the report shows. Empty
/// when stopped.
std::vector<FlatlandResult> flatlandVariants(uint64_t trials, uint64_t seed,
                                             const std::function<void(double)>& step,
                                             std::stop_token stop);

}  // namespace app::lab
