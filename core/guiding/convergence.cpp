#include "core/guiding/convergence.h"

#include <algorithm>

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
                       std::span<const float> estimates, uint32_t stride)
{
    if (samples == 1 || samples == 2) means_[samples - 1] = luminances(rgb);
    if (samples != 4) return;
    const std::vector<float> four = luminances(rgb);
    if (means_[0].size() != four.size() || means_[1].size() != four.size()) return;
    CHECK(estimates.size() == four.size());
    double all = 0;
    for (const float e : estimates) all += double(e);
    const double floor = all / double(estimates.size());
    double first = 0, second = 0;
    for (size_t i = 0; i < four.size(); ++i) {
        if (isOther(uint32_t(i % width), uint32_t(i / width), stride)) continue;
        const double e = double(estimates[i]), a = double(means_[0][i]), b = double(means_[1][i]),
                     c = double(four[i]), weight = 1 / (e * e + 0.01 * floor * floor);
        first += weight * (a - b) * (a - b);
        second += weight * (b - c) * (b - c);
    }
    if (!(first > 0 && second > 0)) return;
    // As if the variances went on to fall by the same factor: V_2 is then the sum of a geometric
    // series. Two more doublings are thought to bring as much as the first, after which the gain
    // slows down (in a box of diffuse walls, .84 at two samples, .75 at 8, .53 at 64).
    const double fall = std::max(first / second, 1.5);
    const double two = second * fall / (fall - 1);
    const double share = 2 * two / (first + two);
    factor_ = std::clamp(share * share, 0.5, 1.0);
}

}  // namespace core::guiding
