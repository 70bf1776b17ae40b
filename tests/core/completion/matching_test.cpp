// M1, M2. Completion by matching: against a plain implementation of the paper's loop, and against
// the numbers of rays and errors that follow from the structure of synthetic matrices.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/completion/row_weights.h"
#include "tests/support/methods/completion_runs.h"
#include "tests/support/methods/visibility_matrices.h"
#include "tests/support/statistics/stats.h"

namespace core::many_lights {
namespace {

using tests::completed;
using tests::fixedRate;
using tests::MatrixOracle;
using tests::Mean;
using tests::meanOf;
using tests::tenColumns;

// --- the paper's loop, plainly

struct Plain {
    std::vector<std::vector<bool>> columns, basis;
    uint64_t rays = 0;
    uint32_t failures = 0, ambiguous = 0;
};

/// CompletionParams::authorPreset() with the rates of `params`, bit by bit.
Plain plainMatching(const BitMatrix& truth, const CompletionParams& params, uint64_t seed)
{
    const uint32_t n = truth.rows();
    Pcg32 random(octantSeed(seed, 0));
    std::vector<double> weight(n, 1.0 / n);
    double alpha = double(params.rowRate);
    const auto rows = [&](double rate) {
        return std::max<uint32_t>(1, static_cast<uint32_t>(std::lround(rate * n)));
    };
    Plain result;
    for (uint32_t j = 0; j < truth.columns(); ++j) {
        std::vector<bool> column(n), traced(n);
        const auto trace = [&](uint32_t i) {
            if (traced[i]) return;
            traced[i] = true;
            ++result.rays;
            column[i] = truth.get(i, j);
        };
        const auto traceFully = [&] {
            for (uint32_t i = 0; i < n; ++i) trace(i);
            std::vector<std::pair<uint32_t, uint32_t>> runs;
            for (uint32_t i = 0; i < n; ++i) {
                if (i == 0 || column[i] != column[i - 1]) runs.emplace_back(i, i);
                ++runs.back().second;
            }
            for (const auto& [begin, end] : runs)
                for (uint32_t i = begin; i < end && params.adaptiveRows; ++i)
                    weight[i] += 1.0 / double(runs.size()) / double(end - begin);
            std::vector<bool> complement = column;
            complement.flip();
            if (std::ranges::find(result.basis, column) == result.basis.end() &&
                std::ranges::find(result.basis, complement) == result.basis.end())
                result.basis.push_back(column);
        };
        const auto finish = [&] { result.columns.push_back(column); };
        if (result.basis.empty()) {
            traceFully();
            finish();
            continue;
        }
        double total = 0;
        for (const double w : weight) total += w;
        for (uint32_t k = 0; k < rows(alpha); ++k) {
            const double u = random() * total;
            double sum = weight[0];
            uint32_t i = 0;
            while (!(u < sum) && i + 1 < n) sum += weight[++i];
            trace(i);
        }
        std::vector<std::vector<bool>> candidates;
        for (const std::vector<bool>& known : result.basis)
            for (const bool complement : {false, true}) {
                bool equal = true;
                for (uint32_t i = 0; i < n; ++i)
                    equal = equal && (!traced[i] || (known[i] != complement) == column[i]);
                if (!equal) continue;
                candidates.push_back(known);
                if (complement) candidates.back().flip();
            }
        if (candidates.empty()) {
            traceFully();
            finish();
            continue;
        }
        result.ambiguous += candidates.size() > 1;
        const auto picked = candidates.size() == 1
                                ? candidates[0]
                                : candidates[drawBelow(uint32_t(candidates.size()), random)];
        bool right = true;
        if (params.verificationRate > 0) {
            Words untraced(wordsFor(n)), checks(wordsFor(n));
            for (uint32_t i = 0; i < n; ++i)
                if (!traced[i]) setBit(untraced, i);
            drawUniform(rows(double(params.verificationRate)), untraced, random, checks);
            forEachBit(checks, [&](uint32_t i) {
                trace(i);
                right = right && picked[i] == column[i];
            });
        }
        if (right) {
            column = picked;
        } else {
            ++result.failures;
            alpha = std::min(double(params.rowCap), alpha + double(params.rowIncrement));
            traceFully();
        }
        finish();
    }
    return result;
}

TEST(Matching, IsThePapersLoopBitByBit)
{
    Pcg32 random(1);
    std::vector<BitMatrix> matrices;
    matrices.push_back(tests::dictionaryMatrix(300, 100, 12, random));
    matrices.push_back(tests::edgesMatrix(300, 150, random));
    matrices.push_back(tests::spheresMatrix(18, 150, 3, 0.08, 0.2, random));
    uint32_t failures = 0, ambiguous = 0;
    for (const BitMatrix& truth : matrices)
        for (const bool verified : {false, true})
            for (const bool adaptive : {false, true}) {
                CompletionParams params = CompletionParams::authorPreset();
                params.adaptiveRows = adaptive;
                if (!verified) params.verificationRate = 0;
                const uint64_t seed = random.bits();
                const CompletedSlice found = completed(truth, params, seed);
                const Plain plain = plainMatching(truth, params, seed);
                for (uint32_t j = 0; j < truth.columns(); ++j)
                    for (uint32_t i = 0; i < truth.rows(); ++i)
                        ASSERT_EQ(found.visible.get(i, j), plain.columns[j][i]) << i << ' ' << j;
                EXPECT_EQ(found.stats.rays, plain.rays);
                EXPECT_EQ(found.stats.basis, plain.basis.size());
                EXPECT_EQ(found.stats.verificationFailures, plain.failures);
                EXPECT_EQ(found.stats.ambiguous, plain.ambiguous);
                failures += plain.failures;
                ambiguous += plain.ambiguous;
            }
    EXPECT_GT(failures, 20u);
    EXPECT_GT(ambiguous, 20u);
}

// --- known numbers: 1000 x 1000, mean of five

BitMatrix hundredColumns(Pcg32& random)
{
    return tests::dictionaryMatrix(1000, 1000, 100, random);
}

TEST(Matching, DictionariesAreCompletedExactlyWithTheRaysOfTheClosedForm)
{
    // Rays: (r + (c - r) s) / c, s the expected share of distinct rows among those drawn.
    const auto rays = [](double r, double share) { return 100 * (r + (1000 - r) * share) / 1000; };
    const auto distinct = [](double draws) { return 1 - std::pow(1 - 1.0 / 1000, draws); };
    for (const double r : {10.0, 100.0})
        for (const float rate : {0.025f, 0.1f, 0.2f}) {
            const auto make = r < 50 ? tenColumns : hundredColumns;
            CompletionParams params = fixedRate(rate);
            const Mean with = meanOf(params, make);
            EXPECT_NEAR(with.rays, rays(r, distinct(1000 * double(rate))), 0.03 * with.rays);
            EXPECT_NEAR(with.author, rays(r, double(rate)), 1e-5);
            params.replacement = false;
            const Mean without = meanOf(params, make);
            EXPECT_NEAR(without.rays, rays(r, double(rate)), 1e-4);
            for (const Mean& mean : {with, without}) {
                EXPECT_EQ(mean.error, 0);
                EXPECT_EQ(mean.basis, r);
            }
        }
    for (const double r : {10.0, 100.0}) {
        const Mean verified =
            meanOf(CompletionParams::authorPreset(), r < 50 ? tenColumns : hundredColumns);
        EXPECT_NEAR(verified.rays, rays(r, distinct(25) + 0.025), 0.03 * verified.rays);
        EXPECT_NEAR(verified.author, rays(r, 0.025), 1e-5);
        EXPECT_EQ(verified.error, 0);
        EXPECT_EQ(verified.basis, r);
        EXPECT_NEAR(verified.rate, 0.025, 1e-7) << "no verification fails";
    }
}

// All columns sampled before any is traced in full, and the constant column known: the same rays.
TEST(Matching, TwoPhasesCompleteDictionariesExactly)
{
    for (const bool seeded : {false, true}) {
        CompletionParams params;
        params.twoPhase = true;
        params.seedConstant = seeded;
        params.rowMinimum = 25;
        const Mean mean = meanOf(params, tenColumns);
        EXPECT_EQ(mean.error, 0);
        EXPECT_NEAR(mean.rays, 1 + 99 * 0.05, 1e-4);
        EXPECT_EQ(mean.basis, seeded ? 11 : 10);
    }
}

TEST(Matching, SumsOfColumnsAreColumnsOfTheirOwn)
{
    const auto rank20 = [](Pcg32& random) { return tests::sumsMatrix(1000, 1000, 20, random); };
    const auto rank5 = [](Pcg32& random) { return tests::sumsMatrix(1000, 1000, 5, random); };
    const Mean many = meanOf(fixedRate(0.1f), rank20);
    EXPECT_GT(many.rays, 99.8);
    EXPECT_EQ(many.error, 0);
    EXPECT_NEAR(many.basis, 999, 1.5);
    const Mean few = meanOf(fixedRate(0.1f), rank5);
    EXPECT_NEAR(few.rays, 12.4, 0.3);
    EXPECT_EQ(few.error, 0);
    EXPECT_EQ(few.basis, 32);
}

TEST(Matching, AllLitIsOneColumnAndSoIsAllDark)
{
    const auto mixed = [](Pcg32& random) {
        BitMatrix truth(1000, 1000);
        for (uint32_t j = 0; j < 1000; ++j)
            for (uint32_t i = 0; j % 3 != 0 && i < 1000; ++i) truth.set(i, j, true);
        (void)random;
        return truth;
    };
    const Mean mean = meanOf(fixedRate(0.1f), mixed);
    EXPECT_NEAR(mean.rays, 9.6, 0.1);
    EXPECT_EQ(mean.error, 0);
    EXPECT_EQ(mean.basis, 1);
}

// Hundreds of columns that differ little: rays and errors as in prototypes, within 15 %.
TEST(Matching, ShadowEdgesCostRaysRatherThanErrors)
{
    const auto edges = [](Pcg32& random) { return tests::edgesMatrix(1000, 1000, random); };
    const Mean fixed = meanOf(fixedRate(0.1f), edges);
    EXPECT_NEAR(fixed.rays, 25.5, 0.15 * 25.5);
    EXPECT_NEAR(fixed.error, 0.63, 0.15 * 0.63);
    EXPECT_NEAR(fixed.basis, 173, 0.15 * 173);
    const Mean raised = meanOf(CompletionParams::authorPreset(), edges);
    EXPECT_NEAR(raised.rays, 64.8, 0.15 * 64.8);
    EXPECT_LT(raised.error, 0.2);
    EXPECT_NEAR(raised.basis, 413, 0.15 * 413);
    EXPECT_GT(raised.rate, 0.3);
    CompletionParams joint;
    joint.bailOut = 1;
    EXPECT_GT(meanOf(joint, edges).rate, 0.3);
    joint.rowIncrement = 0;
    EXPECT_NEAR(meanOf(joint, edges).rate, 0.025, 1e-7);
}

TEST(Matching, RowsAtShadowBordersHalveTheError)
{
    const auto room = [](Pcg32& random) {
        return tests::spheresMatrix(32, 1000, 2, 0.05, 0.03, random);
    };
    CompletionParams params = fixedRate(0.1f);
    const Mean adaptive = meanOf(params, room);
    EXPECT_LT(adaptive.rays, 14);
    EXPECT_LT(adaptive.error, 0.06);
    params.adaptiveRows = false;
    const Mean uniform = meanOf(params, room);
    EXPECT_GT(uniform.error, 2 * adaptive.error);
    const Mean ours = meanOf(CompletionParams{}, room);
    EXPECT_LT(ours.rays, adaptive.rays);
    EXPECT_LT(ours.error, adaptive.error / 2);
}

TEST(Matching, UnrelatedColumnsCostAllRaysAndNoErrors)
{
    const auto large = [](Pcg32& random) {
        return tests::spheresMatrix(32, 1000, 5, 0.1, 0.8, random);
    };
    const Mean room = meanOf(fixedRate(0.1f), large);
    EXPECT_GT(room.rays, 60);
    EXPECT_LT(room.rays, 90);
    EXPECT_LT(room.error, 0.7);
    const auto foliage = [](Pcg32& random) { return tests::foliageMatrix(1000, 300, 20, random); };
    for (const float bailOut : {1.0f, 0.75f}) {
        CompletionParams params;
        params.bailOut = bailOut;
        const Mean leaves = meanOf(params, foliage);
        EXPECT_GT(leaves.rays, 99.9);
        EXPECT_LE(leaves.rays, 100);
        EXPECT_EQ(leaves.error, 0);
        EXPECT_EQ(leaves.basis <= 34, bailOut < 1) << leaves.basis;
    }
}

TEST(Matching, ComplementsAndOrderDoNotChangeTheBasis)
{
    Pcg32 random(4);
    const BitMatrix truth = tests::dictionaryMatrix(600, 200, 12, random);
    const CompletedSlice plain = completed(truth, {});
    BitMatrix flipped = truth, turned = truth;
    for (uint32_t j = 0; j < 200; ++j)
        for (uint32_t i = 0; i < 600; ++i) {
            if (random.bits() % 2 == 0 && i == 0)
                for (uint32_t k = 0; k < 600; ++k) flipped.set(k, j, !truth.get(k, j));
            turned.set(i, j, truth.get(i, 199 - j));
        }
    const CompletedSlice complemented = completed(flipped, {});
    EXPECT_EQ(complemented.visible, flipped);
    EXPECT_EQ(complemented.stats.basis, plain.stats.basis);
    EXPECT_EQ(complemented.stats.rays, plain.stats.rays);
    const CompletedSlice reversed = completed(turned, {});
    EXPECT_EQ(reversed.visible, turned);
    EXPECT_EQ(reversed.stats.basis, 12u);
    EXPECT_EQ(tests::distinctColumns(truth), 12u);
}

// Two columns that differ in d of n rows are confused if none of them is among the m + v rows
// drawn: (n-d over m+v) / (n over m+v) without replacement, (1 - d/n)^m with it.
TEST(Matching, ColumnsAreConfusedAsOftenAsTheLawSays)
{
    constexpr uint32_t kRows = 1000, kTrials = 30000;
    for (const uint32_t d : {5u, 20u, 50u})
        for (const bool author : {false, true}) {
            BitMatrix truth(kRows, 2);
            for (uint32_t i = 0; i < d; ++i) truth.set(i * (kRows / d), 1, true);
            CompletionParams params = author ? fixedRate(0.05f) : tests::wholeColumns();
            params.adaptiveRows = false;
            double expected = 1;
            for (uint32_t k = 0; k < 50; ++k)
                expected *= 1 - double(d) / (author ? kRows : kRows - k);
            uint64_t confused = 0;
            for (uint32_t t = 0; t < kTrials; ++t) {
                MatrixOracle oracle(truth);
                CompletedSlice slice;
                complete(oracle, kRows, std::vector<ColumnRange>{{0, 2}}, params, t, slice);
                confused += slice.stats.matched;
                EXPECT_EQ(slice.visible == truth, slice.stats.matched == 0);
            }
            const double error = std::sqrt(expected * (1 - expected) / kTrials);
            EXPECT_NEAR(double(confused) / double(kTrials), expected, tests::kScore * error) << d;
            EXPECT_LT(error, 0.05 * expected) << "a bias of 25 % would not be seen";
        }
}

// The law of above, with rows in proportion to the light that the column may bring: half of those
// at the rates at the mean, three times as many at most, and no fewer than eight.
TEST(Matching, BrightColumnsAreComparedInMoreRows)
{
    constexpr uint32_t kRows = 1000, kDark = 10, kTrials = 20000;
    BitMatrix truth(kRows, 2);
    for (uint32_t i = 0; i < kDark; ++i) truth.set(i * (kRows / kDark), 1, true);
    CompletionParams params = tests::wholeColumns();
    params.adaptiveRows = false;
    params.rowRate = params.verificationRate = 0.04f;
    for (const auto& [brightness, rows] :
         {std::pair{0.01f, 16u}, {0.75f, 30u}, {2.0f, 80u}, {50.0f, 240u}}) {
        double expected = 1;
        for (uint32_t k = 0; k < rows; ++k) expected *= 1 - double(kDark) / (kRows - k);
        uint64_t confused = 0;
        for (uint32_t t = 0; t < kTrials; ++t) {
            tests::BrightOracle oracle(truth, brightness);
            CompletedSlice slice;
            complete(oracle, kRows, std::vector<ColumnRange>{{0, 2}}, params, t, slice);
            confused += slice.stats.matched;
        }
        const double error = std::sqrt(expected * (1 - expected) / kTrials);
        EXPECT_NEAR(double(confused) / double(kTrials), expected, tests::kScore * error)
            << brightness;
    }
}

// A column that matters in few rows has few of those that its block has drawn; it is compared in as
// many as any other nevertheless, and the law of above holds among its own rows.
TEST(Matching, ColumnsThatMatterInFewRowsAreConfusedNoMoreOften)
{
    constexpr uint32_t kRows = 1000, kFew = 400, kDark = 10, kTrials = 20000;
    BitMatrix truth(kRows, 3), matters(kRows, 3);
    for (uint32_t j = 0; j < 3; ++j)
        for (uint32_t i = 0; i < kRows; ++i) {
            matters.set(i, j, j < 2 || i < kFew);
            truth.set(i, j, j < 2 || (i < kFew && i % (kFew / kDark) != 0));
        }
    CompletionParams params = tests::wholeColumns();
    params.adaptiveRows = false;
    double expected = 1;
    for (uint32_t k = 0; k < 50; ++k) expected *= 1 - double(kDark) / (kFew - k);
    uint32_t confused = 0;
    for (uint32_t t = 0; t < kTrials; ++t) {
        MatrixOracle oracle(truth, matters);
        CompletedSlice slice;
        complete(oracle, kRows, std::vector<ColumnRange>{{0, 3}}, params, t, slice);
        confused += tests::bitError(truth, slice.visible, &matters) > 0;
    }
    const double error = std::sqrt(expected * (1 - expected) / kTrials);
    EXPECT_NEAR(double(confused) / double(kTrials), expected, tests::kScore * error);
    EXPECT_LT(error, 0.05 * expected);
}

/// Counts how often column 2 is asked for.
class CountingOracle : public MatrixOracle {
public:
    using MatrixOracle::MatrixOracle;
    void trace(std::span<const TraceRequest> requests) override
    {
        for (const TraceRequest& r : requests) asked2 += r.column == 2;
        MatrixOracle::trace(requests);
    }
    uint32_t asked2 = 0;
};

// Of such a column the last rows are compared after it has been matched: with its block, then in
// these rows, then in all, it is asked for three times where they fail.
TEST(Matching, LateRowsThatFailRaiseTheRateToo)
{
    constexpr uint32_t kRows = 1000, kFew = 400, kDark = 10;
    BitMatrix truth(kRows, 3), matters(kRows, 3);
    for (uint32_t j = 0; j < 3; ++j)
        for (uint32_t i = 0; i < kRows; ++i) {
            matters.set(i, j, j < 2 || i < kFew);
            truth.set(i, j, j < 2 || (i < kFew && i % (kFew / kDark) != 0));
        }
    CompletionParams params = tests::wholeColumns();
    params.adaptiveRows = false;
    uint32_t late = 0;
    for (uint64_t seed = 0; seed < 200; ++seed) {
        CountingOracle oracle(truth, matters);
        CompletedSlice slice;
        complete(oracle, kRows, std::vector<ColumnRange>{{0, 3}}, params, seed, slice);
        if (oracle.asked2 < 3) continue;
        ++late;
        EXPECT_EQ(slice.stats.verificationFailures, 1u);
        EXPECT_NEAR(slice.stats.meanRate(), 0.05, 1e-7);
    }
    EXPECT_GT(late, 20u);
}

// Known rows of other columns stand in for rows of which a column of the basis knows nothing.
TEST(Matching, RowsThatDoNotMatterTakeNoPart)
{
    Pcg32 random(6);
    const BitMatrix truth = tests::dictionaryMatrix(800, 300, 6, random);
    const BitMatrix matters = tests::facingMask(800, 300, 0.7, random);
    MatrixOracle oracle(truth, matters);
    CompletedSlice slice;
    complete(oracle, 800, std::vector<ColumnRange>{{0, 300}}, {}, 1, slice);
    EXPECT_EQ(tests::bitError(truth, slice.visible, &matters), 0);
    EXPECT_LE(slice.stats.basis, 12u);
    EXPECT_LT(double(slice.stats.rays), 0.13 * double(slice.stats.active));
}

TEST(Matching, RaysDecideBetweenSeveralMatches)
{
    Pcg32 random(3);
    const auto edges = [](Pcg32& r) { return tests::edgesMatrix(1000, 400, r); };
    CompletionParams params = fixedRate(0.1f);
    const Mean chance = meanOf(params, edges);
    params.disambiguate = true;
    const Mean asked = meanOf(params, edges);
    EXPECT_LT(asked.error, 0.7 * chance.error);

    // With verification there are fewer failures and hence fewer rays.
    const auto room = [](Pcg32& r) { return tests::spheresMatrix(32, 1000, 2, 0.05, 0.03, r); };
    params = CompletionParams::authorPreset();
    const Mean verified = meanOf(params, room);
    params.disambiguate = true;
    EXPECT_LT(meanOf(params, room).rays, 0.93 * verified.rays);
}

}  // namespace
}  // namespace core::many_lights
