// T35: in a region of the sky directions and emitters are drawn exactly as often as is stated,
// whatever shines keeps a density, openings are found, and nothing is made where most of the sky is
// seen or none shines.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/trace/scene_view.h"
#include "core/trace/sky_places.h"
#include "core/trace/sky_regions.h"
#include "shared/lights.h"
#include "tests/support/scenes/instanced_scenes.h"
#include "tests/support/scenes/sky_rooms.h"
#include "tests/support/statistics/random_values.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;
using core::SkyNeed;

/// A world, its hierarchy and its regions, as the shared text reads them.
struct Learnt {
    std::shared_ptr<const core::World> world;
    core::Accel accel;
    std::shared_ptr<const core::SkyRegions> regions;
    shared::SceneView scene;
    shared::PathSettings settings;

    explicit Learnt(const SceneBuilder& builder, SkyNeed need = SkyNeed::hidden)
        : world(builder.world()), accel(world), regions(core::makeSkyRegions(accel, need)),
          scene(core::sceneView(*world)), settings(core::worldSettings(*world))
    {
        if (!regions) return;
        scene.skyRegions = regions->words.data();
        settings.skyRegions = 1;
    }

    uint32_t regionAt(glm::vec3 p, glm::vec3 n) const
    {
        const glm::dvec3 q = world->placement.toWorld(glm::dvec3(p));
        return shared::findSkyRegion(scene, glm::vec3(q), n);
    }

    /// Of several places in the room, floor, walls and ceiling; each once.
    std::vector<uint32_t> someRegions(size_t count) const
    {
        std::mt19937 random(3);
        std::set<uint32_t> found;
        for (int i = 0; i < 200 && found.size() < count; ++i) {
            // In braces: compilers agree on their order, but not on that of arguments.
            const glm::vec3 p{2 * uniform(random) - 1, 2 * uniform(random) - 1,
                              2 * uniform(random) - 1};
            found.insert(regionAt(p, shared::sampleSphere({uniform(random), uniform(random)})));
        }
        return {found.begin(), found.end()};
    }
};

/// Where a direction falls in a grid over the sphere, rows of equal solid angle.
uint32_t binOf(glm::vec3 d, uint32_t across, uint32_t down)
{
    const glm::vec2 uv = shared::environmentUv(d);
    const auto x = static_cast<uint32_t>(uv.x * static_cast<float>(across));
    const auto y = static_cast<uint32_t>((0.5f - 0.5f * std::clamp(d.y, -1.0f, 1.0f)) *
                                         static_cast<float>(down));
    return std::min(y, down - 1) * across + std::min(x, across - 1);
}

TEST(SkyRegions, DirectionsAreDrawnByTheirDensity)
{
    for (const bool sunny : {false, true}) {
        const Learnt room(windowRoom(sunny));
        ASSERT_NE(room.regions, nullptr);
        const std::vector<uint32_t> regions = room.someRegions(6);
        ASSERT_GE(regions.size(), 5u);
        for (const uint32_t region : regions) {
            ASSERT_GT(region, 0u);
            const uint32_t across = 48, down = 24;
            std::vector<double> observed(across * down), expected(across * down);
            std::mt19937 random(7);
            const int draws = 400'000;
            int moved = 0;  // over the border of a cell by rounding
            for (int i = 0; i < draws; ++i) {
                shared::EmitterSample s;
                const glm::vec2 u(uniform(random), uniform(random));
                if (!shared::sampleEnvironment(room.scene, room.settings, region, u, s)) continue;
                const float pdf = shared::pdfEnvironment(room.scene, room.settings, region, s.wi);
                moved += std::abs(pdf / s.pdf - 1) > 1e-3f;
                observed[binOf(s.wi, across, down)] += 1;
            }
            EXPECT_LE(moved, 3e-3 * draws);
            // By quadrature, on a grid that is finer than texels and jittered against cells.
            const uint32_t fine = 64;
            double total = 0;
            for (uint32_t y = 0; y < down * fine; ++y) {
                for (uint32_t x = 0; x < across * fine; ++x) {
                    const double cosine = 1 - 2 * (y + double(uniform(random))) / (down * fine);
                    const glm::vec3 d = shared::environmentDirection(
                        {(static_cast<float>(x) + uniform(random)) / float(across * fine),
                         static_cast<float>(std::acos(cosine) / std::numbers::pi)});
                    const double mass =
                        static_cast<double>(
                            shared::pdfEnvironment(room.scene, room.settings, region, d)) *
                        4 * std::numbers::pi / (double(across) * down * fine * fine);
                    expected[binOf(d, across, down)] += mass * draws;
                    total += mass;
                }
            }
            EXPECT_NEAR(total, 1.0, 2e-3);
            const ChiSquare test = chiSquareTest(observed, expected);
            EXPECT_GT(test.p, sidak(kLevel, 12))
                << "chi-square " << test.statistic << " of " << test.degreesOfFreedom;
        }
    }
}

