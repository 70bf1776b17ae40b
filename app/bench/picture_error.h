// How far pictures are from a reference that has noise of its own: errors without that noise, over
// several pictures of independent seeds, with what is not known of them.
#pragma once

#include <vector>

#include "core/image/image.h"

namespace app {

/// A number and its standard error.
struct Measured {
    double value = 0, error = 0;
};

/// a / b with the standard errors of both.
Measured quotient(const Measured& a, const Measured& b);

/// Means over all pixels and channels and over the pictures, defined as in core/image/metrics.h; of
/// `mse` and `relMse` what the reference's own variance adds is taken off. Seeds are few and tiles
/// are many: standard errors come from how much the sums of tiles vary between the pictures, which
/// knows single bright pixels and what the pixels of a tile have in common, but not what tiles
/// have: they are right where errors reach less far than a tile. That of `signedError` has the
/// reference's noise in it, too.
struct PictureErrors {
    Measured mse, relMse, signedError;
    // relMSE without the thousandth of the pixels in which it is largest, without fireflies; its
    // error: between the pictures
    Measured trimmed;
    double variance = 0;  // between the pictures
    uint32_t pictures = 0;
};

/// Mean over pixels and channels.
double pictureMean(const core::Image& image);

/// Mean without that share of the values that is largest, one at least.
double trimmedMean(const std::vector<double>& values, double share);

/// What the noise of a reference adds to the relMSE of a picture.
double noiseOf(const core::Image& reference, const core::Image& variance);

/// Sides of the tiles that are summed, in pixels: of pictures whose pixels are sampled each for
/// itself, and of those of a window of that size.
inline constexpr uint32_t kTileSide = 8;
uint32_t windowTileSide(uint32_t width, uint32_t height);

/// Sums over pictures of a quantity that is a mean over the picture: of each tile's part of it, and
/// of its square.
class TileSums {
public:
    /// Another picture.
    void add(const std::vector<double>& tiles);

    /// The mean over the pictures; its error is NaN with less than two.
    Measured mean() const;

private:
    std::vector<double> sums_, squares_;
    uint32_t pictures_ = 0;
};

/// How much brighter `a` is than `b` on the mean, by tiles, for TileSums: whose mean over some
/// pairs tells chance from bias although the two of a pair may have random numbers in common. Of
/// one size.
std::vector<double> tileDifferences(const core::Image& a, const core::Image& b);

class ErrorSum {
public:
    /// The images live on. `variance`: of the reference's mean.
    ErrorSum(const core::Image& reference, const core::Image& variance,
             uint32_t tileSide = kTileSide);

    /// The same with `level` for what errors are relative to: a reference with fireflies left in
    /// would hide its own.
    ErrorSum(const core::Image& reference, const core::Image& variance, const core::Image& level,
             uint32_t tileSide = kTileSide);

    /// Another picture of the reference's size, with a seed that no other has.
    void add(const core::Image& picture);

    /// At least one picture. Standard errors and variance are NaN with less than two.
    PictureErrors errors() const;

private:
    const core::Image &reference_, &level_;
    uint32_t tileSide_;
    double noise_ = 0, relativeNoise_ = 0;  // of the reference, in mse and relMse
    double signedNoise_ = 0;                // of its mean: variance
    uint32_t pictures_ = 0;
    double trimmed_ = 0, trimmedSquares_ = 0;  // sums
    std::vector<double> sums_, squares_;       // of each value
    std::vector<double> noiseOfPixels_;        // of the reference, relative as errors are
    TileSums mse_, relMse_, signed_;
};

}  // namespace app
