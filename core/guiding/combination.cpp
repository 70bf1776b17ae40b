// See combination.h.
#include "core/guiding/combination.h"

#include <algorithm>

namespace core::guiding {

double PixelSums::varianceOfMean() const
{
    if (!(count > 1)) return 0;
    const double deviations = squares - sum * sum / count;
    // Sums of equal numbers differ by rounding.
    if (!(deviations > 1e-13 * squares)) return 0;
    return deviations / (count * (count - 1));
}

namespace {

/// What a pixel of one iteration adds to the group's statistic; 0 where that is unknown.
double statistic(CombineBy by, const PixelSums& pixel)
{
    switch (by) {
    case CombineBy::samples:
        return pixel.count;
    case CombineBy::inverseMeanVariance:
        return pixel.varianceOfMean();
    case CombineBy::meanInverseVariance: {
        const double variance = pixel.varianceOfMean();
        return variance > 0 ? 1 / variance : 0;
    }
    case CombineBy::effectiveSamples:
        return pixel.effectiveSamples();
    }
    return 0;
}

/// Sums of the statistic over the pixels where all iterations have one. False if there are none.
bool sumStatistics(CombineBy by, std::span<const std::span<const PixelSums>> iterations,
                   std::span<double> sums)
{
    std::fill(sums.begin(), sums.end(), 0.0);
    bool any = false;
    for (size_t i = 0; i < iterations[0].size(); ++i) {
        const bool tells =
            std::all_of(iterations.begin(), iterations.end(),
                        [&](const auto& pixels) { return statistic(by, pixels[i]) > 0; });
        if (!tells) continue;
        any = true;
        for (size_t k = 0; k < sums.size(); ++k) sums[k] += statistic(by, iterations[k][i]);
    }
    return any;
}

}  // namespace

void combinationWeights(CombineBy by, std::span<const std::span<const PixelSums>> iterations,
                        std::span<double> weights)
{
    CHECK(!iterations.empty() && weights.size() == iterations.size());
    for (const auto& pixels : iterations)
        CHECK(!pixels.empty() && pixels.size() == iterations[0].size());
    if (!sumStatistics(by, iterations, weights)) {
        const bool sampled = sumStatistics(CombineBy::samples, iterations, weights);
        if (!sampled) std::fill(weights.begin(), weights.end(), 1.0);
    } else if (by == CombineBy::inverseMeanVariance) {
        for (double& w : weights) w = 1 / w;
    }
    double sum = 0;
    for (const double w : weights) sum += w;
    for (double& w : weights) w /= sum;
}

void combinationWeights(CombineBy by, std::span<const PixelSums> iterations,
                        std::span<double> weights)
{
    constexpr size_t kMost = 64;  // more iterations than doubling sample counts can make
    std::array<std::span<const PixelSums>, kMost> single;
    CHECK(iterations.size() <= kMost);
    for (size_t k = 0; k < iterations.size(); ++k) single[k] = iterations.subspan(k, 1);
    combinationWeights(
        by, std::span<const std::span<const PixelSums>>(single.data(), iterations.size()), weights);
}

}  // namespace core::guiding
