// What is around a place, in scenes where it is known: rooms, solids, the open.
#include "app/camera/surroundings.h"

#include <random>

#include <gtest/gtest.h>

#include "core/gltf/gltf.h"
#include "tests/support/scenes/test_scenes.h"

namespace {

using glm::dvec3;

core::Material grey(bool doubleSided = false)
{
    core::Material material;
    if (doubleSided) material.data.flags |= shared::kMaterialDoubleSided;
    return material;
}

/// A solid ball of radius 1 beside a room of 4 x 4 x 4 about (6, 0, 0), in which a box stands on
/// the floor.
std::shared_ptr<const core::World> ballAndRoom(bool doubleSided)
{
    tests::SceneBuilder builder;
    const int material = builder.material(grey(doubleSided));
    builder.sphere({0, 0, 0}, 1, 4, material);
    builder.box({4, -2, -2}, {8, 2, 2}, material, true);
    builder.box({4.5f, -2, -1}, {5.9f, -0.5f, 1}, material, false);
    return builder.world();
}

dvec3 placed(const core::World& world, dvec3 point)
{
    return world.placement.toWorld(point);
}

TEST(Surroundings, TheWayIsFreeUpToTheFrontOfAWall)
{
    const auto world = ballAndRoom(false);
    const auto share = [&](dvec3 from, dvec3 to, double margin) {
        const double unit = glm::distance(placed(*world, {1, 0, 0}), placed(*world, {0, 0, 0}));
        return app::freeShare(*world, placed(*world, from), placed(*world, to), margin * unit);
    };
    EXPECT_EQ(share({6, 0.5, 0}, {7, 0.5, 0}, 0.1), 1);
    EXPECT_NEAR(share({6, 0.5, 0}, {8.5, 0.5, 0}, 0), 0.8, 1e-5);
    EXPECT_NEAR(share({6, 0.5, 0}, {8.5, 0.5, 0}, 0.25), 0.7, 1e-5);
    EXPECT_NEAR(share({6, 0.5, 0}, {7.9, 0.5, 0}, 0.29), 0.9, 1e-5) << "short of it, and too near";
    EXPECT_EQ(share({7.9, 0.5, 0}, {7.95, 0.5, 0}, 0.2), 0) << "too near already";
    EXPECT_EQ(share({7.9, 0.5, 0}, {7.5, 0.5, 0}, 0.2), 1) << "away from it";
    EXPECT_NEAR(share({0, 0, 5}, {0, 0, 0}, 0), 0.8, 1e-5) << "into the ball";
    EXPECT_EQ(share({0, 0, 0.1}, {0, 0, 5}, 0), 1) << "out of it";
    EXPECT_EQ(share({0, 0, 5}, {0, 0, 5}, 0.1), 1);
}

TEST(Surroundings, TheMarginFitsIntoRoomsOfWideLandscapes)
{
    for (const float size : {0.01f, 1.0f, 5000.0f}) {
        tests::SceneBuilder builder;
        const int material = builder.material(grey());
        builder.box({-size, -3, -size}, {size, -2, size}, material, false);
        builder.box({-2, -2, -2}, {2, 2, 2}, material, true);
        const auto world = builder.world();
        const double metre = world->placement.scale;
        EXPECT_LE(app::wallMargin(*world), 0.05 * metre);
        EXPECT_GT(app::wallMargin(*world), 0.02 * metre);
    }
    tests::SceneBuilder small;
    small.sphere({0, 0, 0}, 0.01f, 4, small.material(grey()));
    const auto world = small.world();
    EXPECT_NEAR(app::wallMargin(*world), 0.01 * double(world->radius),
                1e-6 * double(world->radius));
}

TEST(Surroundings, InsideASolidIsToldFromRoomsAndTheOpen)
{
    for (const bool doubleSided : {true, false}) {
        const auto world = ballAndRoom(doubleSided);
        std::mt19937 random(3);
        std::uniform_real_distribution<double> unit(-1, 1);
        for (int i = 0; i < 100; ++i) {
            const dvec3 p(unit(random), unit(random), unit(random));
            const double length = glm::length(p);
            if (length < 0.95) {
                EXPECT_TRUE(app::insideSolid(*world, placed(*world, p))) << i;
            }
            const dvec3 outside = (1.05 + 2 * std::abs(p.x)) / length * p;
            if (outside.x < 3.9) {
                EXPECT_FALSE(app::insideSolid(*world, placed(*world, outside))) << i;
            }
            const dvec3 inRoom = dvec3(6, 0.4, 0) + dvec3(0.9, 0.7, 1.2) * p;
            EXPECT_FALSE(app::insideSolid(*world, placed(*world, inRoom))) << i;
            const dvec3 inBox = dvec3(5.2, -1, 0) + dvec3(0.6, 0.4, 0.9) * p;
            EXPECT_TRUE(app::insideSolid(*world, placed(*world, inBox)))
                << i << ": though the floor that it stands on shows its front";
        }
    }
}

TEST(Surroundings, ARoomIsSeenFromWithinAndNotFromOutside)
{
    const auto world = ballAndRoom(false);
    const double scale = world->placement.scale;
    std::stop_source stopped;
    stopped.request_stop();
    EXPECT_FALSE(app::roomAround(*world, placed(*world, {6.5, 0.5, 0.5}), stopped.get_token()));
    EXPECT_FALSE(app::insideSolid(*world, placed(*world, {0, 0, 0}), stopped.get_token()));
    const auto room = app::roomAround(*world, placed(*world, {6.5, 0.5, 0.5}));
    ASSERT_TRUE(room);
    EXPECT_LT(glm::distance(room->middle, placed(*world, {6, 0, 0})), 0.8 * scale);
    EXPECT_GT(room->radius, 1.5 * scale);
    EXPECT_LT(room->radius, 3.5 * scale);
    EXPECT_FALSE(app::roomAround(*world, placed(*world, {2, 0, 0}))) << "between ball and room";
    EXPECT_FALSE(app::roomAround(*world, placed(*world, {0, 30, 0})));
}

TEST(Surroundings, DistancesAreThoseOfTheScene)
{
    const auto world = ballAndRoom(false);
    const auto to = app::distanceAlong(*world, placed(*world, {0, 0, 3}), {0, 0, -1});
    ASSERT_TRUE(to);
    EXPECT_NEAR(*to, 2 * world->placement.scale, 1e-2 * world->placement.scale);
    EXPECT_FALSE(app::distanceAlong(*world, placed(*world, {0, 0, 3}), {0, 0, 1}));
}

TEST(Surroundings, WaysThroughWallsAreToldFromThoseThroughDoors)
{
    const auto world = ballAndRoom(true);
    const auto through = [](const core::World& in, std::vector<dvec3> way) {
        for (dvec3& point : way) point = placed(in, point);
        return app::leadsThrough(in, way);
    };
    EXPECT_TRUE(through(*world, {{2, 0, 0}, {6, 0.4, 0}})) << "into the room";
    EXPECT_TRUE(through(*world, {{6, 0.4, 0}, {2, 0, 0}})) << "and out of it";
    EXPECT_TRUE(through(*world, {{2, 3, 0}, {2, 0, 0}, {-2, 0, 0}})) << "through the whole ball";
    EXPECT_FALSE(through(*world, {{2, 0, 0}, {1.5, 1.5, 0}, {0, 2, 0}, {-2, 0, 0.1}, {-2, 0, 0}}))
        << "about it";
    EXPECT_FALSE(through(*world, {{7.5, 1.5, 1.5}, {4.5, 1.5, -1.5}, {6, 0, 0}})) << "in the room";
    EXPECT_FALSE(through(*world, {{2, 0, 0}, {3.9, 0, 0}, {3.9, 0, 0}})) << "up to the wall";
    EXPECT_FALSE(through(*world, {}));
    tests::SceneBuilder builder;
    const int material = builder.material(grey(true));
    builder.box({-4, 0, -0.1}, {-0.5, 2, 0.1}, material, false);
    builder.box({0.5, 0, -0.1}, {4, 2, 0.1}, material, false);
    const auto wall = builder.world();
    EXPECT_FALSE(through(*wall, {{0.2, 1, 2}, {0.1, 1, 0}, {-0.3, 1, -2}})) << "an open door";
    EXPECT_TRUE(through(*wall, {{0.2, 1, 2}, {1, 1, -2}})) << "the wall beside it";
}

/// No false alarm from where the makers of scenes look.
TEST(Surroundings, CamerasOfOurScenesAreInsideNothing)
{
    for (const char* name : {"hall.gltf", "door-ajar.gltf", "cornell-diffuse.gltf", "lights.gltf",
                             "animated.gltf", "furnace-50.gltf", "cbox-up.gltf"}) {
        const auto world =
            core::makeWorld(core::loadGltf(std::string(REKINDLE_SOURCE_DIR "/assets/") + name));
        for (const core::Camera& camera : world->cameras)
            EXPECT_FALSE(app::insideSolid(*world, camera.position)) << name;
    }
}

}  // namespace
