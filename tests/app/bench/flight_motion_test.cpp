// Flights while the scene's animation runs: the last frame shows the scene as it is at the end,
// with the history of what it was before.
#include <cmath>

#include "app/bench/flythrough/flight_pilot.h"
#include "core/scene/world.h"
#include "tests/support/methods/reuse_flights.h"
#include "tests/support/process/program.h"

namespace {

using namespace tests;
using app::flight::Flight, app::flight::Pilot, app::flight::Play;

constexpr glm::uvec2 kPicture{48, 27};
constexpr double kEnd = 0.5;  // seconds: the scene moves before and after

core::Image flown(ReuseStrategy strategy, const std::optional<Play>& play, uint32_t frames = 6)
{
    Pilot pilot({.device = app::DeviceKind::cpu});
    const auto world = core::poseWorld(asset("animated"), kEnd);
    pilot.setWorld(world, {}, play);
    pilot.setSize(kPicture);
    const Flight flight = Flight::around(world, world->cameras.front(), kPicture, 1);
    return pilot.fly(flight, {1, frames, 1, with(strategy, 7)}, {})->picture;
}

TEST(FlightMotion, EndsInThePoseOfTheEnd)
{
    const Play play{kEnd, 24};
    const core::Image moved = flown(ReuseStrategy::discard, play),
                      still = flown(ReuseStrategy::discard, {});
    EXPECT_EQ(moved.pixels, still.pixels);
    EXPECT_EQ(flown(ReuseStrategy::ra, play, 1).pixels, flown(ReuseStrategy::ra, {}, 1).pixels);
}

TEST(FlightMotion, WhatWasBeforeIsInTheHistory)
{
    // The mean of what was seen lags behind what moves.
    EXPECT_NE(flown(ReuseStrategy::naive, Play{kEnd, 24}).pixels,
              flown(ReuseStrategy::naive, {}).pixels);
    EXPECT_NE(flown(ReuseStrategy::ra, Play{kEnd, 24}).pixels,
              flown(ReuseStrategy::ra, Play{kEnd, 6}).pixels);
}

using FlightMotionCommand = Cli;

TEST_F(FlightMotionCommand, AnimationsRunWhenTheyAreAskedTo)
{
    const Strings bench{"bench",
                        "flythrough",
                        (kAssets / "animated.gltf").string(),
                        "--size",
                        "24x14",
                        "--frames",
                        "3",
                        "--steps",
                        "1",
                        "--seeds",
                        "2",
                        "--reference-spp",
                        "16",
                        "--strategies",
                        "ra",
                        "--no-sweeps",
                        "-q",
                        "-o",
                        "moves"};
    const Result result = run(bench + Strings{"--fps", "24"});
    ASSERT_EQ(result.code, 0) << result.err;
    const Json json = Json::parse(readAll(work("moves/flythrough.json")));
    EXPECT_EQ(json.at("fps"), 24);
    EXPECT_TRUE(
        contains(json.at("scenes").at(0).at("way").get<std::string>(), "24 frames per second"));
    // The reference is of another instant than that of a flight through the scene at rest.
    EXPECT_FALSE(json.at("scenes").at(0).at("reference_kept").get<bool>());
    ASSERT_EQ(run(bench).code, 0);
    EXPECT_FALSE(Json::parse(readAll(work("moves/flythrough.json")))
                     .at("scenes")
                     .at(0)
                     .at("reference_kept")
                     .get<bool>());

    expectRefused(bench + Strings{"--fps", "24", "--window", "64x36"}, 2, "--window");
    expectRefused(bench + Strings{"--fps", "-1"}, 2, "--fps");
    const Result still = run({"bench", "flythrough",   kScene,  "--size",
                              "8x8",   "--frames",     "2",     "--steps",
                              "1",     "--seeds",      "2",     "--reference-spp",
                              "2",     "--strategies", "ra",    "--no-sweeps",
                              "-o",    "still",        "--fps", "24"});
    EXPECT_EQ(still.code, 0);
    EXPECT_TRUE(contains(still.err, "nothing moves")) << still.err;
}

}  // namespace
