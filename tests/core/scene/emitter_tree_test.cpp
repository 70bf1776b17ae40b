// T31: emitters are chosen from the tree exactly as often as is stated, and none is left out that
// could bring anything.
#include <array>
#include <bit>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "core/scene/emitter_choice.h"
#include "core/scene/emitter_tree.h"
#include "core/trace/scene_view.h"
#include "shared/lights.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/random_values.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;

constexpr int kLamps = 60;

/// Lamps of all kinds with a place, turned every way, over three decades of power; walls between
/// them do not matter here.
SceneBuilder manyLamps()
{
    SceneBuilder b;
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(0, 1);
    const int grey = b.material(lambert(glm::vec3(0.5f)));
    b.quad({-10, 0, 10}, {20, 0, 0}, {0, 0, -20}, grey);
    for (int i = 0; i < kLamps; ++i) {
        const float strength = std::pow(10.0f, 3 * unit(random));
        const int lamp = b.material(emitter(glm::vec3(strength), glm::vec3(0), i % 4 == 0));
        const glm::vec3 at(18 * unit(random) - 9, 5 * unit(random), 18 * unit(random) - 9);
        const glm::vec3 n = shared::sampleSphere({unit(random), unit(random)});
        const glm::mat3 frame = shared::makeFrame(n);
        b.quad(at, 0.3f * unit(random) * frame[0], 0.3f * unit(random) * frame[1], lamp);
    }
    core::PunctualLight light;
    for (int i = 0; i < 10; ++i) {
        light.kind = i % 2 == 0 ? shared::kEmitterPoint : shared::kEmitterSpot;
        light.intensity = 3 * unit(random);
        light.outerCone = 0.2f + unit(random);
        light.innerCone = 0.8f * light.outerCone;
        const glm::mat3 frame =
            shared::makeFrame(shared::sampleSphere({unit(random), unit(random)}));
        glm::dmat4 node{glm::dmat3(frame)};
        node[3] = glm::dvec4(9 * unit(random), 3 * unit(random), 9 * unit(random), 1);
        b.light(light, node);
    }
    b.constantEnvironment(glm::vec3(0.1f));
    return b;
}

/// Each of four as often as its weight says, none without weight, and what is left of the random
/// number is uniform; also where rounding leads to the end.
TEST(EmitterTree, LanesAreChosenByTheirWeights)
{
    std::mt19937 random(13);
    std::uniform_real_distribution<float> unit(0, 1);
    for (int k = 0; k < 2000; ++k) {
        shared::Lanes weights{};
        float total = 0;
        for (int i = 0; i < 4; ++i) {
            if (random() % 3 != 0) weights[i] = std::exp(20 * unit(random) - 10);
            total += weights[i];
        }
        std::array<double, 4> share{};
        constexpr int kSteps = 512;
        for (int i = 0; i <= kSteps; ++i) {
            // The last is the largest random number there is.
            float u = i < kSteps ? (static_cast<float>(i) + 0.5f) / kSteps : 1 - 0x1p-24f, chance;
            const uint32_t lane = shared::chooseLane(weights, u, chance);
            if (total == 0) {
                ASSERT_EQ(chance, 0);
                continue;
            }
            ASSERT_LT(lane, 4u);
            const float weight = weights[static_cast<int>(lane)];
            ASSERT_GT(weight, 0);
            ASSERT_FLOAT_EQ(chance, weight / total);
            ASSERT_TRUE(u >= 0 && u < 1) << u;
            if (i < kSteps) share[lane] += 1.0 / kSteps;
        }
        for (int i = 0; i < 4 && total > 0; ++i)
            ASSERT_NEAR(share[static_cast<size_t>(i)], weights[i] / total, 1.01 / kSteps);
    }
}

struct Place {
    glm::vec3 position, normal;
    uint32_t departure;
};

