// T33: what a path remembers of its last vertex is near enough to what it was, and refraction is
// undone by the way back.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "shared/departure.h"

namespace {

TEST(Departure, KeepsTheNormal)
{
    std::mt19937 random(1);
    std::uniform_real_distribution<float> unit(0, 1);
    float farthest = 0;
    for (int i = 0; i < 1'000'000; ++i) {
        const glm::vec3 n = shared::sampleSphere({unit(random), unit(random)});
        glm::vec3 back;
        const uint32_t word = shared::packReceiver(n);
        ASSERT_EQ(word >> 24, 0u);
        ASSERT_TRUE(shared::unpackReceiver(word, back));
        farthest = std::max(farthest, glm::distance(n, back));
    }
    EXPECT_LT(farthest, 1.1e-3f);
    glm::vec3 none;
    EXPECT_FALSE(shared::unpackReceiver(shared::noDeparture(), none));
    EXPECT_FALSE(shared::unpackReceiver(shared::kAllSides, none));
}

TEST(Departure, KnowsTheScaleOfRadiance)
{
    const uint32_t start =
        shared::departFrom(shared::noDeparture(), shared::packReceiver({0, 1, 0}));
    EXPECT_EQ(shared::radianceScale(start), 1.0f);
    for (const float eta : {1.0f, 1.1f, 1.33f, 1.5f, 2.4f}) {
        const uint32_t inside = shared::refractDeparture(start, eta);
        EXPECT_NEAR(shared::radianceScale(inside) * eta * eta, 1.0f, 0.03f) << eta;
        EXPECT_EQ(shared::refractDeparture(inside, 1 / eta), start) << eta;
        // Another vertex changes the normal alone.
        const uint32_t next = shared::departFrom(inside, shared::kAllSides);
        EXPECT_EQ(shared::radianceScale(next), shared::radianceScale(inside));
    }
    uint32_t deep = start;  // the word ends, and nothing runs over
    for (int i = 0; i < 100; ++i) deep = shared::refractDeparture(deep, 2.4f);
    EXPECT_GT(shared::radianceScale(deep), 0.0f);
    EXPECT_EQ(deep & shared::kAllSides, start & shared::kAllSides);
}

}  // namespace
