// Weights for averaging the renders of several iterations (T-27): which are biased, and what their
// average varies by.
#include "core/guiding/combination.h"

#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <gtest/gtest.h>
#include <vector>

#include "core/base/pcg32.h"
#include "core/reuse/ess.h"
#include "tests/support/statistics/stats.h"

namespace {

using core::Pcg32;
using core::guiding::combinationWeights;
using core::guiding::combine;
using core::guiding::CombineBy;
using core::guiding::combineCrossFitted;
using core::guiding::PixelSums;

using Weights = std::array<double, 2>;  // of two iterations

/// Log-normal contributions of mean one, sigma 1.2: as skewed as those of a path tracer.
class Contributions {
public:
    static constexpr double kSigma = 1.2;

    explicit Contributions(uint32_t seed) : random_(seed) {}

    PixelSums pixel(int samples)
    {
        PixelSums sums;
        for (int i = 0; i < samples; ++i)
            sums.add(std::exp(kSigma * normal() - kSigma * kSigma / 2));
        return sums;
    }

private:
    double normal()  // Box and Muller, in pairs
    {
        std::swap(next_, spare_);
        has_ = !has_;
        if (!has_) return next_;
        const double radius = std::sqrt(-2 * std::log(1 - random_())), angle = 2 * M_PI * random_();
        spare_ = radius * std::sin(angle);
        return radius * std::cos(angle);
    }

    Pcg32 random_;
    double next_ = 0, spare_ = 0;
    bool has_ = false;
};

/// A hundred pixels of two iterations of 16 and 32 samples, in halves.
struct Group {
    static constexpr size_t kPixels = 100;
    using Pixels = std::array<PixelSums, kPixels>;
    std::array<Pixels, 2> first, second, whole;  // per iteration

