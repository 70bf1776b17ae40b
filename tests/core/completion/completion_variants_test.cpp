// M4. What holds for every variant of completion: what was traced is kept, all rows are exact, any
// size works, the seed alone decides.
#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/completion/bits.h"
#include "tests/support/methods/completion_runs.h"

namespace core::many_lights {
namespace {

using tests::completed;
using tests::matrices;
using tests::MatrixOracle;
using tests::Variant;
using tests::variants;

/// Stats fit together, what was traced is right, and a basis has no two columns alike.
TEST(Completion, EveryVariantKeepsWhatItTraced)
{
    for (const Variant& variant : variants())
        for (const BitMatrix& truth : matrices())
            for (const bool masked : {false, true}) {
                SCOPED_TRACE(variant.name);
                Pcg32 random(5);
                BitMatrix matters = tests::facingMask(truth.rows(), truth.columns(), 0.7, random);
                for (uint64_t& word : matters.column(3)) word = 0;
                if (!masked || !variant.params.dontCare)
                    for (uint32_t j = 0; j < truth.columns(); ++j)
                        for (uint32_t i = 0; i < truth.rows(); ++i) matters.set(i, j, true);
                MatrixOracle oracle(truth, matters);
                CompletedSlice slice;
                const uint32_t half = truth.columns() / 2;
                const std::vector<ColumnRange> octants{{0, half}, {half, half}, {half, half * 2}};
                complete(oracle, truth.rows(), octants, variant.params, 3, slice);
                const CompletionStats& stats = slice.stats;
                EXPECT_EQ(stats.rays, oracle.rays());
                EXPECT_GE(stats.rays, truth.rows() * 2u * 7 / 10) << "a full column each";
                EXPECT_LE(stats.rays, stats.active);
                EXPECT_EQ(stats.inactive + stats.full + stats.matched + stats.repaired,
                          stats.columns);
                EXPECT_LE(stats.bailedOut, stats.full);
                uint64_t wrong = 0;
                for (uint32_t j = 0; j < slice.visible.columns(); ++j)
                    for (size_t w = 0; w < truth.wordsPerColumn(); ++w) {
                        const uint64_t differ = slice.visible.column(j)[w] ^ truth.column(j)[w];
                        wrong += countBits(Words{differ & oracle.asked().column(j)[w]});
                        EXPECT_EQ(slice.visible.column(j)[w] & ~wordOfRows(truth.rows(), w), 0u);
                        EXPECT_EQ(slice.visible.column(j)[w] & ~matters.column(j)[w], 0u);
                    }
                if (variant.params.residualRate <= 0) {
                    EXPECT_EQ(wrong, 0u);
                    EXPECT_TRUE(slice.residual.empty());
                } else {
                    EXPECT_EQ(wrong, slice.residual.size());
                }
            }
}

TEST(Completion, TracingAllRowsIsExact)
{
    for (const Variant& variant : variants())
        for (const BitMatrix& truth : matrices()) {
            CompletionParams params = variant.params;
            params.rowRate = params.rowCap = 1;
            params.replacement = false;
            const CompletedSlice slice = completed(truth, params);
            EXPECT_EQ(slice.visible, truth) << variant.name;
            EXPECT_LE(slice.stats.basis, 1u) << "full columns need no comparison";
        }
}

TEST(Completion, SmallSlicesAndEveryOddSizeWork)
{
    Pcg32 random(2);
    for (const Variant& variant : variants())
        for (const uint32_t rows : {1u, 2u, 7u, 63u, 64u, 65u, 66u, 129u})
            for (const uint32_t columns : {0u, 1u, 2u, 40u}) {
                const BitMatrix truth = tests::randomMatrix(rows, columns, 0.8, random);
                CompletionParams params = variant.params;
                params.verificationRate = 1;  // more than there are
                const CompletedSlice slice = completed(truth, params);
                EXPECT_EQ(slice.visible.columns(), columns);
                if (rows <= params.smallSlice) {
                    EXPECT_EQ(slice.visible, truth);
                    EXPECT_EQ(slice.stats.full, columns);
                }
            }
}

TEST(Completion, TheSeedAloneDecides)
{
    Pcg32 random(8);
    const BitMatrix truth = tests::edgesMatrix(300, 100, random);
    for (const Variant& variant : variants()) {
        const CompletedSlice a = completed(truth, variant.params, 1),
                             b = completed(truth, variant.params, 1),
                             c = completed(truth, variant.params, 2);
        EXPECT_EQ(a.visible, b.visible) << variant.name;
        EXPECT_EQ(a.stats.rays, b.stats.rays);
        EXPECT_TRUE(a.visible != c.visible || a.stats.rays != c.stats.rays) << variant.name;
    }
}

TEST(Completion, ThreadsDoNotChangeABit)
{
    constexpr size_t kSlices = 40;
    Pcg32 random(9);
    const BitMatrix truth = tests::edgesMatrix(300, 60, random);
    const auto run = [&](size_t threads) {
        const core::ThreadLimit limit(threads);
        std::vector<CompletedSlice> slices(kSlices);
        core::parallelFor(kSlices, 1, [&](size_t begin, size_t end) {
            CompletedSlice slice;  // used again for the next one of the block
            for (size_t s = begin; s < end; ++s) {
                MatrixOracle oracle(truth);
                complete(oracle, 300, std::vector<ColumnRange>{{0, 60}}, {}, s, slice);
                slices[s] = slice;
            }
        });
        return slices;
    };
    const auto one = run(1), many = run(0);
    for (size_t s = 0; s < kSlices; ++s) {
        EXPECT_EQ(one[s].visible, many[s].visible);
        EXPECT_EQ(one[s].stats.rays, many[s].stats.rays);
    }
}

// An octant has random numbers of its own: it is completed alike whatever stands before it.
TEST(Completion, OctantsShareNothing)
{
    Pcg32 random(8);
    BitMatrix truth = tests::edgesMatrix(400, 100, random);
    const auto run = [&] {
        MatrixOracle oracle(truth);
        CompletedSlice slice;
        complete(oracle, 400, std::vector<ColumnRange>{{0, 40}, {40, 100}}, {}, 6, slice);
        return slice.visible;
    };
    const BitMatrix before = run();
    for (uint32_t j = 0; j < 40; ++j)
        for (uint32_t i = 0; i < 400; ++i) truth.set(i, j, i % 7 < j % 5);
    const BitMatrix after = run();
    for (uint32_t j = 40; j < 100; ++j)
        EXPECT_TRUE(std::ranges::equal(before.column(j), after.column(j))) << j;
}

TEST(Completion, ABasisIsNeverLargerThanTheDistinctColumns)
{
    for (const Variant& variant : variants()) {
        if (variant.params.onMismatch != OnMismatch::full) continue;  // stores what it predicts
        // Complements are sums with the constant column, which may be known from the beginning.
        const bool counted =
            variant.params.seedConstant || variant.params.method == CompletionMethod::gaussJordan;
        const uint32_t constant = counted ? 1 : 0;
        for (const BitMatrix& truth : matrices())
            EXPECT_LE(completed(truth, variant.params).stats.basis,
                      tests::distinctColumns(truth) + constant);
    }
}

}  // namespace
}  // namespace core::many_lights
