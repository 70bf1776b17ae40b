// Points of the curve of error over time, and the list of them that a picture carries.
#pragma once

#include <cstdint>
#include <vector>

#include "app/pictures/picture.h"

namespace app {

/// Sums of squared errors over tiles of so many pixels squared count as independent draws.
inline constexpr uint32_t kErrorTile = 8;

/// An error and its standard error.
struct ErrorEstimate {
    double rmse = 0, rmseSe = 0;
};

/// RMSE as core::imageErrors defines it. Its standard error comes from the spread of the squared
/// error between tiles of 8x8 pixels, taken as independent draws: se(MSE)^2 = T/(T-1) sum w_t^2
/// (MSE_t - MSE)^2 with w_t the tile's share of the pixels, and se(RMSE) = se(MSE) / (2 RMSE).
/// Tiles differ by what they show, too, so it errs towards too large. Pixels that are not finite
/// are left out. Sizes are equal (CHECK).
ErrorEstimate errorAgainst(const core::Image& image, const core::Image& reference);

/// The point that an estimate with its variance stands at. `reference` may be null, or of another
/// size: then without rmse.
ErrorPoint errorPoint(const core::Estimate& estimate, double seconds, const Reference* reference);

/// Keeps a curve below a few hundred points: when it is full, every other point but the last goes.
void addPoint(std::vector<ErrorPoint>& curve, const ErrorPoint& point);

}  // namespace app