/// Anywhere in the scene, very near to a lamp too, every fourth of them seen from both sides.
Place somewhere(const core::World& world, std::mt19937& random)
{
    std::uniform_real_distribution<float> unit(0, 1);
    Place p;
    p.position = glm::mix(world.boundsLow, world.boundsHigh,
                          glm::vec3(unit(random), unit(random), unit(random)));
    if (random() % 3 == 0) {
        const shared::Emitter& e = world.emitters[random() % world.treeEmitters];
        p.position = e.a + 1e-3f * shared::sampleSphere({unit(random), unit(random)});
    }
    p.normal = shared::sampleSphere({unit(random), unit(random)});
    p.departure = random() % 4 == 0 ? shared::kAllSides : shared::packReceiver(p.normal);
    return p;
}

TEST(EmitterTree, EmittersAreChosenByTheirProbability)
{
    const auto world = core::chosenByPlace(manyLamps().world());
    ASSERT_EQ(world->treeEmitters, 2u * kLamps + 10);
    const shared::SceneView scene = core::sceneView(*world);
    const shared::PathSettings settings = core::worldSettings(*world);
    std::mt19937 random(5);
    for (int k = 0; k < 20; ++k) {
        const Place p = somewhere(*world, random);
        std::vector<double> observed(settings.emitterCount + 1), expected(observed.size());
        const int draws = 200'000;
        for (int i = 0; i < draws; ++i) {
            const shared::EmitterChoice chosen =
                shared::finishChoice(scene, p.position, p.departure,
                                     shared::beginChoiceFor(scene, settings, uniform(random)));
            if (!(chosen.pmf > 0)) {
                observed.back() += 1;
                continue;
            }
            ASSERT_LT(chosen.emitter, settings.emitterCount);
            ASSERT_FLOAT_EQ(chosen.pmf, shared::pmfEmitterFor(scene, settings, chosen.emitter,
                                                              p.position, p.departure));
            observed[chosen.emitter] += 1;
        }
        double sum = 0;
        for (uint32_t i = 0; i < settings.emitterCount; ++i) {
            const double pmf = static_cast<double>(
                shared::pmfEmitterFor(scene, settings, i, p.position, p.departure));
            expected[i] = pmf * draws;
            sum += pmf;
        }
        ASSERT_LE(sum, 1 + 1e-5);
        expected.back() = std::max(0.0, 1 - sum) * draws;
        const ChiSquare test = chiSquareTest(observed, expected);
        EXPECT_GT(test.p, sidak(kLevel, 20)) << "place " << k;
    }
}

/// Numbers that come stretched, and so have few bits left, are filled up before these are used: at
/// the end of the way no child is taken more often than another.
TEST(EmitterTree, StretchedNumbersAreFilledUp)
{
    constexpr int kSide = 64;
    constexpr uint32_t kNumbers = 256;  // that u can be: after four steps of six nothing is left
    SceneBuilder b;
    const int lamp = b.material(emitter(glm::vec3(1)));
    for (int i = 0; i < kSide * kSide / 2; ++i) {
        const auto x = static_cast<float>(i % kSide), z = static_cast<float>(2 * (i / kSide));
        b.quad({x, 0, z}, {0, 0, 2}, {1, 0, 0}, lamp);
    }
    const auto world = core::chosenByPlace(b.world());
    const shared::SceneView scene = core::sceneView(*world);
    ASSERT_EQ(world->treeEmitters, uint32_t(kSide * kSide));
    std::array<int, 4> taken{};
    for (uint32_t i = 0; i < kNumbers; ++i) {
        const shared::EmitterChoice choice = shared::finishChoice(
            scene, {0, 1000, 0}, shared::kAllSides,
            shared::beginInTree(world->treeEmitters, static_cast<float>(i) / float(kNumbers),
                                1 / float(kNumbers), 1.0f));
        const uint32_t chosen = choice.emitter;
        ASSERT_GT(choice.pmf, 0.0f);
        const glm::uvec4 four = shared::fetchEmitterTree(scene, chosen / 4);
        uint32_t trail = four[static_cast<int>(chosen % 4)];
        uint32_t word = shared::emitterTreeRoot(world->treeEmitters);
        while ((word & shared::kEmitterLeaf) == 0) {
            const auto lane = static_cast<int>(trail & 3);
            const uint32_t link = shared::fetchEmitterTree(scene, word + 8)[lane];
            if ((link & shared::kEmitterLeaf) != 0) ++taken[static_cast<size_t>(lane)];
            word = link;
            trail >>= 2;
        }
    }
    const int mean = kNumbers / 4;
    for (const int count : taken) EXPECT_NEAR(count, mean, kScore * std::sqrt(0.75 * mean));
}

