// M5, M6. Completion by linear combinations: elimination over GF(2), adaptive matrix completion,
// and the linear algebra under them.
#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "core/completion/dense.h"
#include "core/completion/gauss_jordan.h"
#include "tests/support/methods/completion_runs.h"
#include "tests/support/methods/visibility_matrices.h"
#include "tests/support/statistics/stats.h"

namespace core::many_lights {
namespace {

using tests::completed;
using tests::Mean;
using tests::meanOf;
using tests::tenColumns;

CompletionParams linear(CompletionMethod method, float rate, bool guard = false)
{
    CompletionParams params = tests::fixedRate(rate);
    params.method = method;
    params.guard = guard;
    return params;
}

BitMatrix hundredColumnsThreeTimes(Pcg32& random)
{
    return tests::dictionaryMatrix(1000, 300, 100, random);
}

// --- GF(2)

using BitColumn = std::vector<bool>;

BitColumn unpacked(std::span<const uint64_t> words, uint32_t rows)
{
    BitColumn column(rows);
    for (uint32_t i = 0; i < rows; ++i) column[i] = getBit(words, i);
    return column;
}

void addTo(BitColumn& to, const BitColumn& column)
{
    for (size_t i = 0; i < to.size(); ++i) to[i] = to[i] != column[i];
}

/// All columns at once, in reduced row-echelon form.
std::vector<BitColumn> eliminated(std::vector<BitColumn> columns)
{
    size_t done = 0;
    for (size_t row = 0; !columns.empty() && row < columns[0].size(); ++row) {
        size_t with = done;
        while (with < columns.size() && !columns[with][row]) ++with;
        if (with == columns.size()) continue;
        std::swap(columns[done], columns[with]);
        for (size_t k = 0; k < columns.size(); ++k)
            if (k != done && columns[k][row]) addTo(columns[k], columns[done]);
        ++done;
    }
    columns.resize(done);
    return columns;
}

TEST(GaussJordan, GrowsToWhatEliminationOfAllColumnsGives)
{
    Pcg32 random(1);
    for (const uint32_t rows : {5u, 64u, 150u})
        for (const uint32_t rank : {1u, 4u, 30u}) {
            const BitMatrix truth = tests::sumsMatrix(rows, 40, rank, random);
            EchelonBasis basis(rows);
            std::vector<BitColumn> columns;
            for (uint32_t j = 0; j < 40; ++j) {
                columns.push_back(unpacked(truth.column(j), rows));
                const uint32_t before = basis.size();
                const bool grew = basis.insert(truth.column(j));
                EXPECT_EQ(basis.size(), before + (grew ? 1u : 0u));
                const std::vector<BitColumn> plain = eliminated(columns);
                std::set<BitColumn> expected(plain.begin(), plain.end()), found;
                for (uint32_t k = 0; k < basis.size(); ++k) {
                    found.insert(unpacked(basis.column(k), rows));
                    EXPECT_TRUE(getBit(basis.column(k), basis.pivot(k)));
                }
                ASSERT_EQ(found, expected);
            }
            Words all(truth.wordsPerColumn()), sum(all.size());
            for (size_t w = 0; w < all.size(); ++w) all[w] = wordOfRows(rows, w);
            for (uint32_t j = 0; j < 40; ++j) {
                basis.combine(truth.column(j), all, sum);
                EXPECT_TRUE(std::ranges::equal(sum, truth.column(j))) << "not in the span";
            }
        }
}

/// The thesis's loop with elimination from scratch; draws as completion makes them.
struct PlainElimination {
    std::vector<BitColumn> columns;
    uint64_t rays = 0;
    size_t rank = 0;
};

PlainElimination plainElimination(const BitMatrix& truth, const CompletionParams& params,
                                  uint64_t seed)
{
    const uint32_t n = truth.rows();
    Pcg32 random(octantSeed(seed, 0));
    RowWeights weights(n);
    Words all(wordsFor(n));
    for (size_t w = 0; w < all.size(); ++w) all[w] = wordOfRows(n, w);
    PlainElimination result;
    std::vector<BitColumn> known;
    const auto m = static_cast<uint32_t>(std::lround(double(params.rowRate) * n));
    const auto v = static_cast<uint32_t>(std::lround(double(params.verificationRate) * n));
    double alpha = double(params.rowRate);
    for (uint32_t j = 0; j < truth.columns(); ++j) {
        const BitColumn column = unpacked(truth.column(j), n);
        const std::vector<BitColumn> basis = eliminated(known);
        const auto full = [&](uint32_t traced) {
            result.rays += n - traced;
            known.push_back(column);
            weights.addRuns(truth.column(j), all);
            result.columns.push_back(column);
        };
        if (basis.empty()) {
            full(0);
            continue;
        }
        const auto count = static_cast<uint32_t>(std::lround(alpha * n));
        std::vector<uint32_t> pivots;
        Words pivotRows(all.size()), others(all.size()), rows(all.size()), rest(all.size());
        for (const BitColumn& b : basis) {
            pivots.push_back(static_cast<uint32_t>(std::ranges::find(b, true) - b.begin()));
            setBit(pivotRows, pivots.back());
        }
        const uint32_t leading =
            std::min<uint32_t>(uint32_t(basis.size()), std::max(1u, count / 2));
        drawUniform(leading, pivotRows, random, rows);
        for (size_t w = 0; w < all.size(); ++w) others[w] = all[w] & ~pivotRows[w];
        weights.drawWithReplacement(count - leading, others, random, rest);
        for (size_t w = 0; w < all.size(); ++w) rows[w] |= rest[w];
        uint32_t traced = countBits(rows);
        result.rays += traced;
        BitColumn sum(n);
        for (size_t k = 0; k < basis.size(); ++k)
            if (getBit(rows, pivots[k]) && sum[pivots[k]] != column[pivots[k]])
                addTo(sum, basis[k]);
        bool right = true;
        forEachBit(rows, [&](uint32_t i) { right = right && sum[i] == column[i]; });
        if (right && v > 0) {
            Words left(all.size()), checks(all.size());
            for (size_t w = 0; w < all.size(); ++w) left[w] = all[w] & ~rows[w];
            drawUniform(v, left, random, checks);
            traced += countBits(checks);
            result.rays += countBits(checks);
            forEachBit(checks, [&](uint32_t i) { right = right && sum[i] == column[i]; });
            if (!right)
                alpha = std::min(double(params.rowCap), alpha + double(params.rowIncrement));
        }
        if (right)
            result.columns.push_back(sum);
        else
            full(traced);
    }
    EXPECT_GT(m, 0u);
    result.rank = eliminated(known).size();
    return result;
}

TEST(GaussJordan, IsTheThesissLoopBitByBit)
{
    Pcg32 random(2);
    std::vector<BitMatrix> matrices;
    matrices.push_back(tests::sumsMatrix(200, 60, 8, random));
    matrices.push_back(tests::edgesMatrix(200, 60, random));
    matrices.push_back(tests::dictionaryMatrix(200, 60, 30, random));
    for (const BitMatrix& truth : matrices)
        for (const float verification : {0.0f, 0.05f}) {
            CompletionParams params = linear(CompletionMethod::gaussJordan, 0.1f);
            params.verificationRate = verification;
            const CompletedSlice found = completed(truth, params, 5);
            const PlainElimination plain = plainElimination(truth, params, 5);
            for (uint32_t j = 0; j < truth.columns(); ++j)
                ASSERT_EQ(unpacked(found.visible.column(j), truth.rows()), plain.columns[j]) << j;
            EXPECT_EQ(found.stats.rays, plain.rays);
            EXPECT_EQ(found.stats.basis, plain.rank);
        }
}

TEST(GaussJordan, RaysFollowFromTheRank)
{
    const auto rank20 = [](Pcg32& random) { return tests::sumsMatrix(1000, 1000, 20, random); };
    const auto rank5 = [](Pcg32& random) { return tests::sumsMatrix(1000, 1000, 5, random); };
    struct {
        double expectedRays, basis;
        Mean mean;
    } const cases[] = {
        {10.6, 11, meanOf(linear(CompletionMethod::gaussJordan, 0.1f), tenColumns)},
        {11.5, 20, meanOf(linear(CompletionMethod::gaussJordan, 0.1f), rank20)},
        {20.1, 20, meanOf(linear(CompletionMethod::gaussJordan, 0.2f), rank20)},
        {10.1, 5, meanOf(linear(CompletionMethod::gaussJordan, 0.1f), rank5)},
    };
    for (const auto& c : cases) {
        EXPECT_NEAR(c.mean.rays, c.expectedRays, 0.03 * c.expectedRays);
        EXPECT_EQ(c.mean.basis, c.basis);
        EXPECT_EQ(c.mean.error, 0);
    }
    CompletionParams seeded = linear(CompletionMethod::gaussJordan, 0.1f);
    seeded.seedConstant = true;
    const Mean complements = meanOf(seeded, tenColumns);
    EXPECT_LT(complements.rays, cases[0].mean.rays) << "the constant column costs no ray";
    EXPECT_EQ(complements.basis, 11);
}

// Where not all pivots are sampled nearly every column fails; with the guard rows are added.
TEST(GaussJordan, TheGuardSamplesEveryPivot)
{
    const Mean without =
        meanOf(linear(CompletionMethod::gaussJordan, 0.1f), hundredColumnsThreeTimes);
    EXPECT_GT(without.rays, 95);
    EXPECT_EQ(without.basis, 101);
    const Mean with =
        meanOf(linear(CompletionMethod::gaussJordan, 0.1f, true), hundredColumnsThreeTimes);
    EXPECT_LT(with.rays, 55);
    EXPECT_EQ(with.error, 0);
}

// --- linear algebra

Matrix uniformMatrix(size_t rows, size_t columns, Pcg32& random)
{
    Matrix a(rows, columns);
    for (double& x : a.values()) x = 2 * random() - 1;
    return a;
}

double distance(const Matrix& a, const Matrix& b)
{
    EXPECT_EQ(a.rows(), b.rows());
    EXPECT_EQ(a.columns(), b.columns());
    double most = 0;
    for (size_t i = 0; i < a.values().size(); ++i)
        most = std::max(most, std::abs(a.values()[i] - b.values()[i]));
    return most;
}

Matrix identity(size_t size)
{
    Matrix a(size, size);
    for (size_t k = 0; k < size; ++k) a(k, k) = 1;
    return a;
}

TEST(Dense, SingularValuesAndVectorsMakeTheMatrix)
{
    Pcg32 random(3);
    for (const auto& [rows, columns] :
         {std::pair{1u, 1u}, {7u, 3u}, {3u, 7u}, {40u, 40u}, {90u, 20u}}) {
        const Matrix a = uniformMatrix(rows, columns, random);
        const Svd parts = svd(a);
        const size_t least = std::min(rows, columns);
        ASSERT_EQ(parts.s.size(), least);
        EXPECT_TRUE(std::ranges::is_sorted(parts.s, std::greater<>()));
        EXPECT_LT(distance(innerProducts(parts.u, parts.u), identity(least)), 1e-12);
        EXPECT_LT(distance(innerProducts(parts.v, parts.v), identity(least)), 1e-12);
        Matrix scaled = parts.u;
        for (size_t k = 0; k < least; ++k)
            for (double& x : scaled.column(k)) x *= parts.s[k];
        EXPECT_LT(distance(product(scaled, transposed(parts.v)), a), 1e-12);
    }
    // Known values: [[3, 0], [4, 5]] has the singular values 3 sqrt 5 and sqrt 5.
    Matrix known(2, 2);
    known(0, 0) = 3;
    known(1, 0) = 4;
    known(1, 1) = 5;
    EXPECT_NEAR(svd(known).s[0], std::sqrt(45.0), 1e-12);
    EXPECT_NEAR(svd(known).s[1], std::sqrt(5.0), 1e-12);
}

// The four conditions of Penrose, for matrices of full and of lower rank.
TEST(Dense, PseudoInversesObeyPenrose)
{
    Pcg32 random(4);
    for (const size_t rank : {2u, 12u}) {
        const Matrix a = product(uniformMatrix(30, rank, random), uniformMatrix(rank, 12, random));
        const Matrix inverse = pseudoInverse(a, 1e-9);
        const Matrix left = product(inverse, a), right = product(a, inverse);
        EXPECT_LT(distance(product(a, left), a), 1e-10);
        EXPECT_LT(distance(product(left, inverse), inverse), 1e-10);
        EXPECT_LT(distance(transposed(left), left), 1e-10);
        EXPECT_LT(distance(transposed(right), right), 1e-10);
    }
}

// --- adaptive matrix completion

TEST(Amc, DictionariesAreCompletedExactly)
{
    for (const Coefficients use : {Coefficients::real, Coefficients::clamped, Coefficients::bits}) {
        CompletionParams params = linear(CompletionMethod::amc, 0.1f);
        params.replacement = false;
        params.coefficients = use;
        Pcg32 random(5);
        const BitMatrix truth = tests::dictionaryMatrix(500, 200, 10, random);
        const CompletedSlice slice = completed(truth, params);
        EXPECT_EQ(slice.visible, truth);
        EXPECT_EQ(slice.stats.basis, 10u) << "a complement is the same direction";
        EXPECT_EQ(slice.stats.rays, 10u * 500 + 190u * 50);
        EXPECT_EQ(slice.coefficients.empty(), use == Coefficients::bits);
        for (size_t k = 0; k < slice.coefficients.size(); ++k) {
            const auto i = static_cast<uint32_t>(k % 500), j = static_cast<uint32_t>(k / 500);
            ASSERT_NEAR(slice.coefficients[k], truth.get(i, j) ? 1 : 0, 1e-4);
            if (use == Coefficients::clamped) {
                ASSERT_LE(slice.coefficients[k], 1);
                ASSERT_GE(slice.coefficients[k], 0);
            }
        }
    }
}

// As many known columns as sampled rows explain anything: without the guard no failure is noticed.
TEST(Amc, TheGuardSamplesMoreRowsThanThereAreColumns)
{
    Pcg32 random(6);
    const BitMatrix truth = tests::randomMatrix(400, 100, 0.5, random);
    const CompletedSlice blind = completed(truth, linear(CompletionMethod::amc, 0.05f));
    EXPECT_LE(blind.stats.basis, 25u);
    EXPECT_GT(tests::bitError(truth, blind.visible), 0.2);
    const CompletedSlice guarded = completed(truth, linear(CompletionMethod::amc, 0.05f, true));
    EXPECT_EQ(guarded.stats.basis, 100u);
    EXPECT_EQ(guarded.visible, truth);
    EXPECT_EQ(guarded.stats.rays, 400u * 100);
}

TEST(Amc, RowsThatDoNotMatterAreDarkAndFree)
{
    Pcg32 random(7);
    const BitMatrix truth = tests::dictionaryMatrix(400, 150, 5, random);
    BitMatrix matters(400, 150);
    for (uint32_t j = 0; j < 150; ++j)
        for (uint32_t i = 0; i < 300; ++i) matters.set(i, j, true);
    for (const CompletionMethod method : {CompletionMethod::amc, CompletionMethod::gaussJordan}) {
        CompletionParams params;
        params.method = method;
        tests::MatrixOracle oracle(truth, matters);
        CompletedSlice slice;
        complete(oracle, 400, std::vector<ColumnRange>{{0, 150}}, params, 1, slice);
        EXPECT_EQ(tests::bitError(truth, slice.visible, &matters), 0);
        EXPECT_LE(slice.stats.basis, 6u);
        EXPECT_LT(double(slice.stats.rays), 0.25 * double(slice.stats.active));
        for (size_t k = 0; k < slice.coefficients.size(); ++k)
            if (k % 400 >= 300) {
                ASSERT_EQ(slice.coefficients[k], 0);
            }
    }
}

// None of the sampled rows may matter: that such a column is dark has to be seen.
TEST(Amc, ColumnsThatMatterInFewRowsAreNotGuessedWithoutARay)
{
    constexpr uint32_t kRows = 1000, kColumns = 42, kFew = 20;
    BitMatrix lit(kRows, kColumns);
    for (uint32_t j = 0; j < kColumns; ++j)
        for (uint32_t i = 0; i < kRows; ++i) lit.set(i, j, j < 2 || i / kFew == j);
    CompletionParams params;
    params.method = CompletionMethod::amc;
    params.verificationRate = 0;
    for (uint64_t seed = 0; seed < 50; ++seed) {
        tests::MatrixOracle oracle(lit, lit);
        CompletedSlice slice;
        complete(oracle, kRows, std::vector<ColumnRange>{{0, kColumns}}, params, seed, slice);
        ASSERT_EQ(tests::bitError(lit, slice.visible, &lit), 0) << seed;
        EXPECT_EQ(slice.stats.matched, 1u);
    }
}

// Sums of what was predicted and of its sampled error have the mean of the truth.
TEST(LinearResidual, CorrectsTheMean)
{
    Pcg32 random(8);
    constexpr uint32_t kRows = 120, kColumns = 30;
    const BitMatrix truth = tests::edgesMatrix(kRows, kColumns, random);
    std::vector<double> weights(size_t(kRows) * kColumns);
    double exact = 0;
    for (uint32_t k = 0; k < weights.size(); ++k) {
        weights[k] = random();
        if (truth.get(k % kRows, k / kRows)) exact += weights[k];
    }
    for (const CompletionMethod method : {CompletionMethod::amc, CompletionMethod::gaussJordan}) {
        CompletionParams params = linear(method, 0.15f, method == CompletionMethod::amc);
        params.residualRate = 0.05f;
        tests::Moments predicted, corrected;
        for (uint64_t seed = 0; seed < 2000; ++seed) {
            const CompletedSlice slice = completed(truth, params, seed);
            double sum = 0;
            for (uint32_t k = 0; k < weights.size(); ++k)
                sum += weights[k] * (slice.coefficients.empty()
                                         ? double(slice.visible.get(k % kRows, k / kRows))
                                         : double(slice.coefficients[k]));
            predicted.add(sum - exact);
            for (const ResidualEntry& entry : slice.residual)
                sum += double(entry.weight) * weights[entry.column * kRows + entry.row];
            corrected.add(sum - exact);
        }
        EXPECT_NEAR(corrected.mean(), 0, tests::kScore * std::sqrt(corrected.varianceOfMean()));
        EXPECT_GT(std::abs(predicted.mean()), tests::kScore * std::sqrt(predicted.varianceOfMean()))
            << "there was no bias to be corrected";
    }
}

}  // namespace
}  // namespace core::many_lights
