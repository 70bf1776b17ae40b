// Meshes that deform (T38): closed forms at several instants, poses against worlds made at their
// time, bounds of the whole animation, mirrored joints, and what stays rigid.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "core/scene/animation.h"
#include "shared/warp.h"
#include "tests/support/scenes/deforming_scenes.h"

namespace {

using namespace tests;
using Path = core::AnimationChannel::Path;

constexpr Bends kWays[] = {{true, false}, {false, true}, {true, true}};
constexpr double kBendTimes[] = {0, 0.25, 1, 1.4, 0.6, 1.9, 0.6};

/// A strip alone.
SceneBuilder stripAlone(const Bends& bends)
{
    SceneBuilder b;
    addStrip(b, b.material(lambert(glm::vec3(0.5f))), bends);
    return b;
}

void expectStrip(const core::World& world, const Bends& bends, double time)
{
    ASSERT_EQ(world.positions.size(), 19u);
    ASSERT_EQ(world.attributes.size(), 19u) << "normals that bend are needed";
    for (size_t v = 0; v < 18; ++v) {
        const glm::dvec2 xy(v % 2 == 0 ? -0.2 : 0.2, 0.25 * static_cast<double>(v / 2));
        const StripVertex expected = stripVertex(bends, xy, time);
        const glm::dvec3 p = world.placement.toFile(glm::dvec3(world.positions[v]));
        EXPECT_LT(glm::distance(p, expected.position), 1e-6) << v << " at " << time;
        const glm::dvec3 n(shared::unpackOct(world.attributes[v].normal));
        EXPECT_LT(glm::distance(n, expected.normal), 2e-4) << v << " at " << time;
    }
}

TEST(Deformation, StripsFollowTheClosedForm)
{
    for (const Bends& bends : kWays) {
        SCOPED_TRACE(testing::Message() << bends.skin << bends.targets);
        SceneBuilder b = stripAlone(bends);
        std::shared_ptr<const core::World> world = b.world(0);
        for (const double time : kBendTimes) {
            expectStrip(*b.world(time), bends, time);
            world = core::poseWorld(world, time);
            expectStrip(*world, bends, time);
        }
    }
}

TEST(Deformation, PosesEqualFreshWorlds)
{
    std::vector<SceneBuilder> builders{deformingRoom()};
    for (const Bends& bends : kWays) builders.push_back(stripAlone(bends));
    for (const SceneBuilder& b : builders) {
        const auto start = b.world(0.3);
        std::shared_ptr<const core::World> world = start;
        for (const double time : kBendTimes) {
            SCOPED_TRACE(time);
            world = core::poseWorld(world, time);
            EXPECT_TRUE(core::sameTopology(*world, *start));
            expectSameWorld(*world, *core::makeWorld(start->scene, time, 0, start->placement));
        }
    }
}

/// Emitters are where their triangles are.
TEST(Deformation, LampsBendWithTheirTriangles)
{
    SceneBuilder b;
    addStrip(b, b.material(emitter(glm::vec3(1))), {true, true});
    const auto world = core::poseWorld(b.world(0), 1.4);
    ASSERT_EQ(world->emitters.size(), 16u);
    for (const shared::Emitter& e : world->emitters) {
        const core::WorldTriangle& t = world->triangles[e.slot];
        EXPECT_EQ(e.a, world->positions[t.v0]);
        EXPECT_EQ(e.b, world->positions[t.v1]);
        EXPECT_EQ(e.c, world->positions[t.v2]);
    }
}

/// At every sampled instant, and not much beyond where the strip is at any.
TEST(Deformation, ReachHoldsTheWholeAnimation)
{
    for (const Bends& bends : kWays) {
        SceneBuilder b = stripAlone(bends);
        const auto start = b.world(0);
        glm::vec3 low = start->boundsLow, high = start->boundsHigh;
        for (int i = 0; i <= 32; ++i) {
            const auto world = core::poseWorld(start, 2.0 * i / 32);
            low = glm::min(low, world->boundsLow);
            high = glm::max(high, world->boundsHigh);
        }
        const float slack = 1e-5f;
        EXPECT_TRUE(glm::all(glm::lessThanEqual(start->reachLow, low + slack)));
        EXPECT_TRUE(glm::all(glm::greaterThanEqual(start->reachHigh, high - slack)));
        EXPECT_LT(glm::length(start->reachHigh - start->reachLow), 2 * glm::length(high - low));
    }
}

/// Only what deforms pays: what is rigid in the same scene has the same bits as without.
TEST(Deformation, RigidMeshesStayAsTheyAre)
{
    SceneBuilder plain = movingRoom(), with = movingRoom();
    addStrip(with, with.material(lambert(glm::vec3(0.5f))), {true, true});
    const auto a = plain.world(0.7);
    const auto b = core::makeWorld(std::make_shared<core::Scene>(with.scene), 0.7, 0, a->placement);
    ASSERT_EQ(b->triangles.size(), a->triangles.size() + 16);
    ASSERT_EQ(b->movingTriangles.size(), a->movingTriangles.size() + 16);
    const auto holds = [&](const glm::vec3& p) {
        return std::find(b->positions.begin(), b->positions.end(), p) != b->positions.end();
    };
    for (const glm::vec3& p : a->positions) EXPECT_TRUE(holds(p));
}

core::Transform& transformOf(SceneBuilder& b, int node)
{
    return std::get<core::Transform>(b.scene.nodes[static_cast<size_t>(node)].local);
}

/// Joints that rest deform their mesh once, and nothing moves: not even with the mesh's own node.
TEST(Deformation, RestingJointsHoldTheMesh)
{
    SceneBuilder b = stripAlone({true, false});
    const core::AnimationChannel turned = b.scene.animations[0].channels[0];
    b.scene.animations.clear();
    auto& upper = transformOf(b, turned.node);
    const auto h = static_cast<double>(std::sqrt(0.5f));
    upper.rotation = {h, h, 0, 0};
    SceneBuilder rests = b;
    const auto still = rests.world();
    EXPECT_TRUE(still->movingTriangles.empty());
    const StripVertex top = stripVertex({true, false}, {-0.2, 2}, 1);
    EXPECT_LT(glm::distance(still->placement.toFile(glm::dvec3(still->positions[16])),
                            top.position - glm::dvec3(0.1, 0, 0)),
              1e-6);
    b.scene.nodes[0].local = core::Transform();
    animate(b.scene, {channelOf(0, Path::translation, {{0, 0, 0, 0}, {1, 0, 0, 0}})});
    const auto world = b.world();
    EXPECT_TRUE(world->movingTriangles.empty());
    EXPECT_EQ(core::poseWorld(world, 1)->positions, world->positions);
}

/// Along v, across the joint: perpendicular to x and to the normal; a mirror turns handedness.
TEST(Deformation, TangentsStayOnTheSurface)
{
    for (int way = 0; way < 4; ++way) {
        const Bends bends = kWays[way % 3];
        const bool mirrored = way == 3;
        SceneBuilder b = stripAlone(bends);
        if (mirrored) transformOf(b, b.scene.skins[0].joints[0]).scale.x = -1;
        b.scene.meshes[0].hasTangents = true;
        for (shared::VertexAttributes& a : b.scene.meshes[0].attributes)
            a.tangent = shared::packTangent(glm::vec3(0, 1, 0), -1);
        const auto scene = std::make_shared<const core::Scene>(b.scene);
        for (const double time : {0.0, 0.7, 1.5}) {
            const auto world = core::makeWorld(scene, time, shared::kFeatureNormalMaps);
            for (size_t v = 0; v < 18; ++v) {
                const glm::dvec2 xy(v % 2 == 0 ? -0.2 : 0.2, 0.25 * static_cast<double>(v / 2));
                const glm::dvec3 n = stripVertex(bends, xy, time).normal;
                const glm::vec4 t = shared::unpackTangent(world->attributes[v].tangent);
                EXPECT_LT(glm::distance(glm::dvec3(t.x, t.y, t.z), glm::dvec3(0, n.z, -n.y)), 2e-3)
                    << v << " at " << time;
                EXPECT_EQ(t.w, mirrored ? 1 : -1);
            }
        }
    }
}

/// A skeleton that mirrors turns the triangles over, so that fronts and normals stay outside; one
/// that stretches leaves normals perpendicular.
TEST(Deformation, MirroredJointsKeepFrontsAndNormals)
{
    SceneBuilder b = stripAlone({true, true});
    const int lower = b.scene.skins[0].joints[0];
    transformOf(b, lower).scale = {-1, 1, 3};
    for (const double time : {0.0, 0.4, 0.8}) {
        const auto world = b.world(time);
        ASSERT_EQ(world->triangles.size(), 16u);
        for (size_t i = 0; i < 16; ++i) {
            const core::WorldTriangle& t = world->triangles[i];
            const glm::vec3 a = world->positions[t.v0];
            const glm::vec3 n =
                glm::normalize(glm::cross(world->positions[t.v1] - a, world->positions[t.v2] - a));
            for (const uint32_t v : {t.v0, t.v1, t.v2}) {
                const float cosine = glm::dot(n, shared::unpackOct(world->attributes[v].normal));
                EXPECT_GT(cosine, i < 4 ? 1 - 1e-6f : 0.0f) << "the first four stay plane";
            }
        }
    }
}

/// What a joint of no size takes away comes back.
TEST(Deformation, VanishingJointsAreFlattenedAnew)
{
    SceneBuilder b = stripAlone({true, false});
    animate(b.scene, {channelOf(b.scene.skins[0].joints[2], Path::scale,
                                {{1, 1, 1, 0}, {0, 0, 0, 0}, {1, 1, 1, 0}},
                                core::AnimationChannel::Interpolation::step)});
    const auto world = b.world();
    const auto gone = core::poseWorld(world, 1);
    EXPECT_FALSE(core::sameTopology(*world, *gone));
    EXPECT_LT(gone->triangles.size(), 16u);
    expectSameWorld(*gone, *core::makeWorld(world->scene, 1, 0, world->placement));
    expectSameWorld(*core::poseWorld(gone, 1.9),
                    *core::makeWorld(world->scene, 1.9, 0, world->placement));
}

/// One mesh, two skins; and never an instance, however often it is used.
TEST(Deformation, MeshesAreSharedBySkins)
{
    SceneBuilder b = stripAlone({true, false});
    core::Skin other = b.scene.skins[0];
    other.joints = {b.node(glm::translate(glm::dmat4(1), {3, 0, 0}), {}), 0,
                    b.node(glm::translate(glm::dmat4(1), {3, 1, 0}), {})};
    const int node = b.node(glm::dmat4(2), {0});
    b.scene.nodes[static_cast<size_t>(node)].skin = 1;
    b.scene.skins.push_back(other);
    const auto world =
        core::makeWorld(std::make_shared<core::Scene>(b.scene), 1, 0, {}, core::Instancing::kept);
    EXPECT_TRUE(world->prototypes.empty());
    ASSERT_EQ(world->triangles.size(), 32u);
    EXPECT_EQ(world->movingTriangles.size(), 16u) << "the second one's joints rest";
    const uint32_t still = world->movingVertices.begin == 0 ? 18 : 0;
    for (uint32_t v = 0; v < 18; ++v) {
        const glm::dvec3 p = world->placement.toFile(glm::dvec3(world->positions[still + v]));
        const glm::dvec3 rest(v % 2 == 0 ? 2.8 : 3.2, 0.25 * (v / 2), 0);
        EXPECT_LT(glm::distance(p, rest), 1e-6) << v;
    }
}

/// Weights add up to 1 in single precision only: far from the middle that would be seen.
TEST(Deformation, FarFromTheMiddleNothingTrembles)
{
    SceneBuilder b = stripAlone({true, false});
    const int lower = b.scene.skins[0].joints[0];
    b.scene.animations[0].channels.pop_back();
    transformOf(b, lower).translation = {1e6, 0, 0};
    auto shape = std::make_shared<core::Deformation>(*b.scene.meshes[0].deformation);
    for (core::Influence& i : shape->influences)
        if (i.weight < 1) i.weight *= 1 + 1e-6f;
    b.scene.meshes[0].deformation = shape;
    b.quad({-1e6f, 0, 0}, {1e5f, 0, 0}, {0, 1e5f, 0}, 0);
    const auto world = b.world(0);
    const size_t moving = world->movingVertices.begin;
    ASSERT_EQ(world->movingVertices.size(), 18u);
    for (size_t v = 0; v < 18; ++v) {
        const glm::dvec3 p = world->placement.toFile(glm::dvec3(world->positions[moving + v]));
        EXPECT_NEAR(p.x, 1e6 + (v % 2 == 0 ? -0.2 : 0.2), 0.1) << v;
    }
}

TEST(Deformation, WeightsAreInterpolated)
{
    core::AnimationChannel channel;
    channel.path = Path::weights;
    EXPECT_TRUE(core::evaluateWeights(channel, 0).empty());
    EXPECT_TRUE(core::isConstant(channel));
    core::Keyframes keys{{1, 3}, {}, {0, 1, 2, 0, 1, 4}};
    const auto setKeys = [&] { channel.keys = std::make_shared<const core::Keyframes>(keys); };
    setKeys();
    EXPECT_EQ(core::evaluateWeights(channel, 0), (std::vector<double>{0, 1, 2}));
    EXPECT_EQ(core::evaluateWeights(channel, 1.5), (std::vector<double>{0, 1, 2.5}));
    EXPECT_EQ(core::evaluateWeights(channel, 9), (std::vector<double>{0, 1, 4}));
    EXPECT_FALSE(core::isConstant(channel));
    channel.interpolation = core::AnimationChannel::Interpolation::step;
    EXPECT_EQ(core::evaluateWeights(channel, 2.9), (std::vector<double>{0, 1, 2}));
    // Per key in-tangents, values, out-tangents: flat ones make the smooth step 3 t^2 - 2 t^3.
    channel.interpolation = core::AnimationChannel::Interpolation::cubicSpline;
    keys.weights = {0, 0, 1, 8, 0, 0, 0, 0, 2, 8, 0, 0};
    setKeys();
    const std::vector<double> smooth = core::evaluateWeights(channel, 1.5);
    ASSERT_EQ(smooth.size(), 2u);
    EXPECT_DOUBLE_EQ(smooth[0], 1.15625);
    EXPECT_EQ(smooth[1], 8);
    keys.weights = {0, 0, 1, 8, 0, 0, 0, 0, 1, 8, 0, 0};
    setKeys();
    EXPECT_TRUE(core::isConstant(channel));
    keys.weights[4] = 1;
    setKeys();
    EXPECT_FALSE(core::isConstant(channel)) << "it swings out between equal keys";
}

}  // namespace
