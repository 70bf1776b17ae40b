#include "core/guiding/convergence.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "shared/guided_path.h"

namespace core::guiding {

namespace {

std::vector<float> luminances(std::span<const float> rgb)
{
    std::vector<float> y(rgb.size() / 3);
    for (size_t i = 0; i < y.size(); ++i)
        y[i] = shared::luminance({rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]});
    return y;
}

/// Whether the pixel had a path of its own kind among the samples with these indices.
bool isOther(uint32_t x, uint32_t y, uint32_t stride)
{
    const uint32_t lane = shared::guideCell({x & 7u, y & 7u});
    return shared::isRecorded(lane, 2, stride) || shared::isRecorded(lane, 3, stride);
}

}  // namespace

void Convergence::begin()
{
    means_ = {};
}

void Convergence::note(uint64_t samples, std::span<const float> rgb, uint32_t width,
                       std::span<const float> estimates, uint32_t stride, double floor)
{
    if (samples == 1 || samples == 2) means_[samples - 1] = luminances(rgb);
    if (samples != 4) return;
    const std::vector<float> four = luminances(rgb);
    if (means_[0].size() != four.size() || means_[1].size() != four.size()) return;
    CHECK(estimates.size() == four.size());
    double first = 0, second = 0;
    double firstSquares = 0, products = 0, secondSquares = 0;
    for (size_t i = 0; i < four.size(); ++i) {
        if (isOther(uint32_t(i % width), uint32_t(i / width), stride)) continue;
        const double e = double(estimates[i]), a = double(means_[0][i]), b = double(means_[1][i]),
                     c = double(four[i]), weight = 1 / (e * e + floor);
        const double x = weight * (a - b) * (a - b), y = weight * (b - c) * (b - c);
        first += x;
        second += y;
        firstSquares += x * x;
        products += x * y;
        secondSquares += y * y;
    }
    if (!(first > 0 && second > 0)) return;
    // By what factor variances fall at each doubling. A few bright pixels can make it anything, so
    // that two standard errors less are believed; of independent samples it is two.
    const double fall = first / second;
    const double spread =
        std::max(firstSquares - 2 * fall * products + fall * fall * secondSquares, 0.0);
    const double believed = std::max(fall - 2 * std::sqrt(spread) / second, 2.0);
    // As if they went on to fall like that: V_2 is then the sum of a geometric series, and V_2 over
    // half of V_1 is two over the factor. Two more doublings are thought to bring as much as the
    // first, after which the gain slows down (in a box of diffuse walls, .84 at two samples, .75 at
    // 8, .53 at 64).
    const double share = 2 / believed;
    factor_ = std::clamp(share * share, 0.5, 1.0);
}

}  // namespace core::guiding
