// T31: the tree of emitters chooses where it strays less than choice by power, and nowhere else; in
// all poses alike.
#include <array>

#include <gtest/gtest.h>

#include "core/scene/emitter_choice.h"
#include "core/scene/emitter_tree.h"
#include "core/scene/shown_places.h"
#include "tests/support/scenes/animated_scenes.h"
#include "tests/support/scenes/instanced_scenes.h"
#include "tests/support/scenes/test_scenes.h"

namespace {

using namespace tests;
using Path = core::AnimationChannel::Path;

/// Lamps in a row over a street, each of which lights a small part of it.
SceneBuilder street(int lamps)
{
    SceneBuilder b;
    const auto length = static_cast<float>(6 * lamps);
    b.quad({0, 0, 3}, {length, 0, 0}, {0, 0, -6}, b.material(lambert(glm::vec3(0.5f))));
    const int lamp = b.material(emitter(glm::vec3(2)));
    for (int i = 0; i < lamps; ++i)
        b.quad({static_cast<float>(6 * i), 3, 0}, {0, 0, 0.4f}, {-0.4f, 0, 0}, lamp);
    return b;
}

/// Point lights side by side, so high over the floor that each brings the same everywhere.
SceneBuilder chandelier(int lamps)
{
    SceneBuilder b;
    b.quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, b.material(lambert(glm::vec3(0.5f))));
    for (int i = 0; i < lamps; ++i) {
        core::PunctualLight light;
        light.kind = shared::kEmitterPoint;
        light.intensity = 100;
        glm::dmat4 node(1);
        node[3] = glm::dvec4(0.01 * i, 50, 0, 1);
        b.light(light, node);
    }
    return b;
}

/// Of triangles.
std::vector<core::EmitterBounds> boundsOf(const core::World& world)
{
    std::vector<core::EmitterBounds> bounds;
    for (const shared::Emitter& e : world.emitters) {
        const glm::vec3 n = glm::cross(e.b - e.a, e.c - e.a);
        core::EmitterBounds of{glm::min(e.a, glm::min(e.b, e.c)), glm::max(e.a, glm::max(e.b, e.c)),
                               glm::normalize(n)};
        of.intensity = 0.5 * static_cast<double>(glm::length(n) * shared::luminance(e.radiance));
        bounds.push_back(of);
    }
    return bounds;
}

TEST(EmitterChoice, TheTreeChoosesWhereItPays)
{
    const auto world = street(60).world();
    EXPECT_EQ(world->treeEmitters, 120u);
    EXPECT_NE(world->features & shared::kFeatureEmitterTree, 0u);
    const auto high = chandelier(60).world();
    EXPECT_EQ(high->treeEmitters, 0u);
    EXPECT_EQ(high->features & shared::kFeatureEmitterTree, 0u);
    EXPECT_FALSE(high->emitterTree.empty());
}

/// Of lamps over a floor, half shine up. By power every other connection is lost: with n lamps that
/// bring f / n each the deviation is that of a coin, f. By the tree it is less than a quarter: only
/// near the root do both kinds share cones. Without those that shine up neither strays, and there
/// is nothing to gain.
TEST(EmitterChoice, GainIsTheRatioOfDeviations)
{
    for (const bool up : {false, true}) {
        SceneBuilder b;
        b.quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, b.material(lambert(glm::vec3(0.5f))));
        const int lamp = b.material(emitter(glm::vec3(1000)));
        for (int i = 0; i < 16; ++i) {
            const float x = 0.02f * static_cast<float>(i), turn = up && i % 2 == 1 ? -1.0f : 1.0f;
            b.mesh({{x, 50, 0}, {x, 50, 0.01f}, {x - turn * 0.01f, 50, 0}}, {{0, 1, 2}}, lamp);
        }
        const auto world = core::chosenByPlace(b.world());
        ASSERT_EQ(world->treeEmitters, 16u);
        const std::vector<core::EmitterBounds> bounds = boundsOf(*world);
        const double gain = core::treeGain(*world, bounds);
        if (up)
            EXPECT_GT(gain, 4);
        else
            EXPECT_NEAR(gain, 1, 0.3);
        EXPECT_EQ(core::treeGain(*world, bounds), gain);
    }
}

/// A street of paving stones that are instances has its places where one of triangles has them: in
/// the space of the prototype they would all be at the middle of the street.
TEST(EmitterChoice, PlacesAreOnWhatInstancesShow)
{
    SceneBuilder b = street(60);
    b.scene.meshes[0].triangles.clear();
    const int stone = b.looseMesh({{0, 0, 3}, {6, 0, 3}, {6, 0, -3}, {0, 0, -3}},
                                  {{0, 1, 2}, {0, 2, 3}}, b.scene.meshes[0].material);
    for (int i = 0; i < 60; ++i) {
        glm::dmat4 node(1);
        node[3] = glm::dvec4(6 * i, 0, 0, 1);
        b.node(node, {stone});
    }
    const auto flat = worldOf(b, core::Instancing::flat), kept = worldOf(b, core::Instancing::kept);
    ASSERT_EQ(kept->instances.size(), 60u);
    EXPECT_EQ(kept->treeEmitters, 120u);
    const double gain = core::treeGain(*flat, boundsOf(*flat));
    EXPECT_NEAR(core::treeGain(*kept, boundsOf(*kept)), gain, 0.2 * gain);
}

