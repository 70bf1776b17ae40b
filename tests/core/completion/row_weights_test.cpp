// M3. Draws of rows: against the textbook's method and against exact probabilities.
#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "core/completion/bits.h"
#include "core/completion/row_weights.h"
#include "tests/support/statistics/stats.h"

namespace core::many_lights {
namespace {

Words allRows(uint32_t rows)
{
    Words words(wordsFor(rows));
    for (size_t w = 0; w < words.size(); ++w) words[w] = wordOfRows(rows, w);
    return words;
}

TEST(RowWeights, EveryRunHasTheSameMass)
{
    RowWeights weights(130);
    Words column(3), known = allRows(130);
    for (uint32_t i = 0; i < 130; ++i)
        if (i < 60 || i == 100) setBit(column, i);  // runs of 60, 40, 1 and 29 rows
    weights.addRuns(column, known);
    const auto at = [&](uint32_t i) { return weights.weights()[i]; };
    EXPECT_NEAR(at(0), 1.0 / 130 + 0.25 / 60, 1e-15);
    EXPECT_NEAR(at(59), 1.0 / 130 + 0.25 / 60, 1e-15);
    EXPECT_NEAR(at(60), 1.0 / 130 + 0.25 / 40, 1e-15);
    EXPECT_NEAR(at(100), 1.0 / 130 + 0.25, 1e-15);
    EXPECT_NEAR(at(129), 1.0 / 130 + 0.25 / 29, 1e-15);

    // Unknown rows neither divide runs nor gain; a constant column raises all the same.
    RowWeights gaps(100);
    Words constant(2), even(2);
    for (uint32_t i = 0; i < 100; i += 2) setBit(even, i);
    gaps.addRuns(constant, even);
    EXPECT_NEAR(gaps.weights()[42], 0.01 + 0.02, 1e-15);
    EXPECT_NEAR(gaps.weights()[43], 0.01, 1e-15);
    gaps.addRuns(constant, Words(2));
    EXPECT_NEAR(gaps.weights()[42], 0.03, 1e-15);
}

/// How often each set of rows was drawn, by its word.
using Counts = std::map<uint64_t, double>;

void addRunsAt(RowWeights& weights, uint64_t column)
{
    weights.addRuns(Words{column}, allRows(weights.rows()));
}

/// The rows of the `count` least -ln(u) / w: P. Efraimidis, P. Spirakis, "Weighted Random Sampling
/// with a Reservoir" (2006).
uint64_t drawByKeys(std::span<const double> weights, uint32_t count, Pcg32& random)
{
    std::vector<std::pair<double, uint32_t>> keys;
    for (uint32_t i = 0; i < weights.size(); ++i)
        keys.emplace_back(-std::log(1 - random()) / weights[i], i);
    std::ranges::sort(keys);
    uint64_t rows = 0;
    for (uint32_t k = 0; k < count; ++k) rows |= uint64_t(1) << keys[k].second;
    return rows;
}

/// Probability of a set under successive draws without replacement, over all orders.
double setProbability(std::span<const double> weights, uint64_t rows, double taken = 0)
{
    if (rows == 0) return 1;
    double total = 0, p = 0;
    for (const double w : weights) total += w;
    for (uint64_t rest = rows; rest != 0; rest &= rest - 1) {
        const auto i = static_cast<size_t>(std::countr_zero(rest));
        const uint64_t others = rows & ~(uint64_t(1) << i);
        p += weights[i] / (total - taken) * setProbability(weights, others, taken + weights[i]);
    }
    return p;
}

/// Chi-square of the sets that `draw(random)` gives against exact probabilities.
double setTest(std::span<const double> weights, uint32_t count, const auto& draw)
{
    constexpr int kTrials = 100000;
    Pcg32 random(5);
    Counts counts;
    for (int t = 0; t < kTrials; ++t) counts[draw(random)] += 1;
    std::vector<double> observed, expected;
    for (uint64_t rows = 0; rows < uint64_t(1) << weights.size(); ++rows) {
        if (std::popcount(rows) != static_cast<int>(count)) {
            EXPECT_EQ(counts.count(rows), 0u) << rows;
            continue;
        }
        observed.push_back(counts[rows]);
        expected.push_back(kTrials * setProbability(weights, rows));
    }
    return tests::chiSquareTest(observed, expected).p;
}

// A set of weight 10 among 1 distorted by a tenth is seen: the last check draws with a fault.
TEST(RowWeights, DrawsWithoutReplacementHaveTheDistributionOfKeys)
{
    for (const uint32_t count : {1u, 3u, 6u}) {
        RowWeights weights(8);
        addRunsAt(weights, 0b00010000);
        addRunsAt(weights, 0b01110000);
        const auto draw = [&](Pcg32& random) {
            Words drawn(1);
            weights.draw(count, allRows(8), random, drawn);
            return drawn[0];
        };
        const auto keys = [&](Pcg32& random) {
            return drawByKeys(weights.weights(), count, random);
        };
        EXPECT_GT(setTest(weights.weights(), count, draw), tests::kLevel) << count;
        EXPECT_GT(setTest(weights.weights(), count, keys), tests::kLevel) << count;
    }
    RowWeights weights(8);
    addRunsAt(weights, 0b00010000);
    std::vector<double> faulty(weights.weights().begin(), weights.weights().end());
    faulty[4] *= 1.1;
    const auto wrong = [&](Pcg32& random) { return drawByKeys(faulty, 3, random); };
    EXPECT_LT(setTest(weights.weights(), 3, wrong), tests::kLevel);
}

// Where few rows have nearly all the weight, rejection gives up and keys go on.
TEST(RowWeights, SkewedWeightsAreDrawnRightly)
{
    RowWeights weights(6);
    for (int k = 0; k < 3000; ++k) addRunsAt(weights, 0b000110);
    std::vector<double> skewed(weights.weights().begin(), weights.weights().end());
    const auto draw = [&](Pcg32& random) {
        Words drawn(1);
        weights.draw(5, allRows(6), random, drawn);
        return drawn[0];
    };
    EXPECT_GT(setTest(skewed, 5, draw), tests::kLevel);
}

TEST(RowWeights, OnlyEligibleRowsAreDrawn)
{
    RowWeights weights(200);
    Pcg32 random(3);
    Words eligible(wordsFor(200));
    for (uint32_t i = 0; i < 200; i += 3) setBit(eligible, i);
    for (const uint32_t count : {1u, 20u, 66u, 67u, 500u}) {
        for (const bool uniform : {false, true}) {
            Words drawn(eligible.size());
            double probability = 0;
            if (uniform)
                probability = drawUniform(count, eligible, random, drawn);
            else
                weights.draw(count, eligible, random, drawn);
            EXPECT_EQ(countBits(drawn), std::min(count, 67u));
            for (size_t w = 0; w < drawn.size(); ++w) EXPECT_EQ(drawn[w] & ~eligible[w], 0u);
            if (uniform) {
                EXPECT_NEAR(probability, std::min(count / 67.0, 1.0), 1e-15);
            }
        }
    }
    Words drawn(eligible.size());
    weights.drawWithReplacement(30, eligible, random, drawn);
    EXPECT_LE(countBits(drawn), 30u);
    EXPECT_GE(countBits(drawn), 15u);
    Words none(eligible.size());
    weights.draw(5, Words(eligible.size()), random, none);
    weights.drawWithReplacement(5, Words(eligible.size()), random, none);
    EXPECT_EQ(countBits(none), 0u);
}

// n draws with replacement leave (1 - 1/n)^n = 0.366 of n rows out.
TEST(RowWeights, ReplacementWastesDraws)
{
    RowWeights weights(1000);
    Pcg32 random(4);
    tests::Moments distinct;
    for (int t = 0; t < 200; ++t) {
        Words drawn(wordsFor(1000));
        weights.drawWithReplacement(100, allRows(1000), random, drawn);
        distinct.add(countBits(drawn));
    }
    EXPECT_NEAR(distinct.mean(), 1000 * (1 - std::pow(1 - 1.0 / 1000, 100)),
                tests::kScore * std::sqrt(distinct.varianceOfMean()));
    EXPECT_LT(tests::kScore * std::sqrt(distinct.varianceOfMean()), 1);
}

TEST(RowWeights, UniformDrawsAreUniform)
{
    for (const uint32_t count : {2u, 5u}) {  // by rejection and in one pass
        const std::vector<double> equal(8, 1.0);
        const auto draw = [&](Pcg32& random) {
            Words drawn(1);
            drawUniform(count, allRows(8), random, drawn);
            return drawn[0];
        };
        EXPECT_GT(setTest(equal, count, draw), tests::kLevel) << count;
    }
    Pcg32 random(9);
    std::vector<double> counts(60);
    for (int t = 0; t < 20000; ++t) {
        Words drawn(1);
        drawUniform(7, allRows(60), random, drawn);  // by rejection
        forEachBit(drawn, [&](uint32_t i) { counts[i] += 1; });
    }
    // Counts of draws without replacement vary less than a multinomial: the test is lenient.
    EXPECT_GT(tests::chiSquareTest(counts, std::vector<double>(60, 20000 * 7 / 60.0)).p,
              tests::kLevel);
}

}  // namespace
}  // namespace core::many_lights
