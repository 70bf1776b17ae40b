// Poses: a world moved to another time equals one made there, shares with its predecessor what has
// not changed, and is made anew only where other triangles come into being.
#include <gtest/gtest.h>

#include <limits>

#include "core/gltf/gltf.h"
#include "core/scene/animation.h"
#include "tests/support/scenes/animated_scenes.h"

namespace {

using namespace tests;
using Path = core::AnimationChannel::Path;

std::shared_ptr<const core::Scene> sceneOf(const std::string& name)
{
    return core::loadGltf(REKINDLE_SOURCE_DIR "/assets/" + name + ".gltf");
}

std::shared_ptr<const core::World> fresh(const core::World& like, double time)
{
    return core::makeWorld(like.scene, time, 0, like.placement);
}

/// Back and forth, beyond both ends, twice at one time.
constexpr double kPoseTimes[] = {0.4, 0.4, 1.7, 0, 2.5, 0.9, 100, -3, 1.1};

void expectSequenceEqualsFreshWorlds(const std::shared_ptr<const core::World>& start)
{
    std::shared_ptr<const core::World> world = start;
    for (const double time : kPoseTimes) {
        SCOPED_TRACE(time);
        world = core::poseWorld(world, time);
        expectSameWorld(*world, *fresh(*start, time));
    }
}

TEST(WorldPose, SequencesEqualFreshWorlds)
{
    expectSequenceEqualsFreshWorlds(core::makeWorld(sceneOf("animated")));
    expectSequenceEqualsFreshWorlds(movingRoom().world());
    expectSequenceEqualsFreshWorlds(movingRoom().world(1.3));
}

/// Every bit that a renderer reads, under a texture, tangents, an environment.
TEST(WorldPose, SequencesEqualFreshWorldsUnderTextures)
{
    for (const char* name : {"textured-box", "sky"}) {
        auto scene = std::make_shared<core::Scene>(*sceneOf(name));
        for (size_t n = 0; n < scene->nodes.size(); ++n) {
            if (scene->nodes[n].meshes.empty()) continue;
            animate(*scene, {channelOf(static_cast<int>(n), Path::rotation,
                                       {{0, 0, 0, 1}, {0.5f, 0.5f, 0.5f, 0.5f}, {0, 0, 1, 0}})});
            break;
        }
        ASSERT_FALSE(scene->animations.empty());
        const auto world = core::makeWorld(scene);
        ASSERT_FALSE(world->movingTriangles.empty()) << name;
        expectSequenceEqualsFreshWorlds(world);
    }
}

TEST(WorldPose, SharesWhatDoesNotChange)
{
    auto scene = std::make_shared<core::Scene>(*sceneOf("textured-box"));
    int moved = -1;
    for (size_t n = 0; n < scene->nodes.size() && moved < 0; ++n)
        moved = scene->nodes[n].meshes.empty() ? -1 : static_cast<int>(n);
    animate(*scene, {channelOf(moved, Path::translation, {{0, 0, 0, 0}, {0.1f, 0.2f, 0.3f, 0}})});
    const auto a = core::makeWorld(scene);
    const auto b = core::poseWorld(a, 0.5);
    ASSERT_FALSE(a->texels.empty());
    EXPECT_TRUE(core::sameTopology(*a, *b));
    EXPECT_EQ(a->texels.data(), b->texels.data());
    EXPECT_EQ(a->triangles.data(), b->triangles.data());
    EXPECT_EQ(a->materials.data(), b->materials.data());
    EXPECT_EQ(a->textureReferences.data(), b->textureReferences.data());
    EXPECT_EQ(a->attributes.data(), b->attributes.data()) << "a translation turns no normal";
    EXPECT_EQ(a->bvh, b->bvh);
    EXPECT_NE(a->positions.data(), b->positions.data());
    const auto c = core::poseWorld(b, 0.5);
    EXPECT_EQ(b->positions.data(), c->positions.data()) << "the same time again";
    EXPECT_EQ(b->emitters.data(), c->emitters.data());
}

TEST(WorldPose, ACameraThatMovesLeavesTheTrianglesAlone)
{
    SceneBuilder b = room(lambert(glm::vec3(0.7f)), lambert(glm::vec3(0.7f)));
    b.camera({0, 0, 3}, {0, 0, 0}, 0.7);
    const int camera = static_cast<int>(b.scene.nodes.size()) - 1;
    animate(b.scene, {channelOf(camera, Path::translation, {{0, 0, 3, 0}, {1, 0, 3, 0}})});
    const auto world = b.world();
    const auto later = core::poseWorld(world, 1);
    EXPECT_TRUE(world->movingTriangles.empty());
    EXPECT_EQ(world->positions.data(), later->positions.data());
    EXPECT_EQ(world->emitters.data(), later->emitters.data());
    EXPECT_EQ(world->emitterCdf.data(), later->emitterCdf.data());
    EXPECT_NE(world->cameras.back().position, later->cameras.back().position);
    expectSameWorld(*later, *fresh(*world, 1));
}

TEST(WorldPose, WithoutAnAnimationThereIsOnePose)
{
    const auto world = core::makeWorld(sceneOf("textured-box"));
    EXPECT_EQ(core::poseWorld(world, 3), world);
}

/// Only what has more than one value over time can move, and what hangs below it.
TEST(WorldPose, ChannelsOfOneValueMoveNothing)
{
    SceneBuilder b = room(lambert(glm::vec3(0.7f)), lambert(glm::vec3(0.7f)));
    const int parent = b.node(glm::dmat4(1), {});
    b.scene.nodes[static_cast<size_t>(parent)].local = core::Transform();
    const int child = b.node(glm::dmat4(1), {0}, parent);
    const glm::vec4 odd(0.1f, 0.7f, 0.3f, 0);
    animate(b.scene, {channelOf(0, Path::translation, {odd, odd, odd}),
                      channelOf(1, Path::rotation,
                                {{0.18f, 0.36f, 0.54f, 0.74f}, {0.18f, 0.36f, 0.54f, 0.74f}}),
                      channelOf(2, Path::translation,
                                {{0, 0, 0, 0}, odd, {1, 0, 0, 0}, {0, 0, 0, 0}, odd, {0, 0, 0, 0}},
                                core::AnimationChannel::Interpolation::cubicSpline),
                      channelOf(parent, Path::scale, {{1, 1, 1, 0}, {1, 1, 2, 0}})});
    const std::vector<bool> moves = core::movingNodes(b.scene);
    EXPECT_FALSE(moves[0]);
    EXPECT_FALSE(moves[1]);
    EXPECT_TRUE(moves[2]) << "a spline with a tangent swings out between equal keys";
    EXPECT_TRUE(moves[static_cast<size_t>(parent)]);
    EXPECT_TRUE(moves[static_cast<size_t>(child)]);
    expectSequenceEqualsFreshWorlds(b.world());
}

/// What the pose takes away or turns over: the triangles are others, and come back.
TEST(WorldPose, DegeneratePosesAreFlattenedAnew)
{
    const float tiny = std::numeric_limits<float>::denorm_min();
    for (const glm::vec4 scale : {glm::vec4(0), glm::vec4(-1, 1, 1, 0),
                                  glm::vec4(1e30f, 1e30f, 1e30f, 0), glm::vec4(tiny)}) {
        SCOPED_TRACE(testing::Message() << scale.x << ' ' << scale.y);
        SceneBuilder b = movingRoom();
        b.sphere({0, 0, 0}, 0.2f, 2, b.material(emitter(glm::vec3(1))));
        const int node = static_cast<int>(b.scene.nodes.size()) - 1;
        animate(b.scene, {channelOf(node, Path::scale, {{1, 1, 1, 0}, scale, {1, 1, 1, 0}},
                                    core::AnimationChannel::Interpolation::step)});
        const auto world = b.world();
        const auto gone = core::poseWorld(world, 1);
        EXPECT_FALSE(core::sameTopology(*world, *gone));
        EXPECT_EQ(world->materials.data() == gone->materials.data(), scale.y != 0 || scale.x != 0)
            << "materials stay shared while all of them are in use";
        expectSameWorld(*gone, *fresh(*world, 1));
        const auto back = core::poseWorld(gone, 2);
        expectSameWorld(*back, *fresh(*world, 2));
        expectSameWorld(*core::poseWorld(back, 1), *gone);
    }
}

}  // namespace
