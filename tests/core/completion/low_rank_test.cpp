// M7. Recovery of matrices of low rank, with the numbers of entries and the errors of the papers.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/completion/low_rank.h"
#include "core/completion/matrix_separation.h"
#include "tests/support/methods/completion_runs.h"

namespace core::many_lights {
namespace {

Matrix normalMatrix(size_t rows, size_t columns, Pcg32& random)
{
    Matrix a(rows, columns);
    for (double& x : a.values())  // nearly normal: the sum of twelve uniform numbers
        for (int k = 0; k < 12; ++k) x += random() - 0.5;
    return a;
}

Matrix difference(const Matrix& a, const Matrix& b)
{
    Matrix c = a;
    for (size_t k = 0; k < c.values().size(); ++k) c.values()[k] -= b.values()[k];
    return c;
}

double relativeError(const Matrix& found, const Matrix& truth)
{
    return frobeniusNorm(difference(found, truth)) / frobeniusNorm(truth);
}

TEST(LowRank, RandomizedSvdIsNearlyAsGoodAsTheBest)
{
    Pcg32 random(1);
    Matrix a = product(normalMatrix(150, 40, random), normalMatrix(40, 120, random));
    for (size_t k = 0; k < 40; ++k)  // a tail that falls slowly
        for (double& x : a.column(k)) x += random();
    const Svd exact = svd(a), nearly = randomizedSvd(a, 20, random);
    double tail = 0;
    for (size_t k = 20; k < exact.s.size(); ++k) tail += exact.s[k] * exact.s[k];
    Matrix best(150, 120);
    for (size_t k = 0; k < 20; ++k)
        for (size_t j = 0; j < 120; ++j)
            for (size_t i = 0; i < 150; ++i)
                best(i, j) += nearly.s[k] * nearly.u(i, k) * nearly.v(j, k);
    EXPECT_LT(frobeniusNorm(difference(a, best)), 1.1 * std::sqrt(tail));
    EXPECT_GT(frobeniusNorm(difference(a, best)), 0.999 * std::sqrt(tail));
    const double least = 0.5 * (exact.s[29] + exact.s[30]);
    const Svd above = singularValuesAbove(a, least, 3, random);
    EXPECT_EQ(std::ranges::count_if(above.s, [&](double s) { return s > least; }), 30);
}

TEST(LowRank, RankTenIsCompletedFromTwoFifthsOfTheEntries)
{
    Pcg32 random(2);
    const Matrix truth = product(normalMatrix(200, 10, random), normalMatrix(10, 200, random));
    BitMatrix known(200, 200);
    Matrix values = truth;
    for (uint32_t j = 0; j < 200; ++j)
        for (uint32_t i = 0; i < 200; ++i) {
            known.set(i, j, random() < 0.4);
            if (!known.get(i, j)) values(i, j) = 1e6;  // must not be read
        }
    const LowRank low = completeLowRank(values, known, {}, random);
    EXPECT_EQ(low.rank, 10u);
    EXPECT_LT(low.residual, 1e-4);
    EXPECT_LT(relativeError(low.matrix, truth), 1e-3);
    // From fewer entries than rank 10 has degrees of freedom (3900) nothing can recover it.
    BitMatrix few(200, 200);
    for (uint32_t j = 0; j < 200; ++j)
        for (uint32_t i = 0; i < 200; ++i) few.set(i, j, random() < 0.07);
    SvtSettings settings;
    settings.iterations = 20;
    EXPECT_GT(relativeError(completeLowRank(values, few, settings, random).matrix, truth), 0.1);
    EXPECT_EQ(completeLowRank(values, BitMatrix(200, 200), {}, random).rank, 0u);
}

/// One entry in twenty is off by 1; `count` gets how many.
Matrix corruptedFrom(Matrix a, size_t& count, Pcg32& random)
{
    for (double& x : a.values()) {
        if (!(random() < 0.05)) continue;
        x += random() < 0.5 ? 1 : -1;
        ++count;
    }
    return a;
}

// At the right rank; without corruption from one that is too low, too.
TEST(LowRank, FactorsSeparateSparseCorruption)
{
    Pcg32 random(5);
    const Matrix truth = product(normalMatrix(200, 10, random), normalMatrix(10, 250, random));
    size_t count = 0;
    const Matrix corrupted = corruptedFrom(truth, count, random);
    FactorSettings settings;
    settings.rank = 10;
    settings.iterations = 400;
    settings.tolerance = 1e-5;
    const Separation parts = separateByFactors(corrupted, settings, random);
    EXPECT_EQ(parts.low.rank, 10u);
    EXPECT_LT(parts.low.residual, settings.tolerance);
    EXPECT_LT(relativeError(parts.low.matrix, truth), 1e-3);
    const auto wrong =
        std::ranges::count_if(parts.sparse.values(), [](double x) { return std::abs(x) > 0.5; });
    EXPECT_EQ(static_cast<size_t>(wrong), count);
    settings = {};
    settings.rank = 3;
    const Separation grown = separateByFactors(truth, settings, random);
    EXPECT_GE(grown.low.rank, 10u);
    EXPECT_LT(grown.low.residual, settings.tolerance);
    EXPECT_LT(relativeError(grown.low.matrix, truth), 0.02);
    EXPECT_EQ(frobeniusNorm(separateByFactors(Matrix(5, 7), {}, random).low.matrix), 0);
    std::stop_source stop;
    stop.request_stop();
    EXPECT_EQ(separateByFactors(corrupted, {}, random, stop.get_token()).low.iterations, 0u);
}

// Five directions of 400 rows and 160 columns have 2775 degrees of freedom: 24000 entries suffice
// where 3200 do not.
TEST(Svt, RecoversVisibilityOfLowRankFromEnoughRows)
{
    Pcg32 random(4);
    const BitMatrix truth = tests::dictionaryMatrix(400, 160, 5, random);
    CompletionParams params;
    params.method = CompletionMethod::svt;
    params.rowMinimum = 1;
    params.svtIterations = 60;
    params.rowRate = 0.05f;
    const CompletedSlice poor = tests::completed(truth, params);
    EXPECT_EQ(poor.stats.rays, 160u * 20);
    EXPECT_GT(tests::bitError(truth, poor.visible), 0.01);
    params.rowRate = 0.375f;
    const CompletedSlice slice = tests::completed(truth, params);
    EXPECT_EQ(slice.stats.rays, 160u * 150);
    EXPECT_EQ(slice.visible, truth);
    EXPECT_EQ(slice.stats.basis, 5u);
    double squares = 0;
    ASSERT_EQ(slice.coefficients.size(), 400u * 160);
    for (uint32_t j = 0; j < 160; ++j)
        for (uint32_t i = 0; i < 400; ++i) {
            const double error =
                double(slice.coefficients[400 * j + i]) - (truth.get(i, j) ? 1 : 0);
            squares += error * error;
        }
    EXPECT_LT(std::sqrt(squares / (400 * 160)), 0.02);
    params.coefficients = Coefficients::bits;
    EXPECT_TRUE(tests::completed(truth, params).coefficients.empty());
}

/// Nine of ten columns are lit everywhere, the others are shadows of edges: with 24 known rows of
/// 650 a step of 32 makes numbers without bounds.
TEST(Svt, DoesNotDivergeAtItsOwnStep)
{
    Pcg32 random(3);
    BitMatrix truth(650, 120);
    for (uint32_t j = 0; j < 120; ++j) {
        const double edge = random() < 0.9 ? -1 : random() * 650;
        for (uint32_t i = 0; i < 650; ++i) truth.set(i, j, i > edge);
    }
    CompletionParams params;
    params.method = CompletionMethod::svt;
    const CompletedSlice slice = tests::completed(truth, params);
    EXPECT_LT(tests::bitError(truth, slice.visible), 0.1);
    for (const float x : slice.coefficients) ASSERT_LT(std::abs(x), 3);
}

TEST(Svt, AStopEndsTheIterations)
{
    Pcg32 random(6);
    const BitMatrix truth = tests::dictionaryMatrix(200, 50, 4, random);
    Matrix values(200, 50);
    BitMatrix known(200, 50);
    for (uint32_t j = 0; j < 50; ++j)
        for (uint32_t i = 0; i < 200; ++i) {
            values(i, j) = truth.get(i, j) ? 1 : -1;
            known.set(i, j, true);
        }
    std::stop_source stop;
    stop.request_stop();
    const LowRank low = completeLowRank(values, known, {}, random, stop.get_token());
    EXPECT_EQ(low.iterations, 0u);
    EXPECT_EQ(low.matrix.rows(), 200u);
    EXPECT_EQ(low.matrix.columns(), 50u);
    CompletionParams params;
    params.method = CompletionMethod::svt;
    tests::MatrixOracle oracle(truth);
    CompletedSlice slice;
    complete(oracle, 200, std::vector<ColumnRange>{{0, 50}}, params, 1, slice, stop.get_token());
    EXPECT_EQ(slice.stats.basis, 0u);
    EXPECT_GT(tests::completed(truth, params).stats.basis, 0u);
}

TEST(Svt, ColumnsThatAreTracedInFullCountAsSuch)
{
    Pcg32 random(7);
    const BitMatrix truth = tests::dictionaryMatrix(100, 30, 4, random);
    CompletionParams params;
    params.method = CompletionMethod::svt;
    params.rowRate = 1;
    const CompletedSlice slice = tests::completed(truth, params);
    EXPECT_EQ(slice.visible, truth);
    EXPECT_EQ(slice.stats.full, 30u);
    EXPECT_EQ(slice.stats.matched, 0u);
    params.rowRate = 0.5f;
    EXPECT_EQ(tests::completed(truth, params).stats.matched, 30u);
}

}  // namespace
}  // namespace core::many_lights
