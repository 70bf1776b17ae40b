// The hierarchy over poses: refitted and rebuilt trees are as sound as new ones and find the same
// hits, the still triangles' tree stays the same storage, and the hierarchy of a world is made
// once.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include <glm/gtc/matrix_transform.hpp>

#include "core/base/check.h"
#include "core/gltf/gltf.h"
#include "core/trace/world_bvh.h"
#include "tests/support/scenes/bvh_walk.h"
#include "tests/support/scenes/meshes.h"
#include "tests/support/scenes/test_scenes.h"

namespace {

using core::Bvh;
using core::BvhOptions;
using glm::vec3;
using tests::bvhOf;
using tests::expectSound;
using tests::Mesh;

/// A room, and in the midst of its list of triangles a ball and a soup that move.
struct Moving {
    Mesh mesh;
    BvhOptions options;
    uint32_t firstVertex = 0, endVertex = 0;

    explicit Moving(bool alone = false)
    {
        if (!alone) append(tests::roomMesh(3));
        options.moving.begin = static_cast<uint32_t>(mesh.triangles.size());
        firstVertex = static_cast<uint32_t>(mesh.positions.size());
        append(tests::sphereMesh(24, 0.4f, 0.1f, {0, 1, 0}));
        append(tests::soupMesh(500, 0.1f, 5));
        options.moving.end = static_cast<uint32_t>(mesh.triangles.size());
        endVertex = static_cast<uint32_t>(mesh.positions.size());
        if (!alone) append(tests::roomMesh(4));
        options.reachLow = vec3(-20);
        options.reachHigh = vec3(20);
    }

