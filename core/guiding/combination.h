// Weights for averaging the renders of several training iterations, each noisier or quieter than
// the last: by samples, by inverse variance (T. Mueller in "Path Guiding in Production", SIGGRAPH
// course, 2019), or by the effective sample size of their contributions (S. Wang, "Efficient Sample
// Usage in Photo-Realistic Rendering", 2022, chapter 9). Weights taken from the samples that they
// multiply are biased, mostly to the dark: few bright samples make a pixel both low and seemingly
// certain. Sharing them among many pixels makes that small, cross-fitting makes it vanish.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/base/check.h"
#include "core/reuse/ess.h"

namespace core::guiding {

/// What one iteration knows of one pixel: its contributions (luminance) in three sums.
struct PixelSums {
    double count = 0, sum = 0, squares = 0;

    void add(double x)
    {
        count += 1;
        sum += x;
        squares += x * x;
    }
    PixelSums& operator+=(const PixelSums& other)
    {
        count += other.count;
        sum += other.sum;
        squares += other.squares;
        return *this;
    }

    double mean() const { return count > 0 ? sum / count : 0; }

    /// Unbiased estimate of the variance of the mean; 0 when nothing varies or there are fewer than
    /// two samples.
    double varianceOfMean() const;

    /// ESS-hat, (sum x)^2 / sum x^2: the inverse of relative variance of the mean + 1 / count. 0
    /// when all is black.
    double effectiveSamples() const { return reuse::effectiveSampleSize(sum, squares); }
};

/// How the weight of an iteration is made from the pixels of a group; with a group of one pixel
/// each has weights of its own.
enum class CombineBy : uint8_t {
    samples,              // counts only: unbiased, blind to noise
    inverseMeanVariance,  // 1 / mean of variances: fireflies dominate
    meanInverseVariance,  // mean of 1 / variance: quiet pixels dominate
    effectiveSamples,     // mean of ESS-hat
};

/// What the pixels of a group say of their iterations, pixel after pixel: for weights of pixels
/// that are not all at hand.
class GroupStatistic {
public:
    static constexpr size_t kMost = 64;  // iterations

    GroupStatistic(CombineBy by, size_t iterations);

    /// One pixel, of all iterations in their order.
    void add(std::span<const PixelSums> pixel);
    GroupStatistic& operator+=(const GroupStatistic& other);

    /// As combinationWeights.
    void weights(std::span<double> weights) const;

private:
    CombineBy by_;
    size_t count_;
    std::array<double, kMost> sums_{}, samples_{};
    bool any_ = false;
};

/// Weights of iterations, which sum to one, for the pixels of a group. `iterations[k][i]` is pixel
/// i in iteration k; all iterations have the same pixels. A pixel where the noise of some iteration
/// is unknown (black, or without variance) does not count; where no pixel counts, the numbers of
/// samples decide.
void combinationWeights(CombineBy by, std::span<const std::span<const PixelSums>> iterations,
                        std::span<double> weights);

/// The same for a single pixel.
void combinationWeights(CombineBy by, std::span<const PixelSums> iterations,
                        std::span<double> weights);

/// sum w_k x_k of the iterations' values (numbers, colours), which Real scales.
template <class Value, class Real>
Value combine(std::span<const Value> values, std::span<const Real> weights)
{
    CHECK(values.size() == weights.size() && !values.empty());
    Value sum = values[0] * weights[0];
    for (size_t k = 1; k < values.size(); ++k) sum += values[k] * weights[k];
    return sum;
}

/// Two independent halves of every iteration (even and odd passes) of equal size, each averaged
/// with the weights of the other: unbiased, whatever the weights.
template <class Value, class Real>
Value combineCrossFitted(std::span<const Value> first, std::span<const Real> weightsOfFirst,
                         std::span<const Value> second, std::span<const Real> weightsOfSecond)
{
    return (combine(first, weightsOfSecond) + combine(second, weightsOfFirst)) * Real(0.5);
}

}  // namespace core::guiding
