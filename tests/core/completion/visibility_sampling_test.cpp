// M18. Visibility from samples: few questions where everything is alike, the truth where shadows
// are wide, and all questions where all are to be asked.
#include "core/completion/visibility_sampling.h"

#include <functional>

#include <gtest/gtest.h>

namespace {

using core::many_lights::VisibilitySampling;

struct Found {
    std::vector<bool> visible;
    uint64_t asked;
};

Found sample(uint32_t count, bool whole, const std::function<bool(uint32_t)>& truth)
{
    VisibilitySampling sampling;
    sampling.add(10, true);  // sequences do not disturb each other
    const uint32_t sequence = sampling.add(count, whole);
    std::vector<int> times(count, 0);
    const uint64_t asked = sampling.run(
        [&](uint32_t s, uint32_t i, uint64_t* word, uint64_t bit) {
            if (s != sequence) return;
            EXPECT_LT(i, count);
            ++times[i];
            if (truth(i)) *word |= bit;
        },
        [] {});
    Found found{{}, asked - 10};
    for (uint32_t i = 0; i < count; ++i) {
        EXPECT_LE(times[i], 1) << "asked twice";
        found.visible.push_back(core::many_lights::getBit(sampling.visible(sequence), i));
        if (times[i] > 0) {
            EXPECT_EQ(found.visible[i], truth(i));
        }
    }
    EXPECT_EQ(core::many_lights::countBits(sampling.visible(0)), 0u);
    return found;
}

TEST(VisibilitySampling, WhatIsAlikeTakesFewQuestions)
{
    for (const bool lit : {false, true})
        for (const uint32_t count : {1u, 8u, 9u, 16u, 17u, 32u, 33u, 100u, 1000u}) {
            const Found found = sample(count, false, [=](uint32_t) { return lit; });
            EXPECT_EQ(found.visible, std::vector<bool>(count, lit)) << count;
            EXPECT_EQ(found.asked, count <= 8 ? count : count <= 16 ? 4u : count <= 32 ? 8u : 16u);
        }
}

TEST(VisibilitySampling, OneEdgeIsFoundExactly)
{
    for (const uint32_t count : {40u, 200u, 3000u})
        for (uint32_t edge = 1; edge < count; edge += 1 + count / 50) {
            const Found found = sample(count, false, [=](uint32_t i) { return i < edge; });
            for (uint32_t i = 0; i < count; ++i) ASSERT_EQ(found.visible[i], i < edge);
            if (count == 3000) {
                EXPECT_LT(found.asked, 16u * 30);
            }
        }
}

/// A shadow that no sample meets is missed, by design; asked in full it is not.
TEST(VisibilitySampling, NarrowShadowsAreMissedUnlessAllAreAsked)
{
    const auto truth = [](uint32_t i) { return i != 37; };
    EXPECT_TRUE(sample(1000, false, truth).visible[37]);
    const Found whole = sample(1000, true, truth);
    EXPECT_FALSE(whole.visible[37]);
    EXPECT_EQ(whole.asked, 1000u);
}

TEST(VisibilitySampling, AnyPatternEnds)
{
    for (const uint32_t period : {2u, 3u, 5u, 7u, 31u}) {
        const Found found = sample(1237, false, [=](uint32_t i) { return i % period != 0; });
        EXPECT_LE(found.asked, 1237u);
    }
}

}  // namespace
