#include "core/guiding/pixel_estimates.h"

#include <algorithm>

#include "core/base/check.h"
#include "shared/lang.h"

namespace core::guiding {

namespace {

constexpr size_t kReach = 3;
constexpr double kFloor = 0.02;

/// Means over [i - kReach, i + kReach] of `count` values that are `step` apart.
void blur(const float* in, float* out, size_t count, size_t step)
{
    double sum = 0;
    size_t inside = 0;
    for (size_t i = 0; i < std::min(kReach, count); ++i, ++inside) sum += double(in[i * step]);
    for (size_t i = 0; i < count; ++i) {
        if (i + kReach < count) {
            sum += double(in[(i + kReach) * step]);
            ++inside;
        }
        if (i > kReach) {
            sum -= double(in[(i - kReach - 1) * step]);
            --inside;
        }
        out[i * step] = static_cast<float>(std::max(sum, 0.0) / double(inside));
    }
}

}  // namespace

std::vector<float> pixelEstimates(std::span<const float> rgb, uint32_t width, uint32_t height)
{
    const size_t count = size_t(width) * height;
    CHECK(rgb.size() == 3 * count);
    std::vector<float> values(count), rows(count);
    double sum = 0;
    for (size_t i = 0; i < count; ++i) {
        const float y = shared::luminance({rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]});
        values[i] = y > 0 && y < 1e30f ? y : 0;
        sum += double(values[i]);
    }
    for (size_t y = 0; y < height; ++y) blur(&values[y * width], &rows[y * width], width, 1);
    for (size_t x = 0; x < width; ++x) blur(&rows[x], &values[x], height, width);
    const auto least = static_cast<float>(kFloor * sum / double(std::max<size_t>(count, 1)));
    for (float& v : values) v = std::max(v, least);
    return values;
}

}  // namespace core::guiding
