// How far pictures are from a reference that has noise of its own: errors without that noise, over
// several pictures of independent seeds, with what is not known of them.
#pragma once

#include <vector>

#include "core/image/image.h"

namespace app::flight {

/// A number and its standard error.
struct Measured {
    double value = 0, error = 0;
};

/// Means over all pixels and channels and over the pictures, defined as in core/image/metrics.h; of
/// `mse` and `relMse` what the reference's own variance adds is taken off.
struct PictureErrors {
    Measured mse, relMse;
    Measured signedError;  // its error: between the pictures, in tiles, and of the reference
    double variance = 0;   // between the pictures
    uint32_t pictures = 0;
};

/// What the noise of a reference adds to the relMSE of a picture.
double noiseOf(const core::Image& reference, const core::Image& variance);

class ErrorSum {
public:
    /// The images live on. `variance`: of the reference's mean.
    ErrorSum(const core::Image& reference, const core::Image& variance);

    /// Another picture of the reference's size, with a seed that no other has.
    void add(const core::Image& picture);

    uint32_t pictures() const { return static_cast<uint32_t>(mse_.size()); }

    /// At least one picture. Standard errors and variance are NaN with less than two.
    PictureErrors errors() const;

private:
    const core::Image& reference_;
    double noise_ = 0, relativeNoise_ = 0;  // of the reference, in mse and relMse
    double signedNoise_ = 0;                // of its mean: variance
    std::vector<double> mse_, relMse_, signed_;
    std::vector<double> sums_, squares_;          // of each value
    std::vector<double> tileSums_, tileSquares_;  // of each tile's sum of differences
};

}  // namespace app::flight
