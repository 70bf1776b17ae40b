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

}  // namespace

GroupStatistic::GroupStatistic(CombineBy by, size_t iterations) : by_(by), count_(iterations)
{
    CHECK(iterations > 0 && iterations <= kMost);
}

void GroupStatistic::add(std::span<const PixelSums> pixel)
{
    std::array<double, kMost> own;
    bool tells = true;
    for (size_t k = 0; k < count_; ++k) {
        samples_[k] += pixel[k].count;
        own[k] = statistic(by_, pixel[k]);
        tells = tells && own[k] > 0;
    }
    if (!tells) return;
    any_ = true;
    for (size_t k = 0; k < count_; ++k) sums_[k] += own[k];
}

GroupStatistic& GroupStatistic::operator+=(const GroupStatistic& other)
{
    for (size_t k = 0; k < count_; ++k) {
        sums_[k] += other.sums_[k];
        samples_[k] += other.samples_[k];
    }
    any_ = any_ || other.any_;
    return *this;
}

void GroupStatistic::weights(std::span<double> weights) const
{
    CHECK(weights.size() == count_);
    double sum = 0;
    for (size_t k = 0; k < count_; ++k) {
        weights[k] = !any_                                   ? samples_[k]
                     : by_ == CombineBy::inverseMeanVariance ? 1 / sums_[k]
                                                             : sums_[k];
        sum += weights[k];
    }
    for (double& w : weights) w = sum > 0 ? w / sum : 1.0 / double(count_);
}

void combinationWeights(CombineBy by, std::span<const std::span<const PixelSums>> iterations,
                        std::span<double> weights)
{
    GroupStatistic group(by, iterations.size());
    for (const auto& pixels : iterations)
        CHECK(!pixels.empty() && pixels.size() == iterations[0].size());
    std::array<PixelSums, GroupStatistic::kMost> pixel;
    for (size_t i = 0; i < iterations[0].size(); ++i) {
        for (size_t k = 0; k < iterations.size(); ++k) pixel[k] = iterations[k][i];
        group.add(std::span(pixel).first(iterations.size()));
    }
    group.weights(weights);
}

void combinationWeights(CombineBy by, std::span<const PixelSums> iterations,
                        std::span<double> weights)
{
    GroupStatistic group(by, iterations.size());
    group.add(iterations);
    group.weights(weights);
}

}  // namespace core::guiding
