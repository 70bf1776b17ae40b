// M9. The light tree and its cuts: structure, bounds that bound, and clusters whose mean over trees
// is the sum over all lights.
#include "core/many_lights/light_cut.h"

#include <random>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/statistics/stats.h"

namespace core::many_lights {
namespace {

using glm::vec3;

struct Random {
    std::mt19937 engine;
    std::uniform_real_distribution<float> uniform;
    std::normal_distribution<float> normal;

    explicit Random(uint32_t seed) : engine(seed) {}
    float number() { return uniform(engine); }
    vec3 inBox() { return vec3(number(), number(), number()) * 2.0f - 1.0f; }
    vec3 direction()
    {
        return glm::normalize(vec3(normal(engine), normal(engine), normal(engine)));
    }
};

/// Lights of all kinds, of very different brightness, some of them in clumps.
std::vector<VirtualLight> someLights(uint32_t count, uint32_t seed)
{
    Random random(seed);
    std::vector<VirtualLight> lights(count);
    vec3 clump = random.inBox(), facing = random.direction();
    for (uint32_t i = 0; i < count; ++i) {
        if (i % 16 == 0) {
            clump = random.inBox();
            facing = random.direction();
        }
        VirtualLight& l = lights[i];
        const float kind = random.number();
        l.kind = kind < 0.8f   ? LightKind::surface
                 : kind < 0.9f ? LightKind::point
                               : LightKind::directional;
        l.position = clump + 0.05f * random.inBox();
        l.normal = glm::normalize(facing + 0.2f * random.inBox());
        l.bothSides = l.kind == LightKind::surface && random.number() < 0.02f ? 1 : 0;
        l.intensity = std::pow(10.0f, -3 * random.number()) *
                      vec3(random.number(), random.number(), random.number());
        l.importance = shared::luminance(l.intensity);
    }
    return lights;
}

/// What a light contributes to a Lambertian receiver of albedo pi with nothing in between.
vec3 contribution(const VirtualLight& l, const vec3& x, const vec3& n, float clamp)
{
    if (l.kind == LightKind::directional)
        return l.intensity * std::max(0.0f, -glm::dot(n, l.normal));
    const vec3 d = l.position - x;
    const float d2 = glm::dot(d, d), cosine = std::max(0.0f, glm::dot(n, d)) / std::sqrt(d2);
    if (l.kind == LightKind::point) return l.intensity * cosine / d2;
    const float facing = -glm::dot(l.normal, d) / std::sqrt(d2);
    const float leaves = l.bothSides != 0 ? std::abs(facing) : std::max(0.0f, facing);
    return l.intensity * cosine * leaves / std::max(d2, clamp * clamp);
}

LightTree treeOf(std::span<const VirtualLight> lights, uint32_t seed)
{
    return *makeLightTree(lights, {0.1f, seed});
}

/// Indices of the lights below a node.
void collect(const LightTree& tree, uint32_t index, std::vector<uint32_t>& below)
{
    const LightNode& node = tree.nodes[index];
    if (node.isLeaf()) return below.push_back(node.representative);
    collect(tree, index + 1, below);
    collect(tree, node.right, below);
}

std::vector<uint32_t> lightsBelow(const LightTree& tree, uint32_t index)
{
    std::vector<uint32_t> below;
    collect(tree, index, below);
    return below;
}

TEST(LightTree, EveryLightIsOneLeafOfItsKind)
{
    const std::vector<VirtualLight> lights = someLights(3000, 1);
    const LightTree tree = treeOf(lights, 1);
    EXPECT_EQ(tree.nodes.size(), 2 * lights.size() - 3);
    std::set<uint32_t> all;
    for (uint32_t kind = 0; kind < kLightKinds; ++kind) {
        for (const uint32_t i : lightsBelow(tree, tree.roots[kind])) {
            EXPECT_EQ(uint32_t(lights[i].kind), kind);
            EXPECT_TRUE(all.insert(i).second);
        }
    }
    EXPECT_EQ(all.size(), lights.size());
}

TEST(LightTree, NodesSayWhatIsBelowThem)
{
    const std::vector<VirtualLight> lights = someLights(300, 2);
    const LightTree tree = treeOf(lights, 1);
    for (uint32_t index = 0; index < tree.nodes.size(); ++index) {
        const std::vector<uint32_t> below = lightsBelow(tree, index);
        const LightNode& node = tree.nodes[index];
        ASSERT_EQ(node.count, below.size());
        float importance = 0;
        for (const uint32_t i : below) {
            importance += lights[i].importance;
            ASSERT_TRUE(glm::all(glm::lessThanEqual(node.low, lights[i].position)));
            ASSERT_TRUE(glm::all(glm::greaterThanEqual(node.high, lights[i].position)));
            const bool around = lights[i].kind == LightKind::point || lights[i].bothSides != 0;
            ASSERT_GE(around ? -1.0f : glm::dot(node.axis, lights[i].normal), node.cosHalf);
        }
        ASSERT_NEAR(node.importance, importance, 1e-4f * importance);
        ASSERT_NE(std::find(below.begin(), below.end(), node.representative), below.end());
    }
}

/// Lights in one place with one normal cannot be told apart, and still are leaves.
TEST(LightTree, CoincidentLightsAreHalved)
{
    std::vector<VirtualLight> lights(1000);
    for (VirtualLight& l : lights) {
        l.normal = {0, 0, 1};
        l.intensity = vec3(1);
        l.importance = 1;
    }
    const LightTree tree = treeOf(lights, 1);
    EXPECT_EQ(tree.nodes.size(), 1999u);
    EXPECT_EQ(tree.nodes[0].count, 1000u);
    EXPECT_FLOAT_EQ(tree.nodes[0].importance, 1000);
}

/// 100,000 nodes and queries: what a node's lights contribute together never exceeds its bound.
TEST(LightTree, BoundsAreBounds)
{
    Random random(4);
    size_t tried = 0, positive = 0;
    double tightest = 0;
    while (tried < 100000) {
        const std::vector<VirtualLight> lights = someLights(200, 100 + uint32_t(tried));
        const LightTree tree = treeOf(lights, 1);
        for (uint32_t index = 0; index < tree.nodes.size(); ++index, ++tried) {
            const std::vector<uint32_t> below = lightsBelow(tree, index);
            CutQuery query;
            query.position = 1.5f * random.inBox();
            if (random.number() < 0.3f)  // near the lights, where bounds are hardest
                query.position = lights[below[0]].position + 0.1f * random.inBox();
            query.normal = random.direction();
            query.clampDistance = random.number() < 0.5f ? 0.0f : 0.3f * random.number();
            const float angle = random.number() < 0.5f ? 0.0f : random.number();
            query.cosHalf = std::cos(angle);
            query.sinHalf = std::sin(angle);
            // A receiver whose normal is in the query's cone.
            vec3 n = query.normal;
            const vec3 across = glm::cross(n, random.direction());
            if (glm::length(across) > 1e-3f)
                n = std::cos(angle) * n + std::sin(angle) * glm::normalize(across);
            double sum = 0;
            for (const uint32_t i : below)
                sum += double(shared::luminance(
                    contribution(lights[i], query.position, n, query.clampDistance)));
            const double bound =
                double(clusterBound(tree.nodes[index], lights[below[0]].kind, query));
            ASSERT_GE(bound, sum) << "node of " << below.size() << " lights";
            if (sum > 0) ++positive;
            if (std::isfinite(bound) && bound > 0) tightest = std::max(tightest, sum / bound);
        }
    }
    EXPECT_GT(positive, tried / 4);
    EXPECT_GT(tightest, 0.99) << "the bounds are never tight: are they the right ones?";
}

TEST(LightCut, HasAsManyClustersAsAskedForAndEveryLightInOne)
{
    const std::vector<VirtualLight> lights = someLights(2000, 5);
    const LightTree tree = treeOf(lights, 1);
    const CutQuery query{{0.1f, 0.2f, 0.3f}, {0, 1, 0}, 1, 0, 0.05f};
    CutMemory memory;
    std::vector<LightCluster> cut;
    for (const uint32_t wanted : {3u, 4u, 100u, 1999u, 2000u, 5000u}) {
        cutLightTree(tree, query, wanted, memory, cut);
        EXPECT_EQ(cut.size(), std::min<size_t>(wanted, lights.size()));
        uint32_t covered = 0;
        for (const LightCluster& c : cut) covered += tree.nodes[c.node].count;
        EXPECT_EQ(covered, lights.size());
    }
    for (const LightCluster& c : cut) EXPECT_EQ(c.scale, 1);
    cutLightTree({{}, {shared::kNone, shared::kNone, shared::kNone}}, query, 10, memory, cut);
    EXPECT_TRUE(cut.empty());
}

TEST(LightCut, DoesNotDependOnRepresentatives)
{
    const std::vector<VirtualLight> lights = someLights(2000, 6);
    const CutQuery query{{0.1f, 0.2f, 0.3f}, {0, 1, 0}, 1, 0, 0.05f};
    CutMemory memory;
    std::vector<LightCluster> one, other;
    cutLightTree(treeOf(lights, 1), query, 100, memory, one);
    cutLightTree(treeOf(lights, 2), query, 100, memory, other);
    ASSERT_EQ(one.size(), other.size());
    size_t different = 0;
    for (size_t i = 0; i < one.size(); ++i) {
        EXPECT_EQ(one[i].node, other[i].node);
        different += one[i].light != other[i].light ? 1u : 0u;
    }
    EXPECT_GT(different, 10u);
}

/// The clustered sum over 400 trees against the sum over all lights, at some receivers and in all
/// channels, with things in between that know nothing of clusters. `wrong`: clusters count their
/// lights instead of weighing them, which is biased.
double largestTreeScore(bool wrong)
{
    const std::vector<VirtualLight> lights = someLights(500, 7);
    const auto visible = [](const VirtualLight& l, const vec3& x) {
        return l.kind == LightKind::directional || std::sin(7 * (l.position.x - x.y)) > -0.3f;
    };
    constexpr int kTrees = 400;
    double largest = 0, total = 0;
    for (const vec3 x : {vec3(0.1f, 0.2f, 0.3f), vec3(-0.5f, 0, 0), vec3(1, 1, -1)}) {
        const CutQuery query{x, {0, 1, 0}, 1, 0, 0.2f};
        vec3 exact(0);
        for (const VirtualLight& l : lights)
            if (visible(l, x)) exact += contribution(l, x, query.normal, query.clampDistance);
        std::array<tests::Moments, 3> sums;
        CutMemory memory;
        std::vector<LightCluster> cut;
        for (int seed = 0; seed < kTrees; ++seed) {
            const LightTree tree = treeOf(lights, uint32_t(seed));
            cutLightTree(tree, query, 150, memory, cut);
            vec3 sum(0);
            for (const LightCluster& c : cut) {
                const VirtualLight& l = lights[c.light];
                const float scale = wrong ? float(tree.nodes[c.node].count) : c.scale;
                if (visible(l, x))
                    sum += scale * contribution(l, x, query.normal, query.clampDistance);
            }
            for (int i = 0; i < 3; ++i) sums[size_t(i)].add(double(sum[i]));
        }
        for (int i = 0; i < 3; ++i) {
            const tests::Moments& m = sums[size_t(i)];
            largest =
                std::max(largest, std::abs(m.mean() - double(exact[i])) /
                                      (std::sqrt(m.varianceOfMean()) + 1e-5 * double(exact[i])));
            total = std::max(total, std::sqrt(m.varianceOfMean()) / double(exact[i]));
        }
    }
    EXPECT_LT((4.21 + 2.33) * total, 0.1) << "underpowered";
    return largest;
}

TEST(LightCut, ClustersAreUnbiasedOverTrees)
{
    EXPECT_LT(largestTreeScore(false), tests::kScore);
    EXPECT_GT(largestTreeScore(true), tests::kScore) << "a planted bias was not seen";
}

TEST(LightCut, BoundsOfAllLightsAreThoseOfTheirLeaves)
{
    const std::vector<VirtualLight> lights = someLights(301, 5);
    const LightTree tree = treeOf(lights, 1);
    CutQuery query;
    query.position = vec3(0.2f, -0.1f, 0.3f);
    query.normal = glm::normalize(vec3(1, 2, -1));
    query.cosHalf = 0.8f;
    query.sinHalf = 0.6f;
    query.clampDistance = 0.1f;
    query.spread = 0.05f;
    std::vector<float> bounds(lights.size(), -1.0f);
    lightBounds(tree, query, bounds);
    uint32_t leaves = 0, lit = 0;
    for (const LightNode& node : tree.nodes) {
        if (!node.isLeaf()) continue;
        const uint32_t light = node.representative;
        EXPECT_EQ(bounds[light], clusterBound(node, lights[light].kind, query));
        ++leaves;
        lit += bounds[light] > 0 ? 1u : 0u;
    }
    EXPECT_EQ(leaves, lights.size());
    EXPECT_GT(lit, leaves / 4);
    EXPECT_LT(lit, leaves);
}

}  // namespace
}  // namespace core::many_lights
