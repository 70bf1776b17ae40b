// T-37: the candidates among which the direction of a new path is chosen are each drawn as one
// direction is, and are spread more evenly than by chance.
#include "shared/reuse_new.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include "core/base/pcg32.h"
#include "tests/support/statistics/stats.h"

namespace {

glm::vec3 numbersOf(const shared::VertexNumbers& n)
{
    return {n.bsdf.x, n.bsdf.y, n.lobe.x};
}

shared::VertexNumbers numbersAt(glm::vec3 u)
{
    shared::VertexNumbers n{};
    n.bsdf = {u.x, u.y};
    n.lobe = {u.z, 0.75f};
    return n;
}

/// On a torus.
float distanceOf(glm::vec3 a, glm::vec3 b)
{
    const glm::vec3 d = glm::abs(a - b);
    return glm::length(glm::min(d, 1.0f - d));
}

TEST(ReuseCandidates, EachIsSpreadEvenly)
{
    constexpr int kSide = 6, kSamples = 200'000;
    const double level = tests::sidak(1e-4, 4);
    for (const uint32_t t : {0u, 1u, 3u, 31u}) {
        core::Pcg32 random(7, t);
        std::array<double, kSide * kSide * kSide> counts{}, expected;
        expected.fill(double(kSamples) / double(expected.size()));
        for (int i = 0; i < kSamples; ++i) {
            const auto unit = [&] { return static_cast<float>(random.bits() >> 8) * 0x1p-24f; };
            const float x = unit(), y = unit(), z = unit();
            const glm::vec3 first(x, y, z);
            const shared::VertexNumbers n = shared::candidateNumbers(numbersAt(first), t);
            ASSERT_EQ(n.lobe.y, 0.75f);
            const glm::vec3 u = numbersOf(n);
            ASSERT_TRUE(glm::all(glm::greaterThanEqual(u, glm::vec3(0))) &&
                        glm::all(glm::lessThan(u, glm::vec3(1))));
            const glm::ivec3 cell(u * float(kSide));
            ++counts[size_t((cell.x * kSide + cell.y) * kSide + cell.z)];
        }
        EXPECT_GT(tests::chiSquareTest(counts, expected).p, level) << "candidate " << t;
    }
}

TEST(ReuseCandidates, KeepTheirDistance)
{
    // Mean distance of the closest two of as many independent points: .29, .18, .071.
    const std::array<std::pair<uint32_t, float>, 3> least{{{4, 0.5f}, {8, 0.3f}, {32, 0.22f}}};
    for (const auto& [count, distance] : least) {
        float closest = 1;
        for (uint32_t a = 0; a < count; ++a)
            for (uint32_t b = 0; b < a; ++b) {
                const shared::VertexNumbers first = numbersAt({0.3f, 0.9f, 0.6f});
                closest =
                    std::min(closest, distanceOf(numbersOf(shared::candidateNumbers(first, a)),
                                                 numbersOf(shared::candidateNumbers(first, b))));
            }
        EXPECT_GT(closest, distance) << count;
    }
}

}  // namespace
