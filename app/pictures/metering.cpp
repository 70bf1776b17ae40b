// See metering.h.
#include "app/pictures/metering.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "shared/tonemap.h"

namespace app {

namespace {

constexpr double kMidGrey = 0.18;
constexpr uint32_t kPartsAlong = 64;  // the longer side
constexpr float kMostStops = 20;

/// The mean luminance of a part, of its pixels that are numbers.
double luminanceOf(const core::Image& picture, uint32_t x0, uint32_t y0, uint32_t side)
{
    double sum = 0;
    uint32_t count = 0;
    for (uint32_t y = y0; y < std::min(y0 + side, picture.height); ++y)
        for (uint32_t x = x0; x < std::min(x0 + side, picture.width); ++x) {
            const float* p = picture.at(x, y);
            const float luminance = shared::luminance({p[0], p[1], p[2]});
            if (!std::isfinite(luminance)) continue;
            sum += static_cast<double>(luminance);
            ++count;
        }
    return count > 0 ? sum / count : 0;
}

}  // namespace

std::optional<float> meteredStops(const core::Image& picture)
{
    if (picture.channels < 3) return {};
    const uint32_t side =
        std::max((std::max(picture.width, picture.height) + kPartsAlong - 1) / kPartsAlong, 1u);
    std::vector<double> lit;
    for (uint32_t y = 0; y < picture.height; y += side)
        for (uint32_t x = 0; x < picture.width; x += side)
            if (const double luminance = luminanceOf(picture, x, y, side); luminance > 0)
                lit.push_back(luminance);
    if (lit.empty()) return {};
    const auto middle = lit.begin() + static_cast<std::ptrdiff_t>(lit.size() / 2);
    std::nth_element(lit.begin(), middle, lit.end());
    return std::clamp(static_cast<float>(std::log2(kMidGrey / *middle)), -kMostStops, kMostStops);
}

}  // namespace app
