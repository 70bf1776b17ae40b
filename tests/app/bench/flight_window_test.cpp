// Flights in the window's own loop: where they land, how fast they go.
#include "app/bench/flythrough/flight_window.h"

#include <atomic>
#include <cmath>
#include <thread>

#include <sched.h>

#include <gtest/gtest.h>

#include "core/base/check.h"
#include "core/gltf/load.h"
#include "core/image/metrics.h"
#include "core/methods/method.h"

namespace app::flight {
namespace {

const std::filesystem::path kScene =
    std::filesystem::path(REKINDLE_SOURCE_DIR) / "assets" / "cornell-diffuse.gltf";
constexpr glm::uvec2 kSize(48, 40);

app::SceneOptions sceneOf(const std::filesystem::path& file)
{
    app::SceneOptions scene;
    scene.file = file;
    return scene;
}

Flight circle(const std::shared_ptr<const core::World>& world)
{
    return Flight::around(world, world->cameras.front(), kSize, 16);
}

TEST(FlightWindow, TracksEndWhereFlightsEnd)
{
    const auto world = core::makeWorld(core::loadGltf(kScene));
    const Flight flight = circle(world);
    const app::CameraTrack track = lastSeconds(flight, 20, 1.5);
    EXPECT_EQ(track.framesPerSecond, 10);
    ASSERT_EQ(track.keys().size(), 16u);
    EXPECT_EQ(track.at(track.lastFrame()), flight.end());
    for (uint32_t i = 0; i <= 15; ++i) EXPECT_EQ(track.keys()[i].camera, flight.before(2, 15 - i));

    EXPECT_EQ(speedThatFits(flight, 20, 1.5), 20);
    app::CameraPath path;
    for (int i = 0; i < 2; ++i) {
        core::Camera camera;
        camera.position.x = i;
        path.keys.push_back({12.0 * i, camera});
    }
    // Twelve frames of a path in a second and a half: eight per second at most.
    EXPECT_EQ(speedThatFits(Flight::along(path), 24, 1.5), 6);
}

/// What is compared as shown: blocks of a still picture, and of one with a guide blocks only where
/// neighbours are of different surfaces.
TEST(FlightWindow, ColoursAreThoseOnShow)
{
    core::Image picture(2, 1, 3), alike(2, 1, 1), apart(2, 1, 1);
    for (int c = 0; c < 3; ++c) picture.at(1, 0)[c] = 0.5f;
    for (uint32_t x = 0; x < 2; ++x) {
        apart.at(x, 0)[0] = 16;                         // itself
        alike.at(x, 0)[0] = x == 0 ? 16 + 32 : 16 + 8;  // and the other
    }
    const auto redAt = [&](const core::Image* guide, uint32_t x) {
        return displayColours(picture, guide, {8, 4}).at(x, 1)[0];
    };
    const float dark = redAt(nullptr, 0), bright = redAt(nullptr, 7);
    EXPECT_LT(dark, 0.1f);
    EXPECT_GT(bright, 0.3f);
    EXPECT_LE(bright, 1.0f);
    for (uint32_t x = 0; x < 8; ++x) {
        EXPECT_EQ(redAt(nullptr, x), x < 4 ? dark : bright) << x;
        EXPECT_NEAR(redAt(&apart, x), x < 4 ? dark : bright, 0.005) << x;
    }
    for (uint32_t x = 2; x < 6; ++x) {
        EXPECT_GT(redAt(&alike, x), redAt(&alike, x - 1)) << x;
        EXPECT_GT(redAt(&alike, x), dark) << x;
        EXPECT_LT(redAt(&alike, x), bright) << x;
    }
}

/// Means over blocks of 8x8 pixels: what is seen where, and little of the noise.
core::Image blocks(const core::Image& picture)
{
    core::Image means(picture.width / 8, picture.height / 8, 3);
    for (uint32_t y = 0; y < 8 * means.height; ++y)
        for (uint32_t x = 0; x < 8 * means.width; ++x)
            for (int c = 0; c < 3; ++c) means.at(x / 8, y / 8)[c] += picture.at(x, y)[c] / 64;
    return means;
}

TEST(SlowedClock, IsNeverFasterThanTheOther)
{
    const auto start = std::chrono::steady_clock::now();
    app::SlowedClock clock;
    double seconds = 0;
    volatile double work = 0;
    for (int i = 0; i < 20; ++i) {
        for (int k = 0; k < 100'000; ++k) work = work + 1;
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        seconds += clock.tick();
        EXPECT_GT(clock.share(), 0);
        EXPECT_LE(clock.share(), 1);
    }
    EXPECT_GT(seconds, 0);
    EXPECT_LE(seconds,
              std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

/// Two threads that share one core get half of what they want.
TEST(SlowedClock, TellsWhenOthersRun)
{
    cpu_set_t before, one;
    ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
    CPU_ZERO(&one);
    for (size_t i = 0; i < CPU_SETSIZE; ++i)
        if (CPU_ISSET(i, &before) != 0) {
            CPU_SET(i, &one);
            break;
        }
    ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);  // inherited by the thread
    std::atomic<bool> stop{false};
    std::thread other([&stop] {
        while (!stop) {
        }
    });
    app::SlowedClock clock;
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - start < std::chrono::milliseconds(600)) clock.tick();
    EXPECT_LT(clock.share(), 0.75);
    stop = true;
    other.join();
    sched_setaffinity(0, sizeof before, &before);
}

TEST(FlightWindow, LandsWithAPictureOfTheLastView)
{
    const auto world = core::makeWorld(core::loadGltf(kScene));
    const Flight flight = circle(world);
    const app::CameraTrack track = lastSeconds(flight, 18, 1);
    WindowPilot pilot(sceneOf(kScene), {.device = app::DeviceKind::cpu}, kSize, {});
    const auto showing = [&](const core::Camera& camera) {
        const auto renderer = core::makeRenderer("reuse");
        renderer->setWorld(world, {});
        renderer->setView({camera, kSize, core::ReuseParams{}}, core::Start::anew);
        renderer->advance({.samples = 256}, {});
        return blocks(renderer->read(core::Reading::mean).mean);
    };
    const core::Image there = showing(flight.end()), first = showing(flight.before(18, 1));
    for (const auto strategy : {core::ReuseStrategy::discard, core::ReuseStrategy::ra}) {
        const auto landing =
            pilot.fly(track, core::ReuseParams{.reuse = strategy, .rays = 4}, 0.05);
        ASSERT_TRUE(landing.has_value());
        ASSERT_EQ(glm::uvec2(landing->picture.width, landing->picture.height), kSize);
        const core::Image seen = blocks(landing->picture);
        EXPECT_LT(core::imageErrors(seen, there).relMse,
                  0.5 * core::imageErrors(seen, first).relMse);
        EXPECT_GT(landing->scale, 0);
        EXPECT_LE(landing->scale, 1);
        EXPECT_GT(landing->pictureSeconds(), 0);
    }
}

/// What is told of a flight is over where it ends: the picture that is waited for then takes time
/// of its own. Other work may hold up the window's loop for a moment, but not every time.
TEST(FlightWindow, TimesAreThoseOfTheFlight)
{
    constexpr glm::uvec2 kLarge(256, 192);  // a picture takes some tenths of a second
    const auto world = core::makeWorld(core::loadGltf(kScene));
    const app::CameraTrack track = lastSeconds(circle(world), 18, 1);
    WindowPilot pilot(sceneOf(kScene), {.device = app::DeviceKind::cpu}, kLarge, {});
    double least = HUGE_VAL;
    for (int i = 0; i < 3; ++i) {
        const auto landing = pilot.fly(
            track, core::ReuseParams{.reuse = core::ReuseStrategy::discard, .rays = 4}, 1);
        ASSERT_TRUE(landing.has_value());
        EXPECT_GT(landing->seconds, 1 - 1e-9);
        EXPECT_GT(landing->pictures, 0u);
        EXPECT_NEAR(landing->pictureSeconds() * landing->pictures, landing->seconds, 1e-9);
        least = std::min(least, landing->seconds);
    }
    EXPECT_LT(least, 1.06);
}

TEST(FlightWindow, StopsWhenAskedAndFailsInWords)
{
    std::stop_source stop;
    stop.request_stop();
    WindowPilot pilot(sceneOf(kScene), {.device = app::DeviceKind::cpu}, kSize, stop.get_token());
    const auto world = core::makeWorld(core::loadGltf(kScene));
    EXPECT_FALSE(pilot.fly(lastSeconds(circle(world), 20, 0.5), {}, 0.1).has_value());
    EXPECT_THROW(WindowPilot(sceneOf("none.gltf"), {.device = app::DeviceKind::cpu}, kSize, {}),
                 core::Error);
}

}  // namespace
}  // namespace app::flight
