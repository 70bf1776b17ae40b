// A guide that learns: where its leaves are, when it is used, and that it is the same on any number
// of threads; both representations of directions.
#include "core/guiding/guide.h"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/pcg32.h"

namespace {

using core::Pcg32;
using core::guiding::Guide;
using core::guiding::GuideOptions;
using core::guiding::GuideTables;
using core::guiding::PathRecords;
using glm::uvec4;
using glm::vec3;

constexpr float kUniform = 0.25f * float(std::numbers::inv_pi);

vec3 anyDirection(Pcg32& random)
{
    const double z = 1 - 2 * random(), turn = 2 * std::numbers::pi * random();
    const double across = std::sqrt(1 - z * z);
    return vec3(across * std::cos(turn), across * std::sin(turn), z);
}

/// Paths of one vertex each that went anywhere; `light(position, direction)` is what they found.
template <class Place, class Light>
std::vector<PathRecords> pathsTo(size_t count, uint64_t seed, const Place& place,
                                 const Light& light)
{
    constexpr size_t kParts = 20;
    Pcg32 random(seed);
    std::vector<PathRecords> parts(kParts);
    for (size_t i = 0; i < count; ++i) {
        shared::GuideRecord record{};
        record.position = place(random);
        const vec3 wi = anyDirection(random);
        record.direction = shared::packOct(wi);
        record.pdf = record.bsdfPdf = kUniform;
        record.beta = 1;
        record.place = random.bits() % 3;
        PathRecords& part = parts[i * kParts / count];
        part.records.push_back(record);
        part.ends.push_back({1, light(record.position, wi) / kUniform});
    }
    return parts;
}

vec3 anywhere(Pcg32& random)
{
    const double x = random(), y = random();
    return vec3(x, y, random());
}

/// Light from a small part of the sphere, brighter on one side of the room.
float lamp(vec3 p, vec3 wi)
{
    return std::exp(50 * (wi.z - 1)) * (1 + p.x);
}

float sameEverywhere(vec3, vec3)
{
    return 1;
}

class GuideLearning : public testing::TestWithParam<uint32_t> {
protected:
    GuideOptions options() const
    {
        GuideOptions options;
        options.kind = GetParam();
        options.leastShare = core::guiding::leastShareOf(GetParam());
        return options;
    }
};

template <class T> bool sameBytes(const std::vector<T>& a, const std::vector<T>& b)
{
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

TEST_P(GuideLearning, IsTheSameForAnyNumberOfThreads)
{
    const auto learnt = [&](size_t threads) {
        const core::ThreadLimit limit(threads);
        Guide guide(options());
        for (uint64_t k = 1; k <= 3; ++k) guide.learn(pathsTo(8000, k, anywhere, lamp), double(k));
        return guide.tables();
    };
    const auto one = learnt(1), many = learnt(4);
    EXPECT_GT(one->leaves.size(), 12u);
    EXPECT_TRUE(sameBytes(one->nodes, many->nodes));
    EXPECT_TRUE(sameBytes(one->leaves, many->leaves));
    EXPECT_TRUE(sameBytes(one->directions, many->directions));
}

/// Nine in ten records lie in a thousandth of the room: so do most leaves.
TEST_P(GuideLearning, LeavesAreWhereRecordsAre)
{
    const auto crowded = [](Pcg32& random) {
        const bool corner = random() < 0.9;
        return anywhere(random) * (corner ? 0.1f : 1.0f);
    };
    Guide guide(options());
    for (uint64_t k = 1; k <= 2; ++k) guide.learn(pathsTo(20000, k, crowded, lamp), double(k));
    const GuideTables& tables = *guide.tables();
    std::vector<bool> seen(tables.leaves.size());
    Pcg32 random(5);
    size_t inCorner = 0, all = 0;
    for (int i = 0; i < 40000; ++i) {
        const bool corner = i < 20000;
        const vec3 p = anywhere(random) * (corner ? 0.1f : 1.0f);
        const uint32_t leaf = shared::findGuideLeaf(tables.view(), p, uint32_t(i) % 3);
        if (seen.at(leaf)) continue;
        seen[leaf] = true;
        ++all;
        inCorner += corner ? 1u : 0u;
    }
    EXPECT_GT(all, 30u);
    EXPECT_GT(double(inCorner), 0.8 * double(all));
    const double limit = double(options().recordsPerLeaf) * std::sqrt(2.0 * 2);
    double visits = 0;
    for (uint32_t leaf = 0; leaf < tables.leaves.size(); ++leaf) {
        EXPECT_LE(guide.visits(leaf), limit);
        visits += guide.visits(leaf);
    }
    EXPECT_NEAR(visits, 40000, 0.01);  // children share what their parent had
}

TEST_P(GuideLearning, IsUsedOnlyWhereItPays)
{
    Guide useful(options()), idle(options());
    for (uint64_t k = 1; k <= 3; ++k) {
        useful.learn(pathsTo(8000, k, anywhere, lamp), double(k));
        idle.learn(pathsTo(8000, k, anywhere, sameEverywhere), double(k));
        const float least = options().leastShare;
        for (uint32_t root = 0; root < shared::kGuideRoots; ++root) {
            const vec3 p(0.3f);
            const auto share = [&](const Guide& guide) {
                const GuideTables& tables = *guide.tables();
                const uint32_t leaf = shared::findGuideLeaf(tables.view(), p, root);
                return shared::uintAsFloat(tables.leaves[leaf].y);
            };
            EXPECT_EQ(share(idle), 1);
            // The first lessons make a guide, the second test it; three roots have none.
            const bool tested = k > 1 && root < 3;
            EXPECT_EQ(share(useful) < 1, tested);
            EXPECT_GE(share(useful), least);
            EXPECT_LE(share(useful), tested ? 0.6f : 1.0f);
        }
    }
}

/// Light that a perfect guide would take a twelfth of the second moment from: less than the gate.
TEST_P(GuideLearning, GateStopsSmallGains)
{
    const auto faint = [](vec3, vec3 wi) { return 1 + 0.5f * wi.z; };
    GuideOptions open = options();
    open.gate = 0.5f;
    Guide gated(options()), opened(open);
    for (uint64_t k = 1; k <= 4; ++k) {
        gated.learn(pathsTo(40000, k, anywhere, faint), double(k));
        opened.learn(pathsTo(40000, k, anywhere, faint), double(k));
    }
    size_t guided = 0;
    for (const uvec4& leaf : gated.tables()->leaves) EXPECT_EQ(shared::uintAsFloat(leaf.y), 1);
    for (const uvec4& leaf : opened.tables()->leaves)
        guided += shared::uintAsFloat(leaf.y) < 1 ? 1u : 0u;
    EXPECT_GT(guided, 0u);
}

TEST_P(GuideLearning, KnowsWhatAPlaceReflects)
{
    Guide guide(options());
    guide.learn(pathsTo(20000, 1, anywhere, sameEverywhere), 1);
    for (const uvec4& leaf : guide.tables()->leaves) {
        const float reflected = shared::uintAsFloat(leaf.z);
        EXPECT_TRUE(reflected == 0 || std::abs(reflected * kUniform - 1) < 1e-4f);
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, GuideLearning,
                         testing::Values(shared::kGuideHistogram, shared::kGuideLobes),
                         [](const auto& kind) {
                             return kind.param == shared::kGuideLobes ? "lobes" : "histogram";
                         });

/// Two planes below one root, none below the others: what lies on a plane is above it.
TEST(GuideTree, FindsTheLeafOfAPlace)
{
    const auto leaf = [](uint32_t index) { return index | shared::kGuideLeafBit; };
    GuideTables tables;
    tables.nodes = {{leaf(0), leaf(1), leaf(2), 2},
                    {leaf(6), leaf(7), 0, 0},
                    {shared::floatAsUint(0.5f), 2, leaf(3), 3},
                    {shared::floatAsUint(-1.0f), 1, leaf(4), leaf(5)}};
    const auto at = [&](vec3 p, uint32_t root) {
        return shared::findGuideLeaf(tables.view(), p, root);
    };
    const vec3 p(9, -2, 0.4f);
    EXPECT_EQ(at(p, 0), 0u);
    EXPECT_EQ(at(p, 1), 1u);
    EXPECT_EQ(at(p, 2), 2u);
    EXPECT_EQ(at(p, 4), 6u);
    EXPECT_EQ(at(p, 5), 7u);
    EXPECT_EQ(at(p, 3), 3u);
    EXPECT_EQ(at({9, -2, 0.5f}, 3), 4u);
    EXPECT_EQ(at({9, -1, 0.5f}, 3), 5u);
    EXPECT_EQ(at({-9, 3, 7}, 3), 5u);
}

TEST(GuideTree, RootIsTheNormalsLargestAxis)
{
    EXPECT_EQ(shared::guideRoot({0.9f, 0.1f, -0.2f}), 0u);
    EXPECT_EQ(shared::guideRoot({-0.9f, 0.1f, -0.2f}), 1u);
    EXPECT_EQ(shared::guideRoot({0.1f, 0.8f, -0.2f}), 2u);
    EXPECT_EQ(shared::guideRoot({0.1f, -0.8f, -0.2f}), 3u);
    EXPECT_EQ(shared::guideRoot({0.1f, 0.2f, 0.7f}), 4u);
    EXPECT_EQ(shared::guideRoot({0.1f, 0.2f, -0.7f}), 5u);
}

}  // namespace
