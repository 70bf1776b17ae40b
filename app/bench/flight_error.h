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

/// a / b with the standard errors of both.
Measured quotient(const Measured& a, const Measured& b);

/// Means over all pixels and channels and over the pictures, defined as in core/image/metrics.h; of
/// `mse` and `relMse` what the reference's own variance adds is taken off. Seeds are few and tiles
/// are many: standard errors come from how much the sums of tiles vary between the pictures, which
/// knows what neighbours have in common and single bright pixels; that of `signedError` has the
/// reference's noise in it, too.
struct PictureErrors {
    Measured mse, relMse, signedError;
    // relMSE without the thousandth of the pixels in which it is largest, without fireflies; its
    // error: between the pictures
    Measured trimmed;
    double variance = 0;  // between the pictures
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

    /// At least one picture. Standard errors and variance are NaN with less than two.
    PictureErrors errors() const;

private:
    /// Sums over pictures of a quantity that is a mean over the picture: of each tile's part of it,
    /// and of its square.
    struct Tiled {
        std::vector<double> sums, squares;

        void add(const std::vector<double>& tiles);
        Measured mean(double pictures) const;
    };

    const core::Image& reference_;
    double noise_ = 0, relativeNoise_ = 0;  // of the reference, in mse and relMse
    double signedNoise_ = 0;                // of its mean: variance
    uint32_t pictures_ = 0;
    double trimmed_ = 0, trimmedSquares_ = 0;  // sums
    std::vector<double> sums_, squares_;       // of each value
    Tiled mse_, relMse_, signed_;
};

}  // namespace app::flight