TEST(SkyRegions, WhateverShinesKeepsADensity)
{
    const Learnt room(windowRoom(true));
    ASSERT_NE(room.regions, nullptr);
    std::mt19937 random(13);
    for (const uint32_t region : room.someRegions(20)) {
        for (int i = 0; i < 20'000; ++i) {
            const glm::vec3 d = shared::sampleSphere({uniform(random), uniform(random)});
            const float whole = shared::pdfEnvironment(room.scene, room.settings, 0, d);
            if (!(whole > 0)) continue;
            const float here = shared::pdfEnvironment(room.scene, room.settings, region, d);
            ASSERT_TRUE(here > 0.09f * whole && here < 1e6f) << here << " of " << whole;
        }
    }
}

/// Walks begin on what instances show: in the space of the prototype they would begin in its
/// middle.
TEST(SkyRegions, PlacesAreOnWhatInstancesShow)
{
    const auto outer = [](core::Instancing instancing) {
        SceneBuilder b = thicket(400);  // on 20 x 20 around the origin
        for (core::Node& node : b.scene.nodes) node.camera = -1;
        b.camera({0, 1e4, 0}, {0, 2e4, 1}, 0.5);  // sees nothing
        const auto world = worldOf(b, instancing);
        EXPECT_EQ(world->instances.empty(), instancing == core::Instancing::flat);
        const core::Accel accel(world);
        const std::vector<core::Place> places = core::findPlaces(accel, 4096, 0);
        EXPECT_GT(places.size(), 2000u);
        const auto far = std::ranges::count_if(places, [&](const core::Place& p) {
            const glm::dvec3 at = world->placement.toFile(glm::dvec3(p.position));
            return std::max(std::abs(at.x), std::abs(at.z)) > 5;
        });
        return static_cast<double>(far) / static_cast<double>(places.size());
    };
    const double flat = outer(core::Instancing::flat), kept = outer(core::Instancing::kept);
    EXPECT_GT(flat, 0.6);
    EXPECT_NEAR(kept, flat, 0.05);
}

TEST(SkyRegions, EmittersAreChosenByTheirProbability)
{
    Learnt room(roomWithLamps());
    ASSERT_NE(room.regions, nullptr);
    const uint32_t count = room.settings.emitterCount;
    ASSERT_EQ(room.settings.environmentEmitter, count - 1);
    room.settings.treeEmitters = count - 1;  // whether or not the tree pays here
    std::mt19937 random(5);
    double least = 1, most = 0;
    for (const uint32_t region : room.someRegions(8)) {
        const glm::vec3 p(0.1f, -0.9f, 0.2f);
        const uint32_t departure = shared::packReceiver({0, 1, 0});
        std::vector<double> observed(count + 1), expected(count + 1);
        const int draws = 200'000;
        for (int i = 0; i < draws; ++i) {
            const shared::EmitterChoice chosen = shared::finishChoice(
                room.scene, p, departure,
                shared::beginChoiceIn(room.scene, room.settings, region, uniform(random)));
            if (!(chosen.pmf > 0)) {
                observed.back() += 1;
                continue;
            }
            ASSERT_LT(chosen.emitter, count);
            const float stated = chosen.emitter == room.settings.environmentEmitter
                                     ? shared::pmfEnvironmentIn(room.scene, room.settings, region)
                                     : shared::pmfEmitterIn(room.scene, room.settings, region,
                                                            chosen.emitter, p, departure);
            ASSERT_FLOAT_EQ(chosen.pmf, stated);
            observed[chosen.emitter] += 1;
        }
        double sum = 0;
        for (uint32_t i = 0; i < count; ++i) {
            const double pmf = static_cast<double>(
                i == room.settings.environmentEmitter
                    ? shared::pmfEnvironmentIn(room.scene, room.settings, region)
                    : shared::pmfEmitterIn(room.scene, room.settings, region, i, p, departure));
            expected[i] = pmf * draws;
            sum += pmf;
        }
        ASSERT_LE(sum, 1 + 1e-5);
        expected.back() = std::max(0.0, 1 - sum) * draws;
        const ChiSquare test = chiSquareTest(observed, expected);
        EXPECT_GT(test.p, sidak(kLevel, 8));
    }
    for (const uint32_t region : room.someRegions(64)) {
        const double sky = static_cast<double>(shared::skyShare(room.scene, region));
        least = std::min(least, sky);
        most = std::max(most, sky);
    }
    EXPECT_GE(least, 0.04);
    EXPECT_LE(most, 0.96);
    EXPECT_GT(most, 2 * least) << "all places have the same share";
}

