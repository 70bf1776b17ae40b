// Numbers that say how far an image is from a reference, and tests that say whether the distance is
// more than noise.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "core/image/image.h"

namespace core {

// How the numbers are defined, to be printed beside them. d = image - reference, r = reference;
// means are over all pixels and the channels R, G, B; pixels that are not finite in either image
// are left out and counted.
inline constexpr const char* kRmseFormula = "sqrt(mean(d^2))";
inline constexpr const char* kRelMseFormula = "mean(d^2 / (r^2 + 0.01))";
inline constexpr double kRelMseFloor = 0.01;  // of it
inline constexpr const char* kMeanSignedErrorFormula = "mean(d)";

struct ImageErrors {
    double rmse = 0, relMse = 0, meanSignedError = 0;
    glm::dvec3 meanImage{0}, meanReference{0};
    uint64_t nonFinitePixels = 0;
};

/// Sizes are equal (CHECK), at least three channels. Double precision; the same for any number of
/// threads.
ImageErrors imageErrors(const Image& image, const Image& reference);

/// A mean image with the variance of that mean and the number of samples behind each pixel (0:
/// unknown, many).
struct MeanAndVariance {
    const Image& mean;
    const Image& variance;
    uint64_t samples = 0;
};

/// A difference in units of its standard deviation. `z` is Welch's t, carried over to the normal
/// distribution of equal probability (Wallace 1959); +-kCertain where the images differ and neither
/// varies.
struct WelchScore {
    double z = 0, p = 1;
    double degreesOfFreedom = 0;
};
inline constexpr double kCertain = 1e9;

struct WelchTile {
    uint32_t x = 0, y = 0;  // of the first pixel
    std::array<WelchScore, 3> channels;
};

/// Welch's test of two estimates of the same image: Jung, Hanika, Dachsbacher, "Detecting Bias in
/// Monte Carlo Renderers using Welch's t-test", 2020.
struct WelchResult {
    std::array<WelchScore, 3> image;  // of the image means, per channel
    // Relative bias of the image mean seen with 99 % power at |z| = 4.21
    std::array<double, 3> detectableBias;
    std::vector<WelchTile> tiles;  // those with any variance or any difference
    double largestTileZ = 0;       // of the largest magnitude, with its sign
    double smallestP = 1;          // over tiles and channels, corrected for their number (Sidak)
    std::array<uint32_t, 20> histogram{};  // of the tiles' p-values in green, which are independent
                                           // and uniform when nothing but noise differs
    double uniformP = 1;  // Kolmogorov-Smirnov of these against the uniform distribution
};

/// `tile` is the side of a tile in pixels. Sizes are equal (CHECK), at least three channels. Pixels
/// that are not finite are left out.
WelchResult welchTest(const MeanAndVariance& a, const MeanAndVariance& b, uint32_t tile = 8);

/// Samples per pixel below which their own spread says too little about the error.
inline constexpr uint64_t kFewestForNoise = 8;

/// The RMSE to expect of a picture whose mean has this variance: the root of its mean over pixels
/// and channels, those left out that are not finite. 0 for an empty image.
double noiseOf(const Image& variance);

/// Probability that a standard normal variable is at least |z| away from zero.
double twoSidedP(double z);

/// Probability that `values` would lie as far from uniform on [0, 1] if they were (Kolmogorov;
/// Stephens' correction for their number, 1970); 1 for an empty list.
double kolmogorovUniformP(std::vector<double> values);

}  // namespace core
