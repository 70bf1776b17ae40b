// Completion whatever its method: full sampling, empty slices, rows that do not matter, counts.
#include <vector>

#include <gtest/gtest.h>

#include "core/completion/completion.h"
#include "tests/support/methods/completion_runs.h"
#include "tests/support/methods/visibility_matrices.h"

namespace core::many_lights {
namespace {

using tests::fullSampling;
using tests::MatrixOracle;

TEST(BitMatrix, ColumnsAreWords)
{
    BitMatrix matrix(70, 3);
    EXPECT_EQ(matrix.wordsPerColumn(), 2u);
    matrix.set(69, 1, true);
    matrix.set(3, 2, true);
    EXPECT_EQ(matrix.column(1)[1], uint64_t(1) << 5);
    EXPECT_EQ(matrix.column(2)[0], 8u);
    EXPECT_TRUE(matrix.get(69, 1));
    EXPECT_FALSE(matrix.get(69, 0));
    matrix.set(69, 1, false);
    EXPECT_EQ(matrix.column(1)[1], 0u);
    matrix.reset(64, 2);
    EXPECT_EQ(matrix, BitMatrix(64, 2));
    EXPECT_EQ(BitMatrix(0, 5).wordsPerColumn(), 0u);
}

TEST(Completion, MethodsGoByTheirNames)
{
    using core::enumName;
    EXPECT_EQ(enumName(CompletionMethod::full), "full");
    EXPECT_EQ(enumName(CompletionMethod::matching), "matching");
    EXPECT_EQ(enumName(CompletionMethod::gaussJordan), "gauss-jordan");
    EXPECT_EQ(enumName(CompletionMethod::amc), "amc");
    EXPECT_EQ(enumName(CompletionMethod::svt), "svt");
    EXPECT_EQ(enumName(OnMismatch::recursion), "recursion");
    EXPECT_EQ(enumName(Coefficients::clamped), "clamped");
}

TEST(Completion, FullSamplingTracesEverythingOnce)
{
    Pcg32 random(1);
    const BitMatrix truth = tests::randomMatrix(300, 40, 0.6, random);
    MatrixOracle oracle(truth);
    CompletedSlice slice;
    const std::vector<ColumnRange> octants{{0, 10}, {10, 10}, {10, 40}};
    complete(oracle, 300, octants, fullSampling(), 1, slice);
    EXPECT_EQ(slice.visible, truth);
    EXPECT_EQ(slice.stats.rays, 300u * 40);
    EXPECT_EQ(slice.stats.rays, oracle.rays());
    EXPECT_EQ(slice.stats.active, slice.stats.entries);
    EXPECT_EQ(slice.stats.full, 40u);
    EXPECT_EQ(slice.stats.visibility(), 1);
}

TEST(Completion, RowsThatDoNotMatterAreNotTraced)
{
    Pcg32 random(2);
    const BitMatrix truth = tests::randomMatrix(200, 30, 0.6, random);
    BitMatrix matters = tests::facingMask(200, 30, 0.4, random);
    for (uint64_t& word : matters.column(7)) word = 0;
    MatrixOracle oracle(truth, matters);
    CompletedSlice slice;
    const std::vector<ColumnRange> octants{{0, 30}};
    complete(oracle, 200, octants, fullSampling(), 1, slice);
    EXPECT_EQ(oracle.asked(), matters);
    EXPECT_EQ(slice.stats.active, 29u * 80);
    EXPECT_EQ(slice.stats.rays, 29u * 80);
    EXPECT_EQ(slice.stats.inactive, 1u);
    EXPECT_EQ(tests::bitError(truth, slice.visible, &matters), 0);

    MatrixOracle all(truth);
    CompletionParams params = fullSampling();
    params.dontCare = false;
    complete(all, 200, octants, params, 1, slice);
    EXPECT_EQ(slice.visible, truth);
}

TEST(Completion, EmptySlicesTakeNoRays)
{
    const BitMatrix none;
    MatrixOracle oracle(none);
    CompletedSlice slice;
    complete(oracle, 0, {}, {}, 1, slice);
    EXPECT_EQ(slice.visible.columns(), 0u);
    const std::vector<ColumnRange> octants{{0, 5}};
    complete(oracle, 0, octants, fullSampling(), 1, slice);
    EXPECT_EQ(slice.visible.columns(), 5u);
    complete(oracle, 100, std::vector<ColumnRange>{{0, 0}}, {}, 1, slice);
    EXPECT_EQ(slice.stats.rays, 0u);
    EXPECT_EQ(oracle.calls(), 0u);
}

TEST(Completion, SlicesTracedInFullHaveNoRate)
{
    Pcg32 random(3);
    const BitMatrix large = tests::dictionaryMatrix(400, 50, 5, random),
                    small = tests::dictionaryMatrix(60, 50, 5, random);
    CompletionStats sum;
    for (const BitMatrix* truth : {&large, &small}) {
        MatrixOracle oracle(*truth);
        CompletedSlice slice;
        complete(oracle, truth->rows(), std::vector<ColumnRange>{{0, 50}}, {}, 1, slice);
        sum += slice.stats;
    }
    EXPECT_EQ(sum.columns, 100u);
    EXPECT_NEAR(sum.meanRate(), 0.025, 1e-7);
    EXPECT_EQ(CompletionStats{}.meanRate(), 0);
}

/// A picture of many frames has more columns than 32 bits count.
TEST(Completion, SumsOfStatisticsHaveRoom)
{
    CompletionStats sum, half;
    half.columns = half.inactive = half.full = half.bailedOut = half.matched = half.repaired =
        half.basis = half.ambiguous = half.verificationFailures = half.rated = 3'000'000'000;
    half.rates = 0.5 * 3e9;
    sum += half;
    sum += half;
    for (const uint64_t found :
         {sum.columns, sum.inactive, sum.full, sum.bailedOut, sum.matched, sum.repaired, sum.basis,
          sum.ambiguous, sum.verificationFailures, sum.rated})
        EXPECT_EQ(found, 6'000'000'000u);
    EXPECT_DOUBLE_EQ(sum.meanRate(), 0.5);
}

}  // namespace
}  // namespace core::many_lights