/// Where the sky is all that shines no draw is left to others.
TEST(SkyRegions, TheSkyAloneIsAlwaysChosen)
{
    const Learnt room(windowRoom(false));
    ASSERT_NE(room.regions, nullptr);
    ASSERT_EQ(room.settings.emitterCount, 1u);
    const uint32_t departure = shared::packReceiver({0, 1, 0});
    for (const uint32_t region : room.someRegions(8)) {
        ASSERT_GT(region, 0u);
        EXPECT_EQ(shared::pmfEnvironmentIn(room.scene, room.settings, region), 1.0f);
        for (const float u : {0.0f, 0.5f, 0.94f, 0.96f, shared::kOneMinusEpsilon}) {
            const shared::EmitterChoice chosen =
                shared::finishChoice(room.scene, glm::vec3(0), departure,
                                     shared::beginChoiceIn(room.scene, room.settings, region, u));
            EXPECT_EQ(chosen.emitter, room.settings.environmentEmitter);
            EXPECT_EQ(chosen.pmf, 1.0f) << u;
        }
    }
}

/// Root mean square, over places, of what samples of an emitter bring; of the environment as it is
/// drawn in the region.
double bringsOf(const Learnt& room, std::span<const core::Place> places, uint32_t region,
                uint32_t emitter)
{
    constexpr size_t kEach = 64;
    std::mt19937 random(23);
    core::Bringing bringing(room.accel);
    std::vector<float> brings(places.size() * kEach);
    for (size_t i = 0; i < brings.size(); ++i) {
        const core::Place& p = places[i / kEach];
        const glm::vec2 u{uniform(random), uniform(random)};
        shared::EmitterSample s;
        if (shared::sampleEmitter(room.scene, room.settings, emitter, p.position, region, u, s))
            bringing.add(p, s, 1 / (s.pdf > 0 ? s.pdf : 1), brings[i]);
    }
    bringing.trace();
    double squares = 0;
    for (const float b : brings) squares += double(b) * double(b);
    return std::sqrt(squares / double(brings.size()));
}

/// Beside a lamp far away, of a tenth of the sky's power, the sky's share is that with the least
/// variance.
TEST(SkyRegions, SharesGoByWhatSkyAndLampsBring)
{
    SceneBuilder b;
    b.quad({-4, 0, 4}, {8, 0, 0}, {0, 0, -8}, b.material(lambert(glm::vec3(0.5f))));
    b.sphere({0, 1, 0}, 1, 3, b.material(lambert(glm::vec3(0.5f))));
    b.camera({0, 1, 5}, {0, 1, 0}, 0.8);
    addSky(b, false);
    core::PunctualLight light;
    light.kind = shared::kEmitterDirectional;
    light.intensity = 1;
    const glm::mat3 frame = shared::makeFrame(glm::normalize(glm::vec3(0.2f, 0.9f, 0.4f)));
    b.light(light, glm::dmat4{glm::dmat3(frame)});
    const Learnt court(b, SkyNeed::always);
    ASSERT_NE(court.regions, nullptr);
    ASSERT_EQ(court.settings.environmentEmitter, 1u);
    ASSERT_NEAR(shared::pmfEmitter(court.scene, 0), 0.1f, 0.02f);
    // Those that regions are made from.
    std::map<uint32_t, std::vector<core::Place>> placesOf;
    for (const core::Place& p : core::findPlaces(court.accel, 4096, 1))
        placesOf[shared::findSkyRegion(court.scene, p.position, p.normal)].push_back(p);
    int lit = 0;
    for (const auto& [region, places] : placesOf) {
        const double lamp = bringsOf(court, places, region, 0);
        const double sky = bringsOf(court, places, region, 1), share = sky / (sky + lamp);
        if (!(share < 0.9)) continue;  // shares end at 0.95
        ++lit;
        EXPECT_NEAR(double(shared::skyShare(court.scene, region)), share, 0.1 * share)
            << places.size() << " places";
    }
    EXPECT_GT(lit, 10);
}

