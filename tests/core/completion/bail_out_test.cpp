// M1. An octant is given up where its columns match nothing, and not for what else rays are traced.
#include <gtest/gtest.h>

#include "tests/support/methods/completion_runs.h"
#include "tests/support/methods/visibility_matrices.h"

namespace core::many_lights {
namespace {

using tests::MatrixOracle;

// As long as no column is known all rays are traced for want of one, not because none matches.
TEST(Matching, SmallColumnsDoNotMakeAnOctantBailOut)
{
    constexpr uint32_t kRows = 1000, kSmall = 60, kColumns = kSmall + 200;
    BitMatrix lit(kRows, kColumns);
    for (uint32_t j = 0; j < kColumns; ++j)
        for (uint32_t i = 0; i < (j < kSmall ? 60u : 130u); ++i) lit.set(i, j, true);
    MatrixOracle oracle(lit, lit);
    CompletedSlice slice;
    complete(oracle, kRows, std::vector<ColumnRange>{{0, kColumns}}, {}, 1, slice);
    EXPECT_EQ(slice.stats.bailedOut, 0u);
    EXPECT_GT(slice.stats.matched, 150u);
}

/// All is lit in the few rows that matter; so many of the columns are bright.
class FewRowsOracle final : public MatrixOracle {
public:
    FewRowsOracle(const BitMatrix& lit, uint32_t bright) : MatrixOracle(lit, lit), bright_(bright)
    {}
    std::optional<float> brightness(uint32_t column) const override
    {
        return column < bright_ ? 6.0f : 0.1f;
    }

private:
    uint32_t bright_;
};

// Bright columns are sampled in all rows that matter; that says nothing against those to come.
TEST(Matching, RowsThatAreSampledDoNotMakeAnOctantBailOut)
{
    constexpr uint32_t kRows = 1000, kBright = 49, kColumns = kBright + 200;
    BitMatrix lit(kRows, kColumns);
    for (uint32_t j = 0; j < kColumns; ++j)
        for (uint32_t i = 0; i < 100; ++i) lit.set(i, j, true);
    FewRowsOracle oracle(lit, kBright);
    CompletedSlice slice;
    complete(oracle, kRows, std::vector<ColumnRange>{{0, kColumns}}, {}, 1, slice);
    EXPECT_EQ(slice.stats.bailedOut, 0u);
    EXPECT_EQ(slice.stats.full, kBright);
    EXPECT_EQ(slice.stats.matched, 200u);
}

}  // namespace
}  // namespace core::many_lights