TEST(EmitterTree, NothingThatShinesHereIsLeftOut)
{
    const auto world = core::chosenByPlace(manyLamps().world());
    const shared::SceneView scene = core::sceneView(*world);
    const shared::PathSettings settings = core::worldSettings(*world);
    std::mt19937 random(7);
    int left = 0, shining = 0;
    for (int k = 0; k < 20'000; ++k) {
        const Place p = somewhere(*world, random);
        const uint32_t emitter = static_cast<uint32_t>(random()) % settings.treeEmitters;
        const float pmf = shared::pmfEmitterFor(scene, settings, emitter, p.position, p.departure);
        left += pmf == 0;
        shared::EmitterSample s;
        const glm::vec2 u(uniform(random), uniform(random));
        if (!shared::sampleEmitter(scene, settings, emitter, p.position, 0, u, s)) continue;
        if (p.departure != shared::kAllSides && glm::dot(s.wi, p.normal) <= 0) continue;
        ++shining;
        EXPECT_GT(pmf, 0.0f) << "place " << k << ", emitter " << emitter;
    }
    EXPECT_GT(left, 1000);  // there is something to leave out
    EXPECT_GT(shining, 1000);
}

/// What one sample by the tree and one by power tell of the light on a street with a hundred lamps:
/// the same mean, and a small part of the variance, for a few of them light each place.
TEST(EmitterTree, SameMeanLessNoise)
{
    SceneBuilder b;
    for (int i = 0; i < 100; ++i) {
        const float x = 6.0f * static_cast<float>(i);
        const int lamp = b.material(emitter(glm::vec3(static_cast<float>(1 + i % 3))));
        b.quad({x, 4, 2}, {0, 0, 0.4f}, {-0.4f, 0, 0}, lamp);  // shines down
    }
    const auto world = core::chosenByPlace(b.world());
    const float high = world->positions[0].y, scale = static_cast<float>(world->placement.scale);
    const shared::SceneView scene = core::sceneView(*world);
    shared::PathSettings byPlace = core::worldSettings(*world), byPower = byPlace;
    byPower.treeEmitters = 0;
    ASSERT_EQ(byPlace.treeEmitters, 200u);
    std::mt19937 random(11);
    Moments place, power;
    const uint32_t up = shared::packReceiver({0, 1, 0});
    for (int k = 0; k < 400'000; ++k) {
        const glm::vec3 p(glm::mix(world->boundsLow.x, world->boundsHigh.x, uniform(random)),
                          high - 4 * scale, 0);
        const float u = uniform(random);
        const glm::vec2 v(uniform(random), uniform(random));
        const auto sample = [&](const shared::PathSettings& settings) {
            const shared::EmitterChoice chosen =
                shared::finishChoice(scene, p, up, shared::beginChoiceFor(scene, settings, u));
            shared::EmitterSample s;
            if (!(chosen.pmf > 0) ||
                !shared::sampleEmitter(scene, settings, chosen.emitter, p, 0, v, s))
                return 0.0;
            return static_cast<double>(s.radiance.x * std::max(s.wi.y, 0.0f) /
                                       (s.pdf * chosen.pmf));
        };
        place.add(sample(byPlace));
        power.add(sample(byPower));
    }
    const Comparison test = welch(place, power);
    EXPECT_GT(test.p, kLevel) << place.mean() << " and " << power.mean();
    EXPECT_LT(place.variance(), 0.05 * power.variance());
}

