// See flight_error.h. Seeds are few and tiles are many: the standard error of the signed error
// comes from how much the means of tiles vary between seeds, which knows what is common to
// neighbours.
#include "app/bench/flight_error.h"

#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/image/metrics.h"

namespace app::flight {

namespace {

constexpr uint32_t kTile = 8;            // pixels
constexpr double kRelativeFloor = 0.01;  // as core::kRelMseFormula says
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Unbiased variance from sums over `count` values.
double varianceOf(double sum, double squares, double count)
{
    return std::max(0.0, (squares - sum * sum / count) / (count - 1));
}

Measured meanOf(const std::vector<double>& values)
{
    double sum = 0, squares = 0;
    for (const double x : values) sum += x;
    const auto count = static_cast<double>(values.size());
    for (const double x : values) squares += (x - sum / count) * (x - sum / count);
    return {sum / count, count < 2 ? kNaN : std::sqrt(squares / (count - 1) / count)};
}

}  // namespace

double noiseOf(const core::Image& reference, const core::Image& variance)
{
    double sum = 0;
    for (size_t i = 0; i < reference.pixels.size(); ++i) {
        const auto r = static_cast<double>(reference.pixels[i]);
        sum += static_cast<double>(variance.pixels[i]) / (r * r + kRelativeFloor);
    }
    return sum / static_cast<double>(reference.pixels.size());
}

ErrorSum::ErrorSum(const core::Image& reference, const core::Image& variance)
    : reference_(reference), relativeNoise_(noiseOf(reference, variance))
{
    CHECK(variance.pixels.size() == reference.pixels.size() && reference.channels == 3);
    const size_t size = reference.pixels.size();
    sums_.resize(size);
    squares_.resize(size);
    for (size_t i = 0; i < size; i += 3) {
        double deviations = 0;
        for (size_t k = i; k < i + 3; ++k) {
            const auto v = static_cast<double>(variance.pixels[k]);
            noise_ += v;
            deviations += std::sqrt(v);
        }
        signedNoise_ += deviations * deviations;  // channels vary together
    }
    const auto count = static_cast<double>(size);
    noise_ /= count;
    signedNoise_ /= count * count;
    const size_t tiles =
        size_t((reference.width + kTile - 1) / kTile) * ((reference.height + kTile - 1) / kTile);
    tileSums_.resize(tiles);
    tileSquares_.resize(tiles);
}

void ErrorSum::add(const core::Image& picture)
{
    const core::ImageErrors errors = core::imageErrors(picture, reference_);
    mse_.push_back(errors.rmse * errors.rmse - noise_);
    relMse_.push_back(errors.relMse - relativeNoise_);
    signed_.push_back(errors.meanSignedError);
    const uint32_t across = (picture.width + kTile - 1) / kTile;
    std::vector<double> tiles(tileSums_.size());
    for (uint32_t y = 0; y < picture.height; ++y)
        for (uint32_t x = 0; x < picture.width; ++x)
            for (uint32_t c = 0; c < 3; ++c) {
                const size_t i = (size_t(y) * picture.width + x) * 3 + c;
                const double value = static_cast<double>(picture.pixels[i]);
                sums_[i] += value;
                squares_[i] += value * value;
                tiles[size_t(y / kTile) * across + x / kTile] +=
                    value - static_cast<double>(reference_.pixels[i]);
            }
    for (size_t t = 0; t < tiles.size(); ++t) {
        tileSums_[t] += tiles[t];
        tileSquares_[t] += tiles[t] * tiles[t];
    }
}

PictureErrors ErrorSum::errors() const
{
    CHECK(!mse_.empty());
    PictureErrors e;
    e.pictures = pictures();
    e.mse = meanOf(mse_);
    e.relMse = meanOf(relMse_);
    e.signedError = meanOf(signed_);
    const double count = e.pictures, values = static_cast<double>(sums_.size());
    e.variance = e.pictures < 2 ? kNaN : 0;
    if (e.pictures < 2) return e;
    for (size_t i = 0; i < sums_.size(); ++i)
        e.variance += varianceOf(sums_[i], squares_[i], count) / values;
    double ofMean = signedNoise_;
    for (size_t t = 0; t < tileSums_.size(); ++t)
        ofMean += varianceOf(tileSums_[t], tileSquares_[t], count) / count / (values * values);
    e.signedError.error = std::sqrt(ofMean);
    return e;
}

}  // namespace app::flight
