// See flight_error.h.
#include "app/bench/flight_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"

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

/// Mean without the thousandth of the values that is largest, one at least.
double trimmedMean(std::vector<double>& values)
{
    const size_t kept = values.size() - std::max<size_t>(1, values.size() / 1000);
    const auto end = values.begin() + static_cast<ptrdiff_t>(kept);
    std::nth_element(values.begin(), end, values.end());
    double sum = 0;
    for (auto x = values.begin(); x != end; ++x) sum += *x;
    return sum / static_cast<double>(std::max<size_t>(1, kept));
}

}  // namespace

Measured quotient(const Measured& a, const Measured& b)
{
    const double value = a.value / b.value;
    return {value, std::abs(value) * std::hypot(a.error / a.value, b.error / b.value)};
}

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
}

void ErrorSum::Tiled::add(const std::vector<double>& tiles)
{
    sums.resize(tiles.size());
    squares.resize(tiles.size());
    for (size_t t = 0; t < tiles.size(); ++t) {
        sums[t] += tiles[t];
        squares[t] += tiles[t] * tiles[t];
    }
}

Measured ErrorSum::Tiled::mean(double pictures) const
{
    Measured m{0, pictures < 2 ? kNaN : 0};
    for (size_t t = 0; t < sums.size(); ++t) {
        m.value += sums[t] / pictures;
        if (pictures > 1) m.error += varianceOf(sums[t], squares[t], pictures) / pictures;
    }
    m.error = std::sqrt(m.error);
    return m;
}

void ErrorSum::add(const core::Image& picture)
{
    CHECK(picture.width == reference_.width && picture.height == reference_.height &&
          picture.channels == 3);
    const uint32_t across = (picture.width + kTile - 1) / kTile,
                   down = (picture.height + kTile - 1) / kTile;
    std::vector<double> mse(size_t(across) * down), relMse(mse), differences(mse), ofPixels;
    ofPixels.reserve(size_t(picture.width) * picture.height);
    const double part = 1 / static_cast<double>(sums_.size());
    for (uint32_t y = 0; y < picture.height; ++y)
        for (uint32_t x = 0; x < picture.width; ++x) {
            const size_t tile = size_t(y / kTile) * across + x / kTile;
            double ofPixel = 0;
            for (uint32_t c = 0; c < 3; ++c) {
                const size_t i = (size_t(y) * picture.width + x) * 3 + c;
                const auto value = static_cast<double>(picture.pixels[i]),
                           r = static_cast<double>(reference_.pixels[i]);
                const double d = value - r;
                sums_[i] += value;
                squares_[i] += value * value;
                differences[tile] += d * part;
                mse[tile] += d * d * part;
                ofPixel += d * d / (r * r + kRelativeFloor);
            }
            relMse[tile] += ofPixel * part;
            ofPixels.push_back(ofPixel / 3);
        }
    ++pictures_;
    const double trimmed = trimmedMean(ofPixels);
    trimmed_ += trimmed;
    trimmedSquares_ += trimmed * trimmed;
    mse_.add(mse);
    relMse_.add(relMse);
    signed_.add(differences);
}

PictureErrors ErrorSum::errors() const
{
    CHECK(pictures_ > 0);
    const double count = pictures_, values = static_cast<double>(sums_.size());
    PictureErrors e;
    e.pictures = pictures_;
    e.mse = mse_.mean(count);
    e.mse.value -= noise_;
    e.relMse = relMse_.mean(count);
    e.relMse.value -= relativeNoise_;
    e.signedError = signed_.mean(count);
    e.signedError.error = std::hypot(e.signedError.error, std::sqrt(signedNoise_));
    e.trimmed = {trimmed_ / count - relativeNoise_,
                 pictures_ < 2 ? kNaN
                               : std::sqrt(varianceOf(trimmed_, trimmedSquares_, count) / count)};
    e.variance = pictures_ < 2 ? kNaN : 0;
    for (size_t i = 0; pictures_ > 1 && i < sums_.size(); ++i)
        e.variance += varianceOf(sums_[i], squares_[i], count) / values;
    return e;
}

}  // namespace app::flight
