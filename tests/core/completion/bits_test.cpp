// Operations on rows of bits against the same row by row.
#include <algorithm>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/pcg32.h"
#include "core/completion/bits.h"
#include "tests/support/methods/visibility_matrices.h"

namespace core::many_lights {
namespace {

using tests::randomRows;

TEST(Bits, RowsAreFoundByTheirNumber)
{
    Pcg32 random(2);
    for (const double share : {0.01, 0.4, 1.0}) {
        const Words words = randomRows(500, share, random);
        uint32_t number = 0;
        forEachBit(words, [&](uint32_t i) { EXPECT_EQ(rowOfNumber(words, number++), i); });
        EXPECT_EQ(number, countBits(words));
    }
}

TEST(Bits, AreSetWhereValuesArePositive)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<float> kinds{0.0f, -0.0f, 1.0f, -1.0f, 1e-45f, nan};
    Pcg32 random(3);
    for (const size_t rows : {1u, 7u, 8u, 63u, 64u, 65u, 200u}) {
        std::vector<float> values(rows);
        for (float& v : values) v = kinds[std::min<size_t>(kinds.size() - 1, size_t(6 * random()))];
        Words words(wordsFor(static_cast<uint32_t>(rows)), ~uint64_t(0));
        positiveToBits(values, words);
        for (uint32_t i = 0; i < 64 * words.size(); ++i)
            EXPECT_EQ(getBit(words, i), i < rows && values[i] > 0) << rows << ' ' << i;
    }
}

TEST(Bits, LeaveTheValuesOfTheirRows)
{
    Pcg32 random(4);
    for (const uint32_t rows : {1u, 31u, 32u, 33u, 64u, 97u, 200u}) {
        const Words words = randomRows(rows, 0.5, random);
        std::vector<float> values(rows);
        for (uint32_t i = 0; i < rows; ++i) values[i] = 1 + static_cast<float>(i);
        maskValues(words, values);
        for (uint32_t i = 0; i < rows; ++i)
            EXPECT_EQ(values[i], getBit(words, i) ? 1 + static_cast<float>(i) : 0.0f);
    }
}

}  // namespace
}  // namespace core::many_lights
