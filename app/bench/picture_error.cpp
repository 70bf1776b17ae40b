// See picture_error.h.
#include "app/bench/picture_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/image/metrics.h"

namespace app {

namespace {

constexpr double kFireflies = 0.001;  // of the pixels
// A window's light has few pixels: each is six to eight of the window's wide and is spread over
// some of its neighbours. Where errors reach over 32 pixels, tiles of 64 find 5/6 of the standard
// error, those of 8 less than a quarter.
constexpr uint32_t kWindowTileSide = 64;
// With two pictures the standard error is known to 1 / sqrt(2 x tiles) of it, 13 %, where all tiles
// vary alike.
constexpr uint32_t kLeastTiles = 30;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A pixel's squared relative error, and the same without what the reference's noise adds to it.
struct PixelError {
    double error, net;
};

/// How many tiles there are across so many pixels.
uint32_t tilesAcross(uint32_t pixels, uint32_t side)
{
    return (pixels + side - 1) / side;
}

/// Unbiased variance from sums over `count` values.
double varianceOf(double sum, double squares, double count)
{
    return std::max(0.0, (squares - sum * sum / count) / (count - 1));
}

}  // namespace

uint32_t windowTileSide(uint32_t width, uint32_t height)
{
    uint32_t side = kWindowTileSide;
    while (side > kTileSide && tilesAcross(width, side) * tilesAcross(height, side) < kLeastTiles)
        --side;
    return side;
}

double pictureMean(const core::Image& image)
{
    double sum = 0;
    for (const float x : image.pixels) sum += static_cast<double>(x);
    return sum / static_cast<double>(image.pixels.size());
}

/// The mean of `net` over the pixels that are left without the share of the largest `error`.
static double trimmedNet(std::vector<PixelError>& pixels, double share)
{
    const auto dropped = static_cast<size_t>(share * static_cast<double>(pixels.size()));
    const size_t kept = pixels.size() - std::max<size_t>(1, dropped);
    const auto end = pixels.begin() + static_cast<ptrdiff_t>(kept);
    std::nth_element(pixels.begin(), end, pixels.end(),
                     [](const PixelError& a, const PixelError& b) { return a.error < b.error; });
    double sum = 0;
    for (auto pixel = pixels.begin(); pixel != end; ++pixel) sum += pixel->net;
    return sum / static_cast<double>(std::max<size_t>(1, kept));
}

double trimmedMean(const std::vector<double>& values, double share)
{
    std::vector<PixelError> pixels;
    pixels.reserve(values.size());
    for (const double value : values) pixels.push_back({value, value});
    return trimmedNet(pixels, share);
}

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
        sum += static_cast<double>(variance.pixels[i]) / (r * r + core::kRelMseFloor);
    }
    return sum / static_cast<double>(reference.pixels.size());
}

ErrorSum::ErrorSum(const core::Image& reference, const core::Image& variance, uint32_t tileSide)
    : ErrorSum(reference, variance, reference, tileSide)
{}

ErrorSum::ErrorSum(const core::Image& reference, const core::Image& variance,
                   const core::Image& level, uint32_t tileSide)
    : reference_(reference), level_(level), tileSide_(tileSide),
      relativeNoise_(noiseOf(level, variance))
{
    CHECK(variance.pixels.size() == reference.pixels.size() && reference.channels == 3 &&
          level.pixels.size() == reference.pixels.size());
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
    for (size_t i = 0; i < size; i += 3) {
        double noise = 0;
        for (size_t k = i; k < i + 3; ++k) {
            const auto r = static_cast<double>(level.pixels[k]);
            noise += static_cast<double>(variance.pixels[k]) / (r * r + core::kRelMseFloor) / 3;
        }
        noiseOfPixels_.push_back(noise);
    }
    noise_ /= count;
    signedNoise_ /= count * count;
}

void TileSums::add(const std::vector<double>& tiles)
{
    sums_.resize(tiles.size());
    squares_.resize(tiles.size());
    for (size_t t = 0; t < tiles.size(); ++t) {
        sums_[t] += tiles[t];
        squares_[t] += tiles[t] * tiles[t];
    }
    ++pictures_;
}