/// Chains, heaps on one spot and large numbers end in trails of 16 ways that lead to each emitter.
TEST(EmitterTree, EveryEmitterHasAWay)
{
    for (const int shape : {0, 1, 2}) {
        const int count = shape == 2 ? 70'000 : 500;
        std::vector<core::EmitterBounds> emitters;
        for (int i = 0; i < count; ++i) {
            const auto x = static_cast<float>(i);
            core::EmitterBounds e;
            if (shape == 0) e.low = glm::vec3(std::exp2(0.2f * x), 0, 0);  // halves split off one
            if (shape == 1) e.low = glm::vec3(1, 2, 3);
            if (shape == 2) e.low = glm::vec3(std::sin(x), std::cos(1.7f * x), x);
            e.high = e.low + glm::vec3(shape == 1 ? 0.0f : 0.1f);
            e.intensity = i % 10 == 0 ? 0 : 1 + i % 5;
            emitters.push_back(e);
        }
        const std::vector<glm::uvec4> words = core::makeEmitterTree(emitters);
        const uint32_t root = shared::emitterTreeRoot(static_cast<uint32_t>(count));
        ASSERT_EQ((words.size() - root) % shared::kEmitterNodeWords, 0u);
        for (uint32_t i = 0; i < emitters.size(); ++i) {
            uint32_t trail = words[i / 4][static_cast<int>(i % 4)], link = root, depth = 0;
            do {
                ASSERT_LT(depth++, core::kMaxTreeDepth);
                ASSERT_LT(link, words.size());
                link = words[link + 8][static_cast<int>(trail & 3u)];
                trail >>= 2;
            } while ((link & shared::kEmitterLeaf) == 0);
            ASSERT_EQ(link & shared::kEmitterIndex, i) << "shape " << shape;
            EXPECT_EQ(trail, 0u);
        }
    }
}

/// Where its node's scale vanishes a point light shines as it would without: it needs no axis.
TEST(EmitterTree, PointLightsNeedNoAxis)
{
    const auto lampsWith = [](double scale) {
        SceneBuilder b;
        b.quad({-9, -1, 9}, {18, 0, 0}, {0, 0, -18}, b.material(lambert(glm::vec3(0.5f))));
        core::PunctualLight light;
        light.kind = shared::kEmitterPoint;
        light.intensity = 1;
        for (int i = 0; i < 9; ++i) {
            glm::dmat4 node(i == 4 ? scale : 1.0);
            node[3] = glm::dvec4(i, 1, 0, 1);
            b.light(light, node);
        }
        return core::chosenByPlace(b.world());
    };
    const auto without = lampsWith(0), with = lampsWith(1);
    ASSERT_EQ(without->treeEmitters, 9u);
    EXPECT_EQ(without->emitterTree, with->emitterTree);
    const shared::SceneView scene = core::sceneView(*without);
    const shared::PathSettings settings = core::worldSettings(*without);
    const glm::vec3 p(without->placement.toWorld(glm::dvec3(4, 0, 0.5)));
    for (uint32_t i = 0; i < 9; ++i) {
        const uint32_t up = shared::packReceiver({0, 1, 0});
        EXPECT_GT(shared::pmfEmitterFor(scene, settings, i, p, up), 0) << i;
    }
}

TEST(EmitterTree, FewEmittersHaveNone)
{
    SceneBuilder b;
    const int lamp = b.material(emitter(glm::vec3(1)));
    b.quad({0, 3, 0}, {1, 0, 0}, {0, 0, 1}, lamp);
    const auto world = b.world();
    EXPECT_EQ(world->treeEmitters, 0u);
    EXPECT_TRUE(world->emitterTree.empty());
    EXPECT_EQ(world->features & shared::kFeatureEmitterTree, 0u);
}

/// What is infinitely far away has half of the choices, whatever the size of the scene.
TEST(EmitterTree, LightFromAfarHasItsShare)
{
    for (const float size : {1.0f, 5000.0f}) {
        SceneBuilder b = manyLamps();
        b.quad({-size, -1, size}, {2 * size, 0, 0}, {0, 0, -2 * size},
               b.material(lambert(glm::vec3(0.5f))));
        const auto world = b.world();
        ASSERT_NE(world->environmentEmitter, shared::kNone);
        EXPECT_NEAR(shared::pmfEmitter(core::sceneView(*world), world->environmentEmitter), 0.5f,
                    1e-4f);
    }
}

}  // namespace