/// Of what is drawn on the floor, many times as much goes through the window.
TEST(SkyRegions, OpeningsAreFound)
{
    const Learnt room(windowRoom(false));
    ASSERT_NE(room.regions, nullptr);
    std::mt19937 random(11);
    int whole = 0, here = 0;
    for (int i = 0; i < 20'000; ++i) {
        const glm::vec3 floor(1.8f * uniform(random) - 0.9f, -1.0f, 1.8f * uniform(random) - 0.9f);
        const glm::vec3 p(room.world->placement.toWorld(glm::dvec3(floor)));
        const glm::vec3 up(0, 1, 0);
        const glm::vec2 u(uniform(random), uniform(random));
        for (const uint32_t region : {0u, shared::findSkyRegion(room.scene, p, up)}) {
            shared::EmitterSample s;
            if (!shared::sampleEnvironment(room.scene, room.settings, region, u, s)) continue;
            if (s.wi.y < 0) continue;
            const bool open = !room.accel.occluded({shared::offsetRay(p, up), 1e30f, s.wi, 0});
            (region == 0 ? whole : here) += open;
        }
    }
    EXPECT_GT(whole, 50);
    EXPECT_GT(here, 8 * whole) << here << " and " << whole;
}

TEST(SkyRegions, ThreadsDoNotCount)
{
    const auto world = windowRoom(true).world();
    const core::Accel accel(world);
    const auto all = core::makeSkyRegions(accel, SkyNeed::always);
    const core::ThreadLimit limit(1);
    const auto one = core::makeSkyRegions(accel, SkyNeed::always);
    ASSERT_TRUE(all && one);
    EXPECT_EQ(all->count, one->count);
    EXPECT_EQ(all->words, one->words);
}

TEST(SkyRegions, NothingIsMadeWhereMostOfTheSkyIsSeen)
{
    SceneBuilder b;
    b.quad({-4, 0, 4}, {8, 0, 0}, {0, 0, -8}, b.material(lambert(glm::vec3(0.5f))));
    b.sphere({0, 1, 0}, 1, 3, b.material(lambert(glm::vec3(0.5f))));
    b.camera({0, 1, 5}, {0, 1, 0}, 0.8);
    addSky(b, false);
    EXPECT_EQ(Learnt(b).regions, nullptr);
    b.scene.cameras.clear();
    EXPECT_EQ(Learnt(b).regions, nullptr);
    EXPECT_NE(Learnt(b, SkyNeed::always).regions, nullptr);
}

TEST(SkyRegions, ScenesWithoutASkyOrAPlaceHaveNone)
{
    SceneBuilder dark = windowRoom(false);
    for (glm::vec4& texel : dark.scene.environment->texels) texel = glm::vec4(0, 0, 0, 1);
    EXPECT_EQ(Learnt(dark, SkyNeed::always).regions, nullptr);
    SceneBuilder without = windowRoom(false);
    without.scene.environment.reset();
    EXPECT_EQ(Learnt(without, SkyNeed::always).regions, nullptr);
    SceneBuilder away;  // a camera that looks past all there is
    away.quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, away.material(lambert(glm::vec3(0.5f))));
    away.camera({0, 1, 5}, {0, 1, 10}, 0.8);
    addSky(away, false);
    EXPECT_EQ(Learnt(away).regions, nullptr);
}

/// Where nothing of the sky is ever seen, all of it is drawn.
TEST(SkyRegions, ClosedRoomsDrawTheWholeSky)
{
    SceneBuilder b;
    b.box({-1, -1, -1}, {1, 1, 1}, b.material(lambert(glm::vec3(0.5f))), true);
    b.camera({0, 0, 0.9}, {0, 0, 0}, 0.8);
    addSky(b, true);
    const Learnt closed(b);
    ASSERT_NE(closed.regions, nullptr);
    std::mt19937 random(19);
    for (const uint32_t region : closed.someRegions(10)) {
        for (int i = 0; i < 1000; ++i) {
            const glm::vec3 d = shared::sampleSphere({uniform(random), uniform(random)});
            const float whole = shared::pdfEnvironment(closed.scene, closed.settings, 0, d);
            const float here = shared::pdfEnvironment(closed.scene, closed.settings, region, d);
            ASSERT_NEAR(here, whole, 1e-4f * whole);
        }
    }
}

}  // namespace
