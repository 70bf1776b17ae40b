// What has moved between two poses: boxes hold what they should and nothing is left out; the camera
// of the frame before sees a moved surface where it was.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/scene/moved_pieces.h"
#include "shared/reuse_history.h"
#include "tests/support/scenes/animated_scenes.h"

namespace {

using namespace tests;

using Path = core::AnimationChannel::Path;

bool holds(const shared::MovedPiece& piece, glm::vec3 p)
{
    return all(lessThanEqual(piece.low, p)) && all(lessThanEqual(p, piece.high));
}

/// T-32.
TEST(MovedPieces, HoldEveryVertexThatHasMoved)
{
    const auto before = core::poseWorld(movingRoom().world(), 0.4);
    const auto now = core::poseWorld(before, 0.9);
    const auto pieces = core::movedPieces(*before, *now);
    // The lamp grows, and is chosen more often.
    EXPECT_FALSE(pieces.has_value());

    const auto room = core::poseWorld(movingRoom().world(), 1.25);
    const auto later = core::poseWorld(room, 1.5);
    const auto moved = core::movedPieces(*room, *later);
    ASSERT_TRUE(moved.has_value());
    for (uint32_t t = 0; t < later->triangles.size(); ++t) {
        const core::WorldTriangle& triangle = later->triangles[t];
        for (const uint32_t v : {triangle.v0, triangle.v1, triangle.v2}) {
            if (room->positions[v] == later->positions[v]) continue;
            const bool found = std::ranges::any_of(*moved, [&](const shared::MovedPiece& piece) {
                return t - piece.first < piece.count && holds(piece, room->positions[v]) &&
                       holds(piece, later->positions[v]);
            });
            ASSERT_TRUE(found) << "triangle " << t;
        }
    }
    EXPECT_TRUE(core::movedPieces(*room, *room)->empty());
    EXPECT_FALSE(core::movedPieces(*movingRoom().world(), *room).has_value()) << "another topology";
}

/// A room with so many balls, of which the first `moving` fly, and a light that moves.
std::shared_ptr<const core::World> balls(int count, int moving, uint32_t lightKind)
{
    SceneBuilder b = room(lambert(glm::vec3(0.7f)), lambert(glm::vec3(0.7f)));
    const int grey = b.material(lambert(glm::vec3(0.5f)));
    std::vector<core::AnimationChannel> channels;
    for (int i = 0; i < count; ++i) {
        b.sphere({0, 0, 0}, 0.02f, 1, grey);
        const int node = static_cast<int>(b.scene.nodes.size()) - 1;
        b.scene.nodes[static_cast<size_t>(node)].local = core::Transform();
        const glm::vec4 here(-0.8f + 1.6f * float(i) / float(count), 0.5f, 0, 0);
        channels.push_back(channelOf(node, Path::translation,
                                     {here, here + glm::vec4(0, i < moving ? 0.1f : 0, 0, 0)}));
    }
    core::PunctualLight light;
    light.kind = lightKind;
    b.light(light, glm::dmat4(1));
    const int node = static_cast<int>(b.scene.nodes.size()) - 1;
    b.scene.nodes[static_cast<size_t>(node)].local = core::Transform();
    channels.push_back(
        channelOf(node, Path::translation, {{0.5f, 0.5f, 0.5f, 0}, {0.2f, 0.5f, 0.5f, 0}}));
    if (lightKind == shared::kEmitterDirectional)
        channels.push_back(
            channelOf(node, Path::rotation, {{0, 0, 0, 1}, {0.7071068f, 0, 0, 0.7071068f}}));
    animate(b.scene, channels);
    return b.world();
}

TEST(MovedPieces, AreOnesThatMovedAndLights)
{
    const auto before = balls(6, 2, shared::kEmitterPoint);
    const auto pieces = core::movedPieces(*before, *core::poseWorld(before, 1));
    ASSERT_TRUE(pieces.has_value());
    ASSERT_EQ(pieces->size(), 3u) << "two balls and the light";
    EXPECT_EQ(pieces->at(0).count, 32u);
    EXPECT_EQ(pieces->at(2).count, 0u);
    const core::Placement& placement = before->placement;
    for (const float x : {0.5f, 0.2f})
        EXPECT_TRUE(holds(pieces->at(2), glm::vec3(placement.toWorld({x, 0.5, 0.5}))));
    EXPECT_LT(pieces->at(2).high.y - pieces->at(2).low.y, 0.001f);
}

TEST(MovedPieces, AreJoinedWhereThereAreMany)
{
    for (const uint32_t count : {50u, 1001u}) {
        const auto before = balls(int(count), int(count), shared::kEmitterSpot);
        const auto now = core::poseWorld(before, 1);
        const auto pieces = core::movedPieces(*before, *now);
        ASSERT_TRUE(pieces.has_value());
        EXPECT_LE(pieces->size(), shared::kMostMovedPieces);
        EXPECT_GT(pieces->size(), 8u);
        uint32_t triangles = 0, outside = 0;
        for (const shared::MovedPiece& piece : *pieces) {
            const uint32_t its = piece.count & ~shared::kMovedSeveral;
            triangles += its;
            EXPECT_EQ((piece.count & shared::kMovedSeveral) != 0, its > 32);
            for (uint32_t t = piece.first; t < piece.first + its; ++t)
                for (const auto& world : {before, now})
                    outside += holds(piece, world->positions[world->triangles[t].v0]) ? 0u : 1u;
        }
        EXPECT_EQ(triangles, count * 32);
        EXPECT_EQ(outside, 0u);
    }
}

TEST(MovedPieces, ASunThatTurnsChangesEverything)
{
    const auto before = balls(2, 2, shared::kEmitterDirectional);
    EXPECT_FALSE(core::movedPieces(*before, *core::poseWorld(before, 1)).has_value());
}

TEST(Motion, BoxesAreMetWhereTheyAre)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<float> number(-1, 1);
    const auto vector = [&] { return glm::vec3(number(random), number(random), number(random)); };
    uint32_t met = 0, missed = 0;
    for (int i = 0; i < 4000; ++i) {
        const glm::vec3 a = vector(), b = vector(), low = min(a, b), high = max(a, b);
        const glm::vec3 origin = 2.0f * vector();
        glm::vec3 way = 3.0f * vector();
        if (i % 4 == 0) way[i / 4 % 3] = 0;  // along a side
        bool inside = false;
        constexpr int kSteps = 2000;
        for (int k = 0; k <= kSteps; ++k) {
            const glm::vec3 p = origin + float(k) / kSteps * way;
            inside = inside || (all(lessThan(low, p)) && all(lessThan(p, high)));
        }
        const bool found = shared::meetsBox(origin, way, 1, low, high);
        EXPECT_TRUE(found || !inside) << i;
        met += found && inside ? 1 : 0;
        missed += !found && !inside ? 1 : 0;
    }
    EXPECT_GT(met, 100u);
    EXPECT_GT(met + missed, 3950u) << "between steps a corner may be cut";
}