    explicit Group(Contributions& contributions)
    {
        for (size_t k = 0; k < 2; ++k) {
            for (size_t i = 0; i < kPixels; ++i) {
                first[k][i] = contributions.pixel(k == 0 ? 8 : 16);
                second[k][i] = contributions.pixel(k == 0 ? 8 : 16);
                whole[k][i] = first[k][i];
                whole[k][i] += second[k][i];
            }
        }
    }
};

std::array<PixelSums, 2> pixelOf(const std::array<Group::Pixels, 2>& of, size_t i)
{
    return {of[0][i], of[1][i]};
}

Weights weightsOf(CombineBy by, const std::array<PixelSums, 2>& pixel)
{
    Weights weights;
    combinationWeights(by, pixel, weights);
    return weights;
}

double average(const std::array<PixelSums, 2>& pixel, const Weights& weights)
{
    const std::array<double, 2> means{pixel[0].mean(), pixel[1].mean()};
    return combine(std::span<const double>(means), std::span<const double>(weights));
}

using Averages = std::array<double, Group::kPixels>;

Averages perPixel(const Group& group, CombineBy by)
{
    Averages averages;
    for (size_t i = 0; i < Group::kPixels; ++i) {
        const auto pixel = pixelOf(group.whole, i);
        averages[i] = average(pixel, weightsOf(by, pixel));
    }
    return averages;
}

Averages perGroup(const Group& group, CombineBy by)
{
    const std::array<std::span<const PixelSums>, 2> iterations{group.whole[0], group.whole[1]};
    Weights weights;
    combinationWeights(by, iterations, weights);
    Averages averages;
    for (size_t i = 0; i < Group::kPixels; ++i)
        averages[i] = average(pixelOf(group.whole, i), weights);
    return averages;
}

Averages crossFitted(const Group& group, CombineBy by)
{
    Averages averages;
    for (size_t i = 0; i < Group::kPixels; ++i) {
        const auto a = pixelOf(group.first, i), b = pixelOf(group.second, i);
        const std::array<double, 2> first{a[0].mean(), a[1].mean()},
            second{b[0].mean(), b[1].mean()};
        const Weights ofFirst = weightsOf(by, a), ofSecond = weightsOf(by, b);
        averages[i] =
            combineCrossFitted(std::span<const double>(first), std::span<const double>(ofFirst),
                               std::span<const double>(second), std::span<const double>(ofSecond));
    }
    return averages;
}

/// Mean and variance over pixels with their errors, from groups, whose pixels may share weights.
class GroupedMoments {
public:
    void add(const Averages& averages)
    {
        double sum = 0, squares = 0;
        for (const double x : averages) {
            sum += x - 1;
            squares += (x - 1) * (x - 1);
        }
        first_.add(sum / Group::kPixels);
        second_.add(squares / Group::kPixels);
    }
    double bias() const { return first_.mean(); }
    double biasError() const { return std::sqrt(first_.varianceOfMean()); }
    double variance() const { return second_.mean() - bias() * bias(); }
    double varianceError() const  // of the second moment: the bias is small and well known
    {
        return std::sqrt(second_.varianceOfMean());
    }

private:
    tests::Moments first_, second_;
};

struct CombiningStrategy {
    const char* name;
    Averages (*averages)(const Group&, CombineBy);
    CombineBy by;
    double bias, variance;  // measured with 4000 groups
    bool biased;
};

constexpr CombiningStrategy kStrategies[] = {
    {"samples", perPixel, CombineBy::samples, 0, .0665, false},
    {"1/variance", perPixel, CombineBy::inverseMeanVariance, -.1217, .0516, true},
    {"ESS-hat", perPixel, CombineBy::effectiveSamples, -.0354, .0526, true},
    {"1/(mean variance)", perGroup, CombineBy::inverseMeanVariance, -.0033, .0638, true},
    {"mean of 1/variance", perGroup, CombineBy::meanInverseVariance, -.0013, .0712, true},
    {"mean ESS-hat", perGroup, CombineBy::effectiveSamples, -.0004, .0667, false},
    {"cross-fitted 1/variance", crossFitted, CombineBy::inverseMeanVariance, .0002, .1169, false},
    {"cross-fitted ESS-hat", crossFitted, CombineBy::effectiveSamples, 0, .0720, false},
};

/// Against values that were themselves measured with 4000 groups and printed with four digits.
void expectTable(int groups, uint32_t seed, double detectable)
{
    std::array<GroupedMoments, std::size(kStrategies)> moments;
    Contributions contributions(seed);
    for (int g = 0; g < groups; ++g) {
        const Group group(contributions);
        for (size_t i = 0; i < moments.size(); ++i)
            moments[i].add(kStrategies[i].averages(group, kStrategies[i].by));
    }
    const double both = std::sqrt(1 + groups / 4000.0), rounding = 5e-5;
    for (size_t i = 0; i < moments.size(); ++i) {
        const GroupedMoments& m = moments[i];
        const CombiningStrategy& s = kStrategies[i];
        EXPECT_NEAR(m.bias(), s.bias, 4.5 * both * m.biasError() + rounding) << s.name;
        EXPECT_NEAR(m.variance(), s.variance, 4.5 * both * m.varianceError() + rounding) << s.name;
        if (s.biased && std::abs(s.bias) > detectable) {
            EXPECT_LT(m.bias(), -4.5 * m.biasError()) << s.name << " must be seen to be biased";
        } else if (!s.biased && s.bias > -1e-4) {
            EXPECT_LT(std::abs(m.bias()), 4.5 * m.biasError()) << s.name;
        }
    }
    // What is known exactly: the variance of 48 samples.
    const double exact = (std::exp(Contributions::kSigma * Contributions::kSigma) - 1) / 48;
    EXPECT_NEAR(moments[0].variance(), exact, 4.5 * moments[0].varianceError());
}

TEST(Combination, StrategiesAgreeWithTheTable)
{
    expectTable(8000, 901, 0.002);
}

TEST(Combination, SlowStrategiesAgreeWithTheTable)
{
    expectTable(80000, 902, 0.001);
}

TEST(Combination, StatisticsOfAPixel)
{
    Pcg32 random(903);
    std::vector<double> contributions;
    PixelSums sums;
    tests::Moments moments;
    for (int i = 0; i < 37; ++i) {
        contributions.push_back(std::exp(3 * random()));
        sums.add(contributions.back());
        moments.add(contributions.back());
    }
    const std::span<const double> all(contributions);
    EXPECT_NEAR(sums.mean(), moments.mean(), 1e-12);
    EXPECT_NEAR(sums.varianceOfMean() / moments.varianceOfMean(), 1, 1e-12);
    EXPECT_NEAR(sums.effectiveSamples() / core::reuse::effectiveSampleSize(all), 1, 1e-12);
    // Relative variance of the mean = 1 / ESS-hat - 1 / N, with the population's variance.
    const double population = sums.varianceOfMean() * 36 / 37 / (sums.mean() * sums.mean());
    EXPECT_NEAR(1 / sums.effectiveSamples() - 1.0 / 37, population, 1e-12);

    PixelSums halves;
    for (size_t i = 0; i < 37; ++i) {
        PixelSums one;
        one.add(contributions[i]);
        halves += one;
    }
    EXPECT_DOUBLE_EQ(halves.squares, sums.squares);
}

PixelSums pixelWith(double count, double mean, double varianceOfMean)
{
    return {count, count * mean, varianceOfMean * count * (count - 1) + count * mean * mean};
}

TEST(Combination, WeightsFollowTheirFormula)
{
    const std::array<PixelSums, 2> a{pixelWith(4, 1, 0.1), pixelWith(4, 2, 0.3)};  // iteration 0
    const std::array<PixelSums, 2> b{pixelWith(8, 1, 0.02), pixelWith(8, 2, 0.08)};
    const std::array<std::span<const PixelSums>, 2> iterations{a, b};
    Weights w;
    combinationWeights(CombineBy::samples, iterations, w);
    EXPECT_NEAR(w[1] / w[0], 2, 1e-12);
    combinationWeights(CombineBy::inverseMeanVariance, iterations, w);
    EXPECT_NEAR(w[1] / w[0], 4, 1e-12);
    combinationWeights(CombineBy::meanInverseVariance, iterations, w);
    EXPECT_NEAR(w[1] / w[0], (50 + 12.5) / (10 + 1 / 0.3), 1e-12);
    combinationWeights(CombineBy::effectiveSamples, iterations, w);
    EXPECT_NEAR(w[1] / w[0],
                (b[0].effectiveSamples() + b[1].effectiveSamples()) /
                    (a[0].effectiveSamples() + a[1].effectiveSamples()),
                1e-12);
    EXPECT_NEAR(w[0] + w[1], 1, 1e-15);

    const std::array<glm::vec3, 2> colours{glm::vec3(1, 2, 3), glm::vec3(5, 6, 7)};
    const std::array<float, 2> shares{0.25f, 0.75f};
    EXPECT_EQ(combine(std::span<const glm::vec3>(colours), std::span<const float>(shares)),
              glm::vec3(4, 5, 6));
}

TEST(Combination, PixelsThatCannotTellHaveNoSay)
{
    const PixelSums black{16, 0, 0}, constant = pixelWith(16, 0.7, 0),
                                     noisy = pixelWith(16, 1, 0.1);
    const PixelSums quieter = pixelWith(32, 1, 0.02);
    for (const CombineBy by : {CombineBy::inverseMeanVariance, CombineBy::meanInverseVariance}) {
        const Weights informed = weightsOf(by, {noisy, quieter});
        EXPECT_NEAR(informed[1] / informed[0], 5, 1e-12);
        for (const PixelSums& silent : {black, constant}) {
            // Alone: by samples, not by a division by zero.
            const Weights w = weightsOf(by, {silent, quieter});
            EXPECT_NEAR(w[1] / w[0], 2, 1e-12);
            // Among others: as if it were not there.
            const std::array<PixelSums, 2> first{noisy, silent}, second{quieter, noisy};
            const std::array<std::span<const PixelSums>, 2> iterations{first, second};
            Weights both;
            combinationWeights(by, iterations, both);
            EXPECT_DOUBLE_EQ(both[0], informed[0]);
        }
    }
    EXPECT_NEAR(weightsOf(CombineBy::effectiveSamples, {black, quieter})[0], 1.0 / 3, 1e-12);
    // Nothing at all: equal weights, which sum to one.
    for (const CombineBy by :
         {CombineBy::samples, CombineBy::inverseMeanVariance, CombineBy::effectiveSamples})
        EXPECT_EQ(weightsOf(by, {PixelSums(), PixelSums()})[0], 0.5);
    // Equal contributions whose sums round differently have no variance.
    PixelSums equal;
    for (int i = 0; i < 1000; ++i) equal.add(0.1);
    EXPECT_EQ(equal.varianceOfMean(), 0);
    PixelSums single;
    single.add(3);
    EXPECT_EQ(single.varianceOfMean(), 0);
}

}  // namespace
