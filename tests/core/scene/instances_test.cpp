// What is stored once and shown by instances (T37): which uses of meshes, where, under what slots.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include <glm/gtc/matrix_transform.hpp>

#include "core/scene/instances.h"
#include "core/trace/scene_view.h"
#include "shared/instances.h"
#include "tests/support/scenes/animated_scenes.h"
#include "tests/support/scenes/instanced_scenes.h"

namespace {

using core::Instancing;
using namespace tests;

/// Middle and normal of a triangle, rounded so that one rounding does not tell two apart.
using TrianglePlace = std::array<long, 6>;

TrianglePlace placeOf(const shared::Triangle& t)
{
    const glm::vec3 a = shared::xyz(t.v0), b = shared::xyz(t.v1), c = shared::xyz(t.v2);
    const glm::vec3 middle = (a + b + c) / 3.0f;
    const glm::vec3 n = glm::normalize(glm::cross(b - a, c - a));
    TrianglePlace place;
    for (int i = 0; i < 3; ++i) {
        place[static_cast<size_t>(i)] = std::lround(middle[i] * 1e4f);
        place[static_cast<size_t>(3 + i)] = std::lround(n[i] * 1e2f);
    }
    return place;
}

/// All slots under which triangles are shown.
std::vector<uint32_t> shownSlots(const core::World& world)
{
    std::vector<uint32_t> slots;
    for (uint32_t i = 0; i < core::flatTriangles(world); ++i) slots.push_back(i);
    const auto blocks = core::instanceSlots({world.prototypes.data(), world.prototypes.size()},
                                            core::prototypeTriangles(world));
    for (size_t p = 0; p < world.prototypes.size(); ++p)
        for (uint32_t i = 0; i < world.prototypes[p].instances.size(); ++i)
            for (uint32_t k = 0; k < world.prototypes[p].triangles.size(); ++k)
                slots.push_back((*blocks)[p].at(i) + k);
    return slots;
}

/// How many of the triangles of `a` are not, within rounding, among those of `b`.
size_t missing(const core::World& a, const core::World& b)
{
    const auto places = [](const core::World& world) {
        std::multiset<TrianglePlace> all;
        const shared::SceneView view = core::sceneView(world);
        for (const uint32_t slot : shownSlots(world))
            all.insert(placeOf(shared::triangleInSlot(view, slot)));
        return all;
    };
    const std::multiset<TrianglePlace> inB = places(b);
    size_t count = 0;
    for (const TrianglePlace& place : places(a)) {
        bool found = false;
        for (long shift = 0; shift < 729 && !found; ++shift) {  // a unit up or down in each
            TrianglePlace near = place;
            for (size_t i = 0, rest = static_cast<size_t>(shift); i < 6; ++i, rest /= 3)
                near[i] += static_cast<long>((rest + 1) % 3) - 1;
            found = inB.count(near) > 0;
        }
        count += found ? 0 : 1;
    }
    return count;
}

TEST(Instances, ShowWhatFlatteningShows)
{
    const SceneBuilder scene = thicket(20);
    const auto flat = worldOf(scene, Instancing::flat), kept = worldOf(scene, Instancing::kept);
    ASSERT_EQ(kept->prototypes.size(), 2u) << "one for what is mirrored";
    EXPECT_EQ(kept->instances.size(), 20u);
    EXPECT_EQ(core::shownTriangles(*kept), flat->triangles.size());
    EXPECT_EQ(kept->triangles.size(), 4u + 2 * 130u) << "ground, lamp, and two of the thing";
    EXPECT_EQ(missing(*kept, *flat), 0u);
    EXPECT_EQ(missing(*flat, *kept), 0u);
    EXPECT_EQ(kept->emitters.size(), flat->emitters.size());
    EXPECT_TRUE((kept->features & shared::kFeatureInstances) != 0);
    EXPECT_TRUE((flat->features & shared::kFeatureInstances) == 0);
    EXPECT_TRUE(flat->instances.empty() && flat->instanceTable.empty());
    for (int a = 0; a < 3; ++a) {  // boxes of turned boxes are somewhat larger
        EXPECT_LE(kept->boundsLow[a], flat->boundsLow[a] + 1e-5f);
        EXPECT_GE(kept->boundsHigh[a], flat->boundsHigh[a] - 1e-5f);
    }
}

/// By itself only where it saves a million triangles.
TEST(Instances, AreMadeWhereTheySaveALot)
{
    const Thing large{.levels = 6};  // 32770 triangles
    const auto instancesOf = [](const SceneBuilder& scene) {
        return worldOf(scene, Instancing::automatic)->instances.size();
    };
    EXPECT_EQ(instancesOf(thicket(33, large)), 0u) << "two groups: 31 saved";
    EXPECT_EQ(instancesOf(thicket(35, large)), 35u);
    EXPECT_EQ(instancesOf(thicket(1000)), 0u);
}

TEST(Instances, AreNeitherLampsNorPanesNorInMotion)
{
    core::Material pane = glossy(glm::vec3(1), 0, 0);
    pane.data.transmission = 1;
    for (const core::Material& material : {emitter(glm::vec3(3)), pane}) {
        Thing thing;
        thing.leaf = material;
        const SceneBuilder scene = thicket(9, thing);
        const auto flat = worldOf(scene, Instancing::flat), kept = worldOf(scene, Instancing::kept);
        EXPECT_EQ(kept->instances.size(), 9u);
        EXPECT_EQ(core::flatTriangles(*kept), 4u + 9 * 2u) << "the leaves are written out";
        EXPECT_EQ(core::shownTriangles(*kept), flat->triangles.size());
        EXPECT_EQ(kept->emitters.size(), flat->emitters.size());
    }
    SceneBuilder moving = thicket(9);
    const auto node = static_cast<int>(moving.scene.nodes.size()) - 2;  // the last thing
    ASSERT_FALSE(moving.scene.nodes[static_cast<size_t>(node)].meshes.empty());
    moving.scene.nodes[static_cast<size_t>(node)].local = core::Transform();
    animate(moving.scene, {channelOf(node, core::AnimationChannel::Path::translation,
                                     {{0, 0, 0, 0}, {1, 2, 3, 0}})});
    const auto world = worldOf(moving, Instancing::kept);
    EXPECT_EQ(world->instances.size(), 8u);
    EXPECT_EQ(world->movingTriangles.size(), 130u);
    const auto later = core::poseWorld(world, 0.5);
    EXPECT_TRUE(core::sameTopology(*world, *later));
    EXPECT_TRUE(later->instances.sharesWith(world->instances));
    const auto fresh = core::makeWorld(world->scene, 0.5, 0, world->placement, Instancing::kept);
    EXPECT_TRUE(fresh->instanceTable == later->instanceTable);
    EXPECT_TRUE(fresh->positions == later->positions);
    EXPECT_EQ(fresh->boundsHigh, later->boundsHigh);
}

/// A matrix that flattens the mesh has no inverse; one so small loses the triangles' normals.
TEST(Instances, AreSoundOrWrittenOut)
{
    SceneBuilder scene = thicket(9);
    const std::vector<int> meshes{0, 1};
    const auto at = [](glm::dvec3 scale) { return glm::scale(glm::dmat4(1), scale); };
    scene.node(at({1, 1, 0}), meshes);
    scene.node(at({1, 1, 1e-9}), meshes);
    scene.node(at(glm::dvec3(1e-12)), meshes);
    const auto kept = worldOf(scene, Instancing::kept);
    EXPECT_EQ(kept->instances.size(), 9u);
    EXPECT_GT(core::flatTriangles(*kept), 4u);
    for (const shared::InstanceMatrix& m : kept->instances)
        for (const glm::vec4& row : {m.row0, m.row1, m.row2})
            for (int i = 0; i < 4; ++i) EXPECT_TRUE(std::isfinite(row[i]));
}

TEST(Instances, HaveSlotsOfTheirOwn)
{
    const auto world = worldOf(thicket(50), Instancing::kept);
    const std::vector<uint32_t> slots = shownSlots(*world);
    EXPECT_EQ(std::set<uint32_t>(slots.begin(), slots.end()).size(), slots.size());
    EXPECT_EQ(std::count(slots.begin(), slots.end(), shared::kNone), 0);
    // Numbers are given out to the last: 2^15 instances of 2^17 slots are too many, one less is
    // not.
    std::vector<core::Prototype> one(1);
    const std::vector<core::IndexRange> stored{{0, 1 << 17}};
    one[0].instances = {0, (1 << 15) - (1 << 10) - 1};
    EXPECT_TRUE(core::instanceSlots(one, stored).has_value());
    one[0].instances.end += 1;
    EXPECT_FALSE(core::instanceSlots(one, stored).has_value());
}

/// A node with placements is as many nodes.
/// Of six places of a node, every `mirrored`-th is mirrored.
void expectPlacements(int mirrored)
{
    SceneBuilder nodes = thicket(0), placed = thicket(0);
    const auto place = [mirrored](int i) {
        core::MeshPlacement p;
        p.translation = {0.9f * static_cast<float>(i), 0.5f, 0.1f};
        p.rotation = glm::normalize(glm::quat(1, 0.3f * static_cast<float>(i), 0.2f, -0.4f));
        p.scale = {0.5f, 0.7f, i % mirrored == 0 ? -0.6f : 0.9f};
        return p;
    };
    const glm::dmat4 below = glm::rotate(glm::dmat4(2), 0.5, glm::dvec3(0, 1, 0));
    std::vector<core::MeshPlacement> placements;
    for (int i = 0; i < 6; ++i) {
        const core::MeshPlacement p = place(i);
        placements.push_back(p);
        const glm::dmat4 local =
            glm::scale(glm::translate(glm::dmat4(1), glm::dvec3(p.translation)) *
                           glm::dmat4(glm::mat4_cast(p.rotation)),
                       glm::dvec3(p.scale));
        nodes.node(below * local, {0, 1});
    }
    const int node = placed.node(below, {0, 1});
    placed.scene.nodes[static_cast<size_t>(node)].placements = 0;
    placed.scene.placements.push_back(placements);
    for (const Instancing instancing : {Instancing::flat, Instancing::kept}) {
        const auto a = worldOf(nodes, instancing), b = worldOf(placed, instancing);
        EXPECT_EQ(core::shownTriangles(*a), 4 + 6 * 130u);
        EXPECT_EQ(core::shownTriangles(*b), core::shownTriangles(*a));
        EXPECT_EQ(b->instances.size(), a->instances.size());
        EXPECT_EQ(missing(*a, *b), 0u);
    }
}

TEST(Instances, PlacementsOfANodeAreNodes)
{
    expectPlacements(2);
}

/// One that is alone is no instance: it is written out, though its node has others.
TEST(Instances, APlaceThatIsAloneIsShown)
{
    expectPlacements(6);
}

}  // namespace