    /// The mesh with its moving vertices mapped.
    template <class Map> Mesh posed(const Map& map) const
    {
        Mesh moved = mesh;
        for (uint32_t v = firstVertex; v < endVertex; ++v)
            moved.positions[v] = map(moved.positions[v]);
        return moved;
    }

private:
    void append(const Mesh& other)
    {
        const uint32_t first = static_cast<uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
        for (core::WorldTriangle t : other.triangles) {
            t.v0 += first;
            t.v1 += first;
            t.v2 += first;
            mesh.triangles.push_back(t);
        }
    }
};

vec3 turned(vec3 p)
{
    const glm::dmat4 m = glm::translate(glm::dmat4(1), glm::dvec3(1.3, -0.2, 0.7)) *
                         glm::rotate(glm::dmat4(1), 1.1, glm::normalize(glm::dvec3(1, 2, 3)));
    return vec3(m * glm::dvec4(glm::dvec3(p), 1));
}

/// Scattered by a hash of the place: neighbours fly apart.
vec3 scattered(vec3 p)
{
    const vec3 cell = glm::floor(p * 8.0f);
    return p + vec3(std::sin(17 * cell.y + 3 * cell.z), std::sin(13 * cell.z + 5 * cell.x),
                    std::sin(11 * cell.x + 7 * cell.y));
}

/// Both find the same distances, to the bit: the triangle test does not know of boxes. Returns how
/// many rays hit something.
int expectSameHits(const Mesh& mesh, const Bvh& a, const Bvh& b, int rays)
{
    std::mt19937 engine(9);
    std::uniform_real_distribution<float> uniform(-1, 1);
    const auto random = [&] { return vec3(uniform(engine), uniform(engine), uniform(engine)); };
    int hits = 0;
    for (int i = 0; i < rays; ++i) {
        const vec3 origin = 3.0f * random();
        const vec3 target =
            i % 2 == 0 ? mesh.positions[engine() % mesh.positions.size()] : 2.0f * random();
        const vec3 direction = target - origin + 0.01f * random();
        core::BvhHit x, y;
        const bool hitX = core::traceClosest(a, mesh.positions, mesh.triangles, origin, direction,
                                             0, shared::kInfinity, x);
        const bool hitY = core::traceClosest(b, mesh.positions, mesh.triangles, origin, direction,
                                             0, shared::kInfinity, y);
        EXPECT_EQ(hitX, hitY) << "ray " << i;
        EXPECT_EQ(x.t, y.t) << "ray " << i;
        EXPECT_EQ(hitX, core::traceAny(a, mesh.positions, mesh.triangles, origin, direction, 0,
                                       shared::kInfinity));
        hits += hitX;
    }
    return hits;
}

TEST(BvhRefit, IsSoundAndFindsWhatANewOneFinds)
{
    for (const bool alone : {false, true}) {
        SCOPED_TRACE(alone);
        const Moving scene(alone);
        const Bvh first = bvhOf(scene.mesh, scene.options);
        expectSound(scene.mesh, first, scene.options);
        for (vec3 (*map)(vec3) : {turned, scattered}) {
            const Mesh moved = scene.posed(map);
            const auto refitted = core::refitBvh(first, moved.positions, moved.triangles);
            ASSERT_TRUE(refitted.has_value());
            expectSound(moved, *refitted, scene.options);
            EXPECT_TRUE(refitted->still.nodes.sharesWith(first.still.nodes));
            EXPECT_TRUE(refitted->still.slots.sharesWith(first.still.slots));
            EXPECT_TRUE(refitted->moving.slots.sharesWith(first.moving.slots));
            EXPECT_EQ(refitted->nodeCount(), first.nodeCount());
            const Bvh fresh = bvhOf(moved, {});
            EXPECT_GT(expectSameHits(moved, *refitted, fresh, 4000), 1000);
            const auto rebuilt =
                core::rebuildMoving(first, moved.positions, moved.triangles, scene.options);
            ASSERT_TRUE(rebuilt.has_value());
            expectSound(moved, *rebuilt, scene.options);
            EXPECT_TRUE(rebuilt->still.nodes.sharesWith(first.still.nodes));
            expectSameHits(moved, *rebuilt, fresh, 1000);
        }
    }
}

/// The pose that it was built for gives its own boxes back.
TEST(BvhRefit, ChangesNothingWhereNothingMoved)
{
    for (const bool alone : {false, true}) {
        const Moving scene(alone);
        const Bvh built = bvhOf(scene.mesh, scene.options);
        const auto refitted = core::refitBvh(built, scene.mesh.positions, scene.mesh.triangles);
        ASSERT_TRUE(refitted.has_value());
        EXPECT_EQ(refitted->moving.nodes, built.moving.nodes);
        EXPECT_NEAR(refitted->cost, built.cost, 1e-4f * built.cost);
        EXPECT_NEAR(core::looseness(*refitted), 1, 1e-6);
        EXPECT_NEAR(core::looseness(built), 1, 1e-12);
    }
}

TEST(BvhRefit, FewMovingTriangles)
{
    for (const uint32_t count : {1u, 2u, 9u}) {
        for (const uint32_t others : {0u, 1u, 20u}) {
            SCOPED_TRACE(testing::Message() << count << " move, " << others << " do not");
            Mesh mesh = tests::soupMesh(count + others, 0.5f, 3);
            BvhOptions options;
            options.moving = {0, count};
            const Bvh built = bvhOf(mesh, options);
            expectSound(mesh, built, options);
            const vec3 fixed = mesh.positions[0];  // towards it, so that all stays on the grid
            for (uint32_t v = 0; v < 3 * count; ++v)
                mesh.positions[v] = fixed + 0.8f * (mesh.positions[v] - fixed);
            const auto refitted = core::refitBvh(built, mesh.positions, mesh.triangles);
            ASSERT_TRUE(refitted.has_value());
            expectSound(mesh, *refitted, options);
            expectSameHits(mesh, *refitted, bvhOf(mesh, {}), 300);
        }
    }
}

TEST(BvhRefit, RefusesWhatLeavesTheGrid)
{
    const Moving scene;
    const Bvh built = bvhOf(scene.mesh, scene.options);
    const Mesh moved = scene.posed([](vec3 p) { return p + vec3(1000, 0, 0); });
    EXPECT_FALSE(core::refitBvh(built, moved.positions, moved.triangles).has_value());
    EXPECT_FALSE(
        core::rebuildMoving(built, moved.positions, moved.triangles, scene.options).has_value());
}

/// Looseness tells motion that the tree suits from motion that it does not.
TEST(BvhRefit, LoosenessSeesWhatATreeLoses)
{
    const Moving scene(true);
    const Bvh built = bvhOf(scene.mesh, scene.options);
    const auto looseAfter = [&](const auto& map) {
        const Mesh moved = scene.posed(map);
        return core::looseness(*core::refitBvh(built, moved.positions, moved.triangles));
    };
    EXPECT_NEAR(looseAfter([](vec3 p) { return p + vec3(0.5f, 0, 0); }), 1, 0.01);
    EXPECT_NEAR(looseAfter([](vec3 p) { return 0.25f * p; }), 1, 0.01);
    EXPECT_LT(looseAfter(turned), 1.6);

    // Triangles that keep their size but not their neighbours.
    Mesh soup = tests::soupMesh(3000, 0.05f, 5);
    ASSERT_EQ(soup.positions.size(), 3 * soup.triangles.size());
    BvhOptions options;
    options.moving = {0, 3000};
    options.reachLow = vec3(-1);
    options.reachHigh = vec3(2);
    const Bvh packed = bvhOf(soup, options);
    for (size_t v = 0; v < soup.positions.size(); ++v) {
        const float triangle = static_cast<float>(v / 3);
        soup.positions[v] +=
            0.5f * vec3(std::sin(17 * triangle), std::sin(13 * triangle), std::sin(11 * triangle));
    }
    const auto refitted = core::refitBvh(packed, soup.positions, soup.triangles);
    ASSERT_TRUE(refitted.has_value());
    EXPECT_GT(core::looseness(*refitted), 1.5);
    const auto rebuilt = core::rebuildMoving(*refitted, soup.positions, soup.triangles, options);
    ASSERT_TRUE(rebuilt.has_value());
    EXPECT_NEAR(core::looseness(*rebuilt), 1, 1e-9);
    EXPECT_LT(rebuilt->cost, 0.8f * refitted->cost);
}

std::shared_ptr<const core::World> animatedAt(double time = 0)
{
    return core::makeWorld(core::loadGltf(REKINDLE_SOURCE_DIR "/assets/animated.gltf"), time);
}

TEST(WorldBvh, IsMadeOncePerPoseAndRefitted)
{
    const auto world = animatedAt();
    EXPECT_EQ(core::bvhIfMade(*world), nullptr);
    const auto bvh = core::bvhOf(*world);
    EXPECT_EQ(core::bvhOf(*world), bvh);
    EXPECT_EQ(core::bvhIfMade(*world), bvh);
    const auto later = core::poseWorld(world, 0.7);
    ASSERT_TRUE(core::sameTopology(*world, *later));
    EXPECT_EQ(core::bvhIfMade(*later), nullptr);
    const auto refitted = core::bvhOf(*later);
    EXPECT_NE(refitted, bvh);
    EXPECT_TRUE(refitted->still.nodes.sharesWith(bvh->still.nodes));
    EXPECT_EQ(core::bvhIfMade(*world), nullptr) << "only the last pose's is kept";
    const std::vector<vec3> positions(later->positions.begin(), later->positions.end() - 1);
    expectSound({positions, later->triangles.toVector()}, *refitted, {});
}

TEST(WorldBvh, EndsWhenItIsToldTo)
{
    const auto world = tests::room(tests::lambert(vec3(0.5f)), tests::lambert(vec3(0.5f))).world();
    std::stop_source stop;
    stop.request_stop();
    EXPECT_THROW(core::bvhOf(*world, {}, stop.get_token()), core::Error);
    EXPECT_THROW(core::bvhOf(*world, [](double) { throw std::runtime_error("enough"); }),
                 std::runtime_error);
    EXPECT_EQ(core::bvhIfMade(*world), nullptr);
    EXPECT_GT(core::bvhOf(*world)->nodeCount(), 0u) << "a failure leaves the next one free";
}

}  // namespace
