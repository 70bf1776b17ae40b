// Counts of many rows at once, against counting row by row.
#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/pcg32.h"
#include "core/completion/row_counts.h"
#include "tests/support/methods/visibility_matrices.h"

namespace core::many_lights {
namespace {

using tests::randomRows;

struct CountedSet {
    Words rows;
    bool others;
};

/// The rows of `open` with the greatest min(number, sets - number), unless that is zero.
Words mostEvenPlainly(const Words& open, const std::vector<CountedSet>& sets)
{
    const auto most = static_cast<uint32_t>(sets.size());
    std::vector<uint32_t> even(64 * open.size());
    uint32_t greatest = 0;
    forEachBit(open, [&](uint32_t i) {
        uint32_t number = 0;
        for (const CountedSet& set : sets) number += getBit(set.rows, i) != set.others ? 1u : 0u;
        even[i] = std::min(number, most - number);
        greatest = std::max(greatest, even[i]);
    });
    Words rows(open.size());
    forEachBit(open, [&](uint32_t i) {
        if (greatest > 0 && even[i] == greatest) setBit(rows, i);
    });
    return rows;
}

TEST(RowCounts, FindTheRowsThatDivideMostEvenly)
{
    Pcg32 random(1);
    RowCounts counts;
    for (const uint32_t rows : {1u, 64u, 65u, 700u})
        for (const uint32_t most : {1u, 2u, 3u, 4u, 7u, 16u, 255u})
            for (const double share : {0.02, 0.5, 0.97}) {
                Words open = randomRows(rows, 0.9, random);
                std::vector<CountedSet> sets;
                counts.begin(open, most);
                for (uint32_t k = 0; k < most; ++k) {
                    const Words known = randomRows(rows, 0.99, random);
                    sets.push_back({randomRows(rows, share, random), random() < 0.3});
                    counts.keep(known);
                    counts.add(sets.back().rows, sets.back().others);
                    for (size_t w = 0; w < open.size(); ++w) open[w] &= known[w];
                }
                const std::span<const uint64_t> found = counts.mostEven();
                const Words plain = mostEvenPlainly(open, sets);
                if (countBits(plain) == 0)
                    EXPECT_TRUE(found.empty()) << rows << ' ' << most << ' ' << share;
                else
                    EXPECT_TRUE(std::ranges::equal(found, plain))
                        << rows << ' ' << most << ' ' << share;
            }
}

}  // namespace
}  // namespace core::many_lights
