// Sums in double, in order of tiles: the numbers do not depend on threads.
#include "app/pictures/error_point.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/image/metrics.h"

namespace app {

namespace {

constexpr size_t kMostPoints = 300;

/// Squared errors of a tile over its pixels that are finite in both images.
struct TileSum {
    double squares = 0, pixels = 0;
};

TileSum sumTile(const core::Image& a, const core::Image& b, uint32_t x0, uint32_t y0)
{
    TileSum sum;
    for (uint32_t y = y0; y < std::min(y0 + kErrorTile, a.height); ++y) {
        for (uint32_t x = x0; x < std::min(x0 + kErrorTile, a.width); ++x) {
            const float* p = a.at(x, y);
            const float* q = b.at(x, y);
            double squares = 0;
            for (int c = 0; c < 3; ++c) {
                const double d = double(p[c]) - double(q[c]);
                squares += d * d;
            }
            if (!std::isfinite(squares)) continue;
            sum.squares += squares / 3;
            sum.pixels += 1;
        }
    }
    return sum;
}

}  // namespace

ErrorEstimate errorAgainst(const core::Image& image, const core::Image& reference)
{
    CHECK(image.width == reference.width && image.height == reference.height &&
          image.channels >= 3 && reference.channels >= 3);
    std::vector<TileSum> tiles;
    TileSum total;
    for (uint32_t y = 0; y < image.height; y += kErrorTile) {
        for (uint32_t x = 0; x < image.width; x += kErrorTile) {
            const TileSum tile = sumTile(image, reference, x, y);
            if (tile.pixels == 0) continue;
            tiles.push_back(tile);
            total.squares += tile.squares;
            total.pixels += tile.pixels;
        }
    }
    if (tiles.empty()) return {};
    const double mse = total.squares / total.pixels;
    double spread = 0;
    for (const TileSum& tile : tiles) {
        const double d = (tile.squares - mse * tile.pixels) / total.pixels;
        spread += d * d;
    }
    ErrorEstimate e;
    e.rmse = std::sqrt(mse);
    const auto count = double(tiles.size());
    if (tiles.size() > 1 && e.rmse > 0)
        e.rmseSe = std::sqrt(spread * count / (count - 1)) / (2 * e.rmse);
    return e;
}

ErrorPoint errorPoint(const core::Estimate& estimate, double seconds, const Reference* reference)
{
    const core::Image& mean = estimate.mean;
    ErrorPoint point;
    point.seconds = seconds;
    point.samples = estimate.samples;
    point.estimated = core::noiseOf(estimate.variance);
    if (reference != nullptr && reference->mean.width == mean.width &&
        reference->mean.height == mean.height && reference->mean.channels >= 3) {
        const ErrorEstimate e = errorAgainst(mean, reference->mean);
        point.rmse = e.rmse;
        point.rmseSe = e.rmseSe;
    }
    return point;
}

void addPoint(std::vector<ErrorPoint>& curve, const ErrorPoint& point)
{
    if (!curve.empty() && curve.back().samples == point.samples) curve.pop_back();
    if (curve.size() >= kMostPoints) {
        size_t kept = 0;
        for (size_t i = 0; i < curve.size(); i += 2) curve[kept++] = curve[i];
        curve.resize(kept);
    }
    curve.push_back(point);
}

}  // namespace app