Measured TileSums::mean() const
{
    const double pictures = pictures_;
    Measured m{0, pictures_ < 2 ? kNaN : 0};
    for (size_t t = 0; t < sums_.size(); ++t) {
        m.value += sums_[t] / pictures;
        if (pictures_ > 1) m.error += varianceOf(sums_[t], squares_[t], pictures) / pictures;
    }
    m.error = std::sqrt(m.error);
    return m;
}

void ErrorSum::add(const core::Image& picture)
{
    CHECK(picture.width == reference_.width && picture.height == reference_.height &&
          picture.channels == 3);
    const uint32_t across = tilesAcross(picture.width, tileSide_),
                   down = tilesAcross(picture.height, tileSide_);
    std::vector<double> mse(size_t(across) * down), relMse(mse), differences(mse);
    std::vector<PixelError> ofPixels;
    ofPixels.reserve(size_t(picture.width) * picture.height);
    const double part = 1 / static_cast<double>(sums_.size());
    for (uint32_t y = 0; y < picture.height; ++y)
        for (uint32_t x = 0; x < picture.width; ++x) {
            const size_t tile = size_t(y / tileSide_) * across + x / tileSide_;
            double ofPixel = 0;
            for (uint32_t c = 0; c < 3; ++c) {
                const size_t i = (size_t(y) * picture.width + x) * 3 + c;
                const auto value = static_cast<double>(picture.pixels[i]),
                           level = static_cast<double>(level_.pixels[i]);
                const double d = value - static_cast<double>(reference_.pixels[i]);
                sums_[i] += value;
                squares_[i] += value * value;
                differences[tile] += d * part;
                mse[tile] += d * d * part;
                ofPixel += d * d / (level * level + core::kRelMseFloor);
            }
            relMse[tile] += ofPixel * part;
            const double noise = noiseOfPixels_[size_t(y) * picture.width + x];
            ofPixels.push_back({ofPixel / 3, ofPixel / 3 - noise});
        }
    ++pictures_;
    const double trimmed = trimmedNet(ofPixels, kFireflies);
    trimmed_ += trimmed;
    trimmedSquares_ += trimmed * trimmed;
    mse_.add(mse);
    relMse_.add(relMse);
    signed_.add(differences);
}

std::vector<double> tileDifferences(const core::Image& a, const core::Image& b)
{
    CHECK(a.width == b.width && a.height == b.height && a.channels == 3 && b.channels == 3);
    const uint32_t across = tilesAcross(a.width, kTileSide),
                   down = tilesAcross(a.height, kTileSide);
    std::vector<double> tiles(size_t(across) * down);
    const double part = 1 / static_cast<double>(a.pixels.size());
    for (size_t i = 0; i < a.pixels.size(); ++i) {
        const size_t x = i / 3 % a.width, y = i / 3 / a.width;
        tiles[y / kTileSide * across + x / kTileSide] +=
            part * (static_cast<double>(a.pixels[i]) - static_cast<double>(b.pixels[i]));
    }
    return tiles;
}

PictureErrors ErrorSum::errors() const
{
    CHECK(pictures_ > 0);
    const double count = pictures_, values = static_cast<double>(sums_.size());
    PictureErrors e;
    e.pictures = pictures_;
    e.mse = mse_.mean();
    e.mse.value -= noise_;
    e.relMse = relMse_.mean();
    e.relMse.value -= relativeNoise_;
    e.signedError = signed_.mean();
    e.signedError.error = std::hypot(e.signedError.error, std::sqrt(signedNoise_));
    e.trimmed = {trimmed_ / count,
                 pictures_ < 2 ? kNaN
                               : std::sqrt(varianceOf(trimmed_, trimmedSquares_, count) / count)};
    e.variance = pictures_ < 2 ? kNaN : 0;
    for (size_t i = 0; pictures_ > 1 && i < sums_.size(); ++i)
        e.variance += varianceOf(sums_[i], squares_[i], count) / values;
    return e;
}

}  // namespace app