/// A surface that turns and flies is seen by the moved camera where the camera saw it.
TEST(Motion, TheCameraOfBeforeGoesAlong)
{
    shared::CameraData camera{};
    camera.position = {0.3f, 0.4f, 3};
    camera.right = {1, 0, 0};
    camera.up = {0, 1, 0};
    camera.forward = {0, 0, -1};
    camera.tanHalfHeight = 0.5f;
    camera.aspect = 1;
    const glm::mat3 turn =
        shared::frameOfTriangle({{0, 0, 0, 0}, {0.3f, 0.2f, 0.1f, 0}, {-0.2f, 0.5f, 0.3f, 0}});
    const glm::vec3 shift(0.2f, -0.1f, 0.4f);
    shared::SurfaceMotion motion = shared::noMotion();
    motion.piece = 0;
    motion.before = {0.1f, 0.2f, 0.3f};
    motion.now = turn * motion.before + shift;
    motion.turn = turn;
    const shared::CameraData moved = shared::movedCamera(camera, motion);
    for (const glm::vec3 p : {glm::vec3(0.1f, 0.2f, 0.3f), glm::vec3(-0.4f, 0.1f, 0.7f)}) {
        glm::vec2 was, is;
        ASSERT_TRUE(shared::projectToFilm(camera, {100, 100}, p, was));
        ASSERT_TRUE(shared::projectToFilm(moved, {100, 100}, turn * p + shift, is));
        EXPECT_NEAR(was.x, is.x, 1e-3f);
        EXPECT_NEAR(was.y, is.y, 1e-3f);
        EXPECT_NEAR(glm::length(shared::towardsCamera(moved, turn * p + shift) -
                                turn * shared::towardsCamera(camera, p)),
                    0, 1e-5f);
    }
}

}  // namespace
