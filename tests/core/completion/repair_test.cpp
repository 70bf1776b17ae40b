// M6. What mends predictions: patches at the borders of shadows, and the residual, which corrects
// their mean.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/completion/bits.h"
#include "tests/support/methods/completion_runs.h"
#include "tests/support/statistics/stats.h"

namespace core::many_lights {
namespace {

using tests::MatrixOracle;
using tests::Mean;
using tests::meanOf;

// --- repair

TEST(Repair, MendsTheBordersOfShadows)
{
    const auto edges = [](Pcg32& random) { return tests::edgesMatrix(1000, 1000, random); };
    const auto room = [](Pcg32& random) {
        return tests::spheresMatrix(32, 1000, 2, 0.05, 0.03, random);
    };
    CompletionParams params = tests::wholeColumns(), repair, recursion;
    params.bailOut = repair.bailOut = recursion.bailOut = 1;
    recursion.onMismatch = OnMismatch::recursion;
    const Mean plain = meanOf(params, edges), mended = meanOf(repair, edges);
    EXPECT_LT(mended.error, 0.05 * plain.error);
    EXPECT_LT(mended.rays, 0.8 * plain.rays);
    const Mean plainRoom = meanOf(params, room), mendedRoom = meanOf(repair, room);
    EXPECT_LT(mendedRoom.error, 0.5 * plainRoom.error);
    EXPECT_LT(mendedRoom.rays, 1.05 * plainRoom.rays);  // probes cost what borders save
    // Recursion saves rays and multiplies the error.
    const Mean recursed = meanOf(recursion, room);
    EXPECT_LT(recursed.rays, plainRoom.rays);
    EXPECT_GT(recursed.error, 5 * plainRoom.error);
}

/// Column 0 knows nothing of the last rows, in which the others are lit.
TEST(Repair, RowsTheCandidateDoesNotKnowAreTraced)
{
    constexpr uint32_t kRows = 1000, kColumns = 20;
    BitMatrix truth(kRows, kColumns), matters(kRows, kColumns);
    for (uint32_t j = 0; j < kColumns; ++j)
        for (uint32_t i = 0; i < kRows; ++i) {
            matters.set(i, j, j == 0 ? i < 700 : i >= 300);
            truth.set(i, j, matters.get(i, j) && (i < 350 + 8 * j || i >= 700));
        }
    CompletionParams params;
    params.bailOut = 1;
    uint64_t repaired = 0;
    for (uint64_t seed = 0; seed < 50; ++seed) {
        MatrixOracle oracle(truth, matters);
        CompletedSlice slice;
        complete(oracle, kRows, std::vector<ColumnRange>{{0, kColumns}}, params, seed, slice);
        repaired += slice.stats.repaired;
        for (uint32_t j = 1; j < kColumns; ++j)
            for (uint32_t i = 700; i < kRows; ++i)
                ASSERT_TRUE(slice.visible.get(i, j)) << "seed " << seed << ", column " << j;
    }
    EXPECT_GT(repaired, 0u);
}

/// A match that repair finds to differ is a column of its own.
TEST(Repair, ColumnsThatAgreeWithNoneAreNotMatched)
{
    Pcg32 random(9);
    const BitMatrix truth = tests::edgesMatrix(1000, 300, random);
    CompletionParams params;
    params.bailOut = 1;
    const CompletedSlice slice = tests::completed(truth, params);
    EXPECT_GT(slice.stats.repaired, 0u);
    EXPECT_LE(tests::distinctColumns(slice.visible), slice.stats.full + slice.stats.repaired);
}

/// Of 200 seeds: how often column 1 of two was traced in full after its samples had matched none,
/// how often it was repaired, and how often wrongly; and how often both columns are as they should.
struct Repaired {
    uint64_t full = 0, repaired = 0, wrong = 0, exact = 0;
};

/// Brightness of column 1 at which no patch is probed, and each.
constexpr float kUnprobed = 1e-6f, kProbedEverywhere = 2;

Repaired repairedOf(const BitMatrix& truth, CompletionParams params, float brightness)
{
    params.bailOut = 1;
    params.rowsByLight = false;
    Repaired result;
    for (uint64_t seed = 0; seed < 200; ++seed) {
        tests::BrightOracle oracle(truth, brightness);
        CompletedSlice slice;
        complete(oracle, truth.rows(), std::vector<ColumnRange>{{0, 2}}, params, seed, slice);
        result.full += slice.stats.full == 2;
        result.repaired += slice.stats.repaired;
        result.wrong += slice.stats.repaired > 0 && slice.visible != truth;
        result.exact += slice.visible == truth;
    }
    return result;
}

/// Shadows that no known border leads to: what has not been traced is as wrong as what has.
TEST(Repair, WrongRowsAwayFromBordersMeanThatAllIsTraced)
{
    constexpr uint32_t kRows = 1000;
    BitMatrix truth(kRows, 2);
    for (uint32_t i = 0; i < kRows; ++i) {
        truth.set(i, 0, true);
        truth.set(i, 1, i % 100 != 50);
    }
    CompletionParams params;
    params.stray = 0.01f;
    const Repaired strict = repairedOf(truth, params, 1);
    EXPECT_GT(strict.full, 20u);
    EXPECT_EQ(strict.repaired, 0u);
    EXPECT_EQ(strict.exact, strict.full);
    params.stray = 1;
    const Repaired lax = repairedOf(truth, params, kUnprobed);
    EXPECT_EQ(lax.full, 0u);
    EXPECT_EQ(lax.repaired, strict.full);
    EXPECT_EQ(lax.wrong, lax.repaired);
    // Where the second probes find some still, there is more.
    const Repaired probed = repairedOf(truth, params, kProbedEverywhere);
    EXPECT_GT(probed.full, probed.repaired / 10);
}

/// A shadow that nothing leads to, two patches of it; another one tells that the columns differ.
TEST(Repair, ProbesFindShadowsThatNoBorderLeadsTo)
{
    constexpr uint32_t kRows = 1000;
    BitMatrix truth(kRows, 2);
    for (uint32_t i = 0; i < kRows; ++i) {
        truth.set(i, 0, true);
        truth.set(i, 1, !(i >= 300 && i < 360) && !(i >= 800 && i < 832));
    }
    CompletionParams params;
    params.stray = 1;
    const Repaired unprobed = repairedOf(truth, params, kUnprobed);
    EXPECT_GT(unprobed.wrong, 20u);
    const Repaired probed = repairedOf(truth, params, kProbedEverywhere);
    EXPECT_GT(probed.repaired, 150u);
    EXPECT_LT(probed.full, 10u);  // where the samples differ too much
    EXPECT_EQ(probed.wrong, 0u);
}

/// A match whose borders are everywhere is taken as it is.
TEST(Repair, PatternsWithoutPlacesAreMatched)
{
    Pcg32 random(4);
    const BitMatrix truth = tests::dictionaryMatrix(1000, 200, 5, random);
    const CompletedSlice whole = tests::completed(truth, tests::wholeColumns());
    const CompletedSlice repaired = tests::completed(truth, {});
    EXPECT_EQ(repaired.visible, truth);
    EXPECT_EQ(repaired.stats.rays, whole.stats.rays);
}

/// A border lies a few rows from a known one. Of bright columns it is always found, also where all
/// samples agree with the known one; of a dim one only where they do not.
TEST(Repair, MatchesOfDimColumnsAreNotTracedAtTheBordersOfShadows)
{
    constexpr uint32_t kRows = 1000;
    BitMatrix truth(kRows, 2);
    for (uint32_t i = 0; i < kRows; ++i) {
        truth.set(i, 0, i < 500);
        truth.set(i, 1, i < 504);
    }
    CompletionParams params;
    params.adaptiveRows = false;
    const Repaired bright = repairedOf(truth, params, 1);
    EXPECT_EQ(bright.exact, 200u);
    EXPECT_EQ(bright.repaired, 200u);
    const Repaired dim = repairedOf(truth, params, 0.99f);
    EXPECT_EQ(dim.exact, dim.repaired);
    EXPECT_GT(dim.repaired, 10u);
    EXPECT_LT(dim.repaired, 100u);
}

// --- the residual

/// Sum over rows and columns of weight x bit, predicted and corrected.
struct Weighing {
    std::vector<float> weights;
    double exact = 0;
};

TEST(Residual, CorrectsTheMeanOfWhatIsPredicted)
{
    Pcg32 random(21);
    constexpr uint32_t kRows = 300, kColumns = 60, kWeighings = 6;
    const BitMatrix truth = tests::edgesMatrix(kRows, kColumns, random);
    std::vector<Weighing> weighings(kWeighings);
    for (uint32_t k = 0; k < kWeighings; ++k)  // of the whole, and of a few rows
        for (uint32_t j = 0; j < kColumns; ++j)
            for (uint32_t i = 0; i < kRows; ++i) {
                const bool inside = k < 3 || i % kWeighings == k;
                const auto weight = inside ? static_cast<float>(random()) : 0.0f;
                weighings[k].weights.push_back(weight);
                if (truth.get(i, j)) weighings[k].exact += double(weight);
            }
    for (const OnMismatch onMismatch : {OnMismatch::full, OnMismatch::repair}) {
        CompletionParams params;
        params.residualRate = 0.05f;
        params.rowMinimum = 8;
        params.bailOut = 1;
        params.onMismatch = onMismatch;
        std::vector<tests::Moments> predicted(kWeighings), corrected(kWeighings);
        for (uint64_t seed = 0; seed < 6000; ++seed) {
            MatrixOracle oracle(truth);
            CompletedSlice slice;
            complete(oracle, kRows, std::vector<ColumnRange>{{0, 60}}, params, seed, slice);
            for (uint32_t k = 0; k < kWeighings; ++k) {
                const auto& weights = weighings[k].weights;
                double sum = 0;
                for (uint32_t j = 0; j < kColumns; ++j)
                    forEachBit(slice.visible.column(j),
                               [&](uint32_t i) { sum += double(weights[j * kRows + i]); });
                predicted[k].add(sum - weighings[k].exact);
                for (const ResidualEntry& entry : slice.residual)
                    sum += double(entry.weight) * double(weights[entry.column * kRows + entry.row]);
                corrected[k].add(sum - weighings[k].exact);
            }
        }
        uint32_t biased = 0;
        for (uint32_t k = 0; k < kWeighings; ++k) {
            const double error = std::sqrt(corrected[k].varianceOfMean());
            EXPECT_NEAR(corrected[k].mean(), 0, tests::kScore * error) << k;
            const double plain = std::sqrt(predicted[k].varianceOfMean());
            biased += std::abs(predicted[k].mean()) > tests::kScore * plain;
        }
        if (onMismatch == OnMismatch::full) {
            EXPECT_GE(biased, 1u) << "no bias to be corrected";
        }
    }
}

}  // namespace
}  // namespace core::many_lights
