// A guide that learns: where its leaves are, when it is used, and that it is the same on any number
// of threads; every representation of directions.
#include "core/guiding/guide.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/pcg32.h"
#include "core/guiding/lesson.h"
#include "tests/support/methods/guide_kinds.h"

namespace {

using core::Pcg32;
using core::guiding::Guide;
using core::guiding::GuideOptions;
using core::guiding::GuideTables;
using core::guiding::PathRecords;
using glm::uvec4;
using glm::vec3;
using tests::nameOfKind;

constexpr float kUniformPdf = 0.25f * float(std::numbers::inv_pi);

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
        record.pdf = record.bsdfPdf = kUniformPdf;
        record.beta = 1;
        record.place = random.bits() % 3;
        PathRecords& part = parts[i * kParts / count];
        part.records.push_back(record);
        part.ends.push_back({1, light(record.position, wi) / kUniformPdf, 0});
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
            // A tree begins with cells as large as the lamp.
            const float most = GetParam() == shared::kGuideTree ? 0.8f : 0.6f;
            EXPECT_LE(share(useful), tested ? most : 1.0f);
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
        EXPECT_TRUE(reflected == 0 || std::abs(reflected * kUniformPdf - 1) < 1e-4f);
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, GuideLearning,
                         testing::Values(shared::kGuideHistogram, shared::kGuideLobes,
                                         shared::kGuideTree),
                         nameOfKind);

/// One tree for all normals, cut in the middle of the box along x, y, z, x, ... until each leaf has
/// few of the last records; the counts of sibling leaves together are those of their parent.
TEST(GuideSpaces, PlainTreesAreCutInTheMiddle)
{
    GuideOptions options;
    options.space = core::guiding::GuideSpace::plain;
    options.memory = core::guiding::GuideMemory::reset;
    options.box = {vec3(0), 1};
    options.recordsPerLeaf = 600;
    Guide guide(options);
    for (uint64_t k = 1; k <= 3; ++k) {
        guide.learn(pathsTo(size_t(4000) << k, k, anywhere, lamp), std::pow(2.0, double(k)) - 1);
        const GuideTables& tables = *guide.tables();
        for (uint32_t root = 1; root < shared::kGuideRoots; ++root)
            EXPECT_EQ(shared::findGuideLeaf(tables.view(), vec3(0.3f), root),
                      shared::findGuideLeaf(tables.view(), vec3(0.3f), 0));
        const uvec4 first = tables.nodes.at(shared::kGuideRootWords);
        EXPECT_EQ(shared::uintAsFloat(first.x), 0.5f);
        EXPECT_EQ(first.y, 0u);
        const uvec4 second = tables.nodes.at(first.z);
        EXPECT_EQ(shared::uintAsFloat(second.x), 0.5f);
        EXPECT_EQ(second.y, 1u);
        // 4000 2^k records, leaves of 600 sqrt(2 2^(k-1)): the next power of two of leaves.
        const double leaves = double(4000 << k) / (600 * std::sqrt(std::pow(2.0, double(k))));
        EXPECT_EQ(tables.leaves.size(), std::bit_ceil(uint32_t(leaves)));
    }
}

/// So many cuts whatever the records, where there are any.
TEST(GuideSpaces, DepthMayBeFixed)
{
    for (const uint32_t depth : {0u, 3u, 6u}) {
        GuideOptions options;
        options.space = core::guiding::GuideSpace::plain;
        options.box = {vec3(0), 1};
        options.recordsPerLeaf = 0;
        options.depth = depth;
        Guide guide(options);
        guide.learn(pathsTo(8000, 1, anywhere, lamp), 1);
        EXPECT_EQ(guide.tables()->leaves.size(), 1u << depth);
        guide.learn(pathsTo(8000, 2, anywhere, lamp), 2);
        EXPECT_EQ(guide.tables()->leaves.size(), 1u << depth);
    }
}

/// A lamp that is seen from one half of the room: with the filter some of what is learnt there is
/// known beyond the middle, by as much as the overlap of the leaves' sizes says.
TEST(GuideSpaces, FilterSpreadsRecordsOverTheirLeafsSize)
{
    const auto left = [](vec3 p, vec3) { return p.x < 0.5f ? 1.0f : 0.0f; };
    for (const bool spread : {false, true}) {
        GuideOptions options;
        options.space = core::guiding::GuideSpace::plain;
        options.box = {vec3(0), 1};
        options.recordsPerLeaf = 0;
        options.depth = 1;
        if (spread) options.filter = core::guiding::GuideFilter::spread;
        Guide guide(options);
        // The first lesson cuts the tree, the second is spread over leaves of half the room.
        guide.learn(pathsTo(20000, 1, anywhere, left), 1);
        const auto before = guide.tables();
        guide.learn(pathsTo(20000, 2, anywhere, left), 2);
        const GuideTables& tables = *guide.tables();
        const uint32_t leaf = shared::findGuideLeaf(tables.view(), vec3(0.75f), 0);
        const double mean = double(shared::uintAsFloat(tables.leaves[leaf].z));
        // In the first lesson the leaf was the room: moved by up to half of it, 3/8 of the light
        // is beyond the middle. In the second it is an eighth of the light of its side.
        const double own = 0.5 * (0.25 + 0.125) / double(kUniformPdf);
        EXPECT_NEAR(mean * double(kUniformPdf), spread ? own * double(kUniformPdf) : 0,
                    spread ? 0.04 : 1e-9);
    }
}

/// Every record asks for a leaf of its own: there are only so many.
TEST(GuideTree, StaysWithinItsMemory)
{
    GuideOptions options;
    options.recordsPerLeaf = 0;
    Guide guide(options);
    for (uint64_t k = 1; k <= 3; ++k) guide.learn(pathsTo(60000, k, anywhere, lamp), double(k));
    EXPECT_LE(guide.figures().leaves, 1u << 15);
    EXPECT_GT(guide.figures().leaves, 1000u);
}

/// The guide is ten thousand times as dense as the BSDF where all light comes from: without a bound
/// so little would be left to the BSDF that what divides by it grows without end.
TEST(GuideShares, LearntOnesLeaveSomethingToTheBsdf)
{
    GuideOptions options;
    options.shareBy = core::guiding::ShareBy::adam;
    options.recordsPerLeaf = 1e9f;
    Guide guide(options);
    core::guiding::Lesson lesson;
    lesson.value = 1e6f;
    lesson.direction = vec3(0, 0, 1);
    lesson.pdf = 1;
    lesson.bsdfPdf = 0.01f;
    lesson.guidePdf = 100;
    const std::vector<core::guiding::Lesson> lessons(40000, lesson);
    for (int k = 1; k <= 2; ++k) guide.learn(lessons, k);
    const auto shareOf = [&](size_t leaf) {
        return shared::uintAsFloat(guide.tables()->leaves.at(leaf).y);
    };
    EXPECT_LT(shareOf(0), 0.01f) << "nothing was learnt";
    for (size_t leaf = 0; leaf < guide.figures().leaves; ++leaf) EXPECT_GE(shareOf(leaf), 1e-3f);
}

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
