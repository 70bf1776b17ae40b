// Integer CDFs in units of 2^-24, and what the texels of an environment weigh.
#include "core/scene/light_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/check.h"
#include "shared/layout.h"

namespace core {

std::vector<float> makeCdf(std::span<const double> weights)
{
    CHECK(!weights.empty());
    constexpr uint64_t kUnits = 1u << 24;
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    const bool uniform = !(total > 0);
    const auto weight = [&](size_t i) { return uniform ? 1.0 : weights[i]; };
    uint64_t positive = 0;
    for (size_t i = 0; i < weights.size(); ++i) positive += weight(i) > 0;
    CHECK(std::isfinite(total) && positive <= kMaxCdfEntries);

    // Every positive weight owns one unit; the others are shared out by the running sum.
    const double scale = static_cast<double>(kUnits - positive) /
                         (uniform ? static_cast<double>(weights.size()) : total);
    std::vector<float> cdf(weights.size() + 1);
    double sum = 0;
    uint64_t owned = 0;
    for (size_t i = 0; i < weights.size(); ++i) {
        sum += weight(i);
        owned += weight(i) > 0;
        const uint64_t shared =
            owned == positive ? kUnits - positive
                              : std::min(static_cast<uint64_t>(sum * scale), kUnits - positive);
        cdf[i + 1] = static_cast<float>(owned + shared) / static_cast<float>(kUnits);
    }
    return cdf;
}

std::vector<double> environmentWeights(std::span<const glm::vec4> texels, uint32_t width,
                                       uint32_t height)
{
    CHECK(texels.size() == size_t(width) * height);
    std::vector<double> blurred(texels.size());  // along x
    for (size_t y = 0; y < height; ++y) {
        const auto at = [&](size_t x) {
            return static_cast<double>(
                std::max(0.0f, shared::luminance(glm::vec3(texels[y * width + x]))));
        };
        for (size_t x = 0; x < width; ++x) {
            const double left = at(x == 0 ? width - 1 : x - 1),
                         right = at(x + 1 == width ? 0 : x + 1);
            blurred[y * width + x] = (left + 6 * at(x) + right) / 8;
        }
    }
    std::vector<double> weights(texels.size());
    using std::numbers::pi;
    for (size_t y = 0; y < height; ++y) {
        const size_t above = y == 0 ? 0 : y - 1, below = y + 1 == height ? y : y + 1;
        const double top = std::cos(pi * static_cast<double>(y) / height);
        const double bottom = std::cos(pi * static_cast<double>(y + 1) / height);
        const double solidAngle = (top - bottom) * 2 * pi / width;
        for (size_t x = 0; x < width; ++x) {
            const double mean = (blurred[above * width + x] + 6 * blurred[y * width + x] +
                                 blurred[below * width + x]) /
                                8;
            weights[y * width + x] = mean * solidAngle;
        }
    }
    return weights;
}

/// For each part of [0,1), and its end, the last interval of `cdf` that begins no later.
static void appendParts(std::span<const float> cdf, std::vector<float>& out)
{
    const auto end = cdf.end() - 1;
    for (uint32_t k = 0; k <= shared::kCdfParts; ++k) {
        const float u = static_cast<float>(k) / shared::kCdfParts;
        out.push_back(static_cast<float>(std::upper_bound(cdf.begin(), end, u) - cdf.begin() - 1));
    }
}

std::vector<float> makeEnvironmentCdf(std::span<const double> weights, uint32_t width,
                                      uint32_t height)
{
    CHECK(weights.size() == size_t(width) * height);
    std::vector<double> rows(height);
    std::vector<float> cdf;
    const size_t values = shared::firstCdfPart(width, height);
    cdf.reserve(values + size_t(height + 1) * (shared::kCdfParts + 1));
    for (uint32_t y = 0; y < height; ++y) {
        const auto row = weights.subspan(size_t(y) * width, width);
        rows[y] = std::accumulate(row.begin(), row.end(), 0.0);
    }
    const std::vector<float> marginal = makeCdf(rows);
    cdf.insert(cdf.end(), marginal.begin(), marginal.end());
    for (uint32_t y = 0; y < height; ++y) {
        const std::vector<float> conditional = makeCdf(weights.subspan(size_t(y) * width, width));
        cdf.insert(cdf.end(), conditional.begin(), conditional.end());
    }
    appendParts({cdf.data(), height + 1u}, cdf);
    for (size_t y = 0; y < height; ++y)
        appendParts({cdf.data() + height + 1 + y * (width + 1), width + 1u}, cdf);
    CHECK(cdf.size() == values + size_t(height + 1) * (shared::kCdfParts + 1));
    return cdf;
}

}  // namespace core
