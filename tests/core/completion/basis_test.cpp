// The basis of an octant against a plain comparison bit by bit.
#include <vector>

#include <gtest/gtest.h>

#include "core/base/pcg32.h"
#include "core/completion/basis.h"
#include "core/completion/row_weights.h"
#include "tests/support/methods/visibility_matrices.h"

namespace core::many_lights {
namespace {

using tests::randomRows;

TEST(Bits, PackedAreTheSelectedBitsInOrder)
{
    Pcg32 random(1);
    for (const uint32_t rows : {1u, 63u, 64u, 65u, 500u, 2000u})
        for (const double share : {0.0, 0.03, 0.5, 1.0}) {
            const Words words = randomRows(rows, 0.5, random),
                        mask = randomRows(rows, share, random);
            const uint32_t before = 5;
            Words packed(wordsFor(rows + before) + 1), plain(packed.size());
            packed[0] = plain[0] = 0b10110;
            uint32_t at = before;
            forEachBit(mask, [&](uint32_t i) {
                if (getBit(words, i)) setBit(plain, at);
                ++at;
            });
            EXPECT_EQ(packBits(words, mask, packed.data(), before), at);
            EXPECT_EQ(packed, plain) << rows << " rows, " << share;
        }
}

struct PlainColumn {
    Words bits, known;
};

/// A basis of columns that are near copies of few, so that many match, and the same as plain lists.
struct Case {
    std::vector<PlainColumn> columns;
    PlainColumn column;
    Words samples, checks;
};

Case randomCase(uint32_t rows, uint32_t count, double known, Pcg32& random)
{
    Case made;
    const Words pattern = randomRows(rows, 0.5, random);
    const auto nearCopy = [&] {
        PlainColumn column{pattern, randomRows(rows, known, random)};
        const bool flip = random() < 0.3;
        const double noise = random() < 0.5 ? 0 : 0.02;
        const Words errors = randomRows(rows, noise, random);
        for (size_t w = 0; w < pattern.size(); ++w)
            column.bits[w] = ((flip ? ~pattern[w] : pattern[w]) ^ errors[w]) & column.known[w];
        return column;
    };
    for (uint32_t k = 0; k < count; ++k) made.columns.push_back(nearCopy());
    made.column = nearCopy();
    made.samples = randomRows(rows, 0.05, random);
    made.checks = randomRows(rows, 0.05, random);
    for (size_t w = 0; w < pattern.size(); ++w) made.checks[w] &= ~made.samples[w];
    return made;
}

TEST(Basis, MatchesAsAPlainComparisonDoes)
{
    Pcg32 random(2);
    uint32_t matches = 0, failures = 0;
    for (int t = 0; t < 300; ++t) {
        const uint32_t rows = 100 + drawBelow(1500, random), count = drawBelow(40, random);
        const double known = t % 3 == 0 ? 1 : 0.7;
        const Case c = randomCase(rows, count, known, random);
        Basis basis(rows);
        const uint32_t before = count / 2;  // the others are added when rows are selected already
        for (uint32_t k = 0; k < before; ++k) basis.push(c.columns[k].bits, c.columns[k].known);
        basis.select(c.samples, c.checks);
        for (uint32_t k = before; k < count; ++k) basis.push(c.columns[k].bits, c.columns[k].known);

        std::vector<Candidate> expected, found;
        bool expectedOnSamples = false;
        constexpr uint32_t kFewest = 8;
        std::optional<Basis::Nearest> nearest;
        for (uint32_t k = 0; k < count; ++k) {
            uint32_t common[2] = {}, differ[2] = {};  // on samples, on checks
            for (uint32_t i = 0; i < rows; ++i)
                for (int stage = 0; stage < 2; ++stage) {
                    if (!getBit(stage == 0 ? c.samples : c.checks, i)) continue;
                    if (!getBit(c.column.known, i) || !getBit(c.columns[k].known, i)) continue;
                    ++common[stage];
                    differ[stage] += getBit(c.column.bits, i) != getBit(c.columns[k].bits, i);
                }
            const uint32_t all = common[0] + common[1], wrong = differ[0] + differ[1];
            expectedOnSamples |= common[0] > 0 && (differ[0] == 0 || differ[0] == common[0]);
            if (all < kFewest) continue;
            if (wrong == 0) expected.push_back({k, false});
            if (wrong == all) expected.push_back({k, true});
            const uint32_t least = std::min(wrong, all - wrong);
            if (!nearest || least < nearest->differ)
                nearest = Basis::Nearest{{k, 2 * wrong > all}, least, all};
        }
        ColumnKey key;
        basis.makeKey(c.column.bits, c.column.known, key);
        basis.match(key, kFewest, found);
        EXPECT_EQ(found, expected);
        EXPECT_EQ(basis.matchesSamples(key), expectedOnSamples);
        const auto foundNearest = basis.nearest(key, kFewest);
        ASSERT_EQ(foundNearest.has_value(), nearest.has_value());
        if (nearest) {
            EXPECT_EQ(foundNearest->candidate, nearest->candidate);
            EXPECT_EQ(foundNearest->differ, nearest->differ);
            EXPECT_EQ(foundNearest->common, nearest->common);
        }
        matches += !expected.empty();
        failures += expected.empty();
    }
    EXPECT_GT(matches, 50u);
    EXPECT_GT(failures, 50u);
}

TEST(Basis, EqualColumnsAreFoundWhereBothAreKnown)
{
    Pcg32 random(3);
    const uint32_t rows = 300;
    const Words bits = randomRows(rows, 0.5, random), all = randomRows(rows, 1, random);
    Basis basis(rows);
    basis.push(randomRows(rows, 0.5, random), all);
    basis.push(bits, all);
    EXPECT_EQ(basis.findEqual(bits, all), (Candidate{1, false}));
    Words complement = bits;
    for (size_t w = 0; w < bits.size(); ++w) complement[w] = ~bits[w] & all[w];
    EXPECT_EQ(basis.findEqual(complement, all), (Candidate{1, true}));
    Words other = bits;
    other[2] ^= 1;
    EXPECT_EQ(basis.findEqual(other, all), std::nullopt);
    Words without = all;
    without[2] &= ~uint64_t(1);
    EXPECT_EQ(basis.findEqual(other, without), (Candidate{1, false}));
    EXPECT_EQ(basis.findEqual(bits, Words(bits.size())), std::nullopt) << "nothing is no equality";
}

TEST(Basis, UnknownRowsAreFilledOnce)
{
    Basis basis(70);
    const Words bits{0b0101, 1}, known{0b1111, 0};
    basis.push(bits, known);
    EXPECT_EQ(basis.bits(0)[1], 0u) << "what is not known is zero";
    basis.fill({0, false}, Words{0b111111, 0}, Words{0b110011, 0});
    EXPECT_EQ(basis.bits(0)[0], 0b110101u);
    EXPECT_EQ(basis.known(0)[0], 0b111111u);
    basis.fill({0, true}, Words{0, 0b01}, Words{0, 0b11});
    EXPECT_EQ(basis.bits(0)[1], 0b10u);
    EXPECT_EQ(basis.known(0)[1], 0b11u);
}

}  // namespace
}  // namespace core::many_lights