/// Where nearly everything shines, the few triangles that do not are drawn without looking for
/// them.
TEST(EmitterChoice, PlacesAreFoundBetweenManyLamps)
{
    SceneBuilder b;
    b.quad({0, 0, 1}, {1, 0, 0}, {0, 0, -1}, b.material(lambert(glm::vec3(0.5f))));
    b.sphere({0, 9, 0}, 1, 6, b.material(emitter(glm::vec3(1))));
    const auto world = b.world();
    ASSERT_GT(world->emitters.size(), 30'000u);
    const core::ShownPlaces places(*world);
    ASSERT_FALSE(places.empty());
    const auto floor = static_cast<double>(world->placement.toWorld(glm::dvec3(0)).y);
    core::Pcg32 random(1);
    std::array<int, 2> halves{};
    for (int k = 0; k < 400; ++k) {
        core::Pcg32 before = random;
        const glm::vec3 p = places.draw(random).position;
        EXPECT_NEAR(static_cast<double>(p.y), floor, 1e-6);
        const glm::dvec3 at = world->placement.toFile(glm::dvec3(p));
        ++halves[at.x + at.z > 1 ? 1 : 0];
        int drawn = 0;
        const auto isThere = [&] {
            core::Pcg32 a = before, c = random;
            return a.bits() == c.bits() && a.bits() == c.bits();
        };
        for (; drawn <= core::ShownPlaces::kTries + 6 && !isThere(); ++drawn) before.bits();
        EXPECT_LE(drawn, core::ShownPlaces::kTries + 6);
    }
    EXPECT_NEAR(halves[0], 200, 5 * 10);  // of the floor's two triangles, five deviations
}

TEST(EmitterChoice, CanBeTold)
{
    const auto high = chandelier(60).world(), place = core::chosenByPlace(high);
    EXPECT_EQ(place->treeEmitters, 60u);
    EXPECT_EQ(place->features, high->features | shared::kFeatureEmitterTree);
    EXPECT_TRUE(place->emitterTree.sharesWith(high->emitterTree));
    EXPECT_EQ(core::chosenByPower(high), high);
    EXPECT_EQ(core::chosenByPlace(place), place);
    expectSameWorld(*core::chosenByPower(place), *high);
    const auto few = street(3).world();
    EXPECT_EQ(core::chosenByPlace(few), few);
}

/// Lamps gather over a floor: what the first pose has decided stays, so that kernels do.
TEST(EmitterChoice, StaysInAllPoses)
{
    SceneBuilder b = street(60);
    core::PunctualLight light;
    light.kind = shared::kEmitterPoint;
    light.intensity = 1;
    b.light(light, glm::dmat4(1));
    const auto moving = static_cast<int>(b.scene.nodes.size()) - 1;
    animate(b.scene, {channelOf(moving, Path::translation, {{0, 1, 0, 0}, {9, 1, 0, 0}})});
    const auto world = b.world();
    for (const auto& first : {world, core::chosenByPower(world)}) {
        const auto other = core::poseWorld(first, 0.5);
        EXPECT_FALSE(other->emitters.sharesWith(first->emitters));
        EXPECT_FALSE(other->emitterTree == first->emitterTree);
        EXPECT_EQ(other->treeEmitters, first->treeEmitters);
        EXPECT_EQ(other->features, first->features);
    }
    EXPECT_EQ(world->treeEmitters, 121u);
}

/// Also in those in which there are other triangles, which are flattened anew.
TEST(EmitterChoice, StaysWhereTrianglesComeAndGo)
{
    SceneBuilder b = street(60);
    b.quad({0, 1, 1}, {1, 0, 0}, {0, 0, -1}, b.material(lambert(glm::vec3(0.5f))));
    const auto stone = static_cast<int>(b.scene.nodes.size()) - 1;
    animate(b.scene, {channelOf(stone, Path::scale, {{1, 1, 1, 0}, glm::vec4(0), {1, 1, 1, 0}})});
    const auto world = b.world();
    ASSERT_EQ(world->treeEmitters, 120u);
    for (const auto& first : {world, core::chosenByPower(world)}) {
        const auto without = core::poseWorld(first, 1);
        EXPECT_FALSE(core::sameTopology(*without, *first));
        EXPECT_EQ(without->treeEmitters, first->treeEmitters);
        EXPECT_EQ(without->features, first->features);
        const auto back = core::poseWorld(without, 0);
        EXPECT_EQ(back->treeEmitters, first->treeEmitters);
        EXPECT_EQ(back->emitterTree, first->emitterTree);
    }
}

}  // namespace
