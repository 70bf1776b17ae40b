// Embree over poses (T38): what a sequence of poses leaves behind finds the hits of one that was
// built there, and the still triangles are not built again.
#include <array>
#include <random>

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "core/methods/method.h"
#include "core/trace/accel.h"
#include "tests/support/scenes/asset.h"
#include "tests/support/scenes/deforming_scenes.h"

namespace {

using namespace tests;

std::vector<core::Ray> raysThrough(const core::World& world, size_t count)
{
    std::mt19937 engine(4);
    std::uniform_real_distribution<float> uniform(0, 1);
    const auto point = [&] {
        const glm::vec3 weight(uniform(engine), uniform(engine), uniform(engine));
        return glm::mix(world.boundsLow, world.boundsHigh, weight);
    };
    std::vector<core::Ray> rays(count);
    for (core::Ray& ray : rays) {
        ray.origin = point();
        ray.direction = glm::normalize(point() - ray.origin);
        ray.tMax = uniform(engine) < 0.3f ? uniform(engine) : shared::kInfinity;
        ray.seed = static_cast<uint32_t>(engine());
    }
    return rays;
}

/// Single rays and packets, closest and any; alpha included, as it follows from the seeds.
void expectSameHits(const core::Accel& a, const core::Accel& b)
{
    const std::vector<core::Ray> rays = raysThrough(b.world(), 4000);
    std::vector<shared::Hit> x(rays.size()), y(rays.size());
    std::vector<uint8_t> blockedX(rays.size()), blockedY(rays.size());
    a.closest(rays, x.data());
    b.closest(rays, y.data());
    a.occluded(rays, blockedX.data());
    b.occluded(rays, blockedY.data());
    size_t hits = 0, blocked = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(x[i].slot, y[i].slot) << i;
        ASSERT_EQ(blockedX[i], blockedY[i]) << i;
        shared::Hit single;
        const bool found = a.closest(rays[i], single);
        ASSERT_EQ(found, x[i].slot != shared::kNone) << i;
        ASSERT_EQ(a.occluded(rays[i]), blockedX[i] != 0) << i;
        blocked += blockedX[i];
        if (!found) continue;
        ++hits;
        ASSERT_EQ(x[i].t, y[i].t) << i;
        ASSERT_EQ(x[i].barycentrics, y[i].barycentrics) << i;
        ASSERT_EQ(single.slot, x[i].slot) << i;
    }
    EXPECT_GT(hits, rays.size() / 10);
    EXPECT_GT(blocked, rays.size() / 10);
}

TEST(AccelPose, SequencesFindTheHitsOfFreshOnes)
{
    for (const auto& start : {asset("animated"), movingRoom().world(), deformingRoom().world()}) {
        ASSERT_FALSE(start->movingTriangles.empty());
        core::Accel accel(start);
        std::shared_ptr<const core::World> world = start;
        for (const double time : {0.3, 1.1, 0.6, 2.4}) {
            SCOPED_TRACE(time);
            world = core::poseWorld(world, time);
            ASSERT_TRUE(core::sameTopology(*world, *start));
            accel.setPose(world);
            EXPECT_EQ(&accel.world(), world.get());
            const core::Accel fresh(core::makeWorld(start->scene, time, 0, start->placement));
            expectSameHits(accel, fresh);
        }
    }
}

/// More moving uses of meshes than are geometries of their own, of two groups that go different
/// ways through each other, one of them cut out by its alpha.
TEST(AccelPose, ManyUsesFindTheHitsOfFreshOnes)
{
    SceneBuilder b;
    core::Material veil = lambert(glm::vec3(0.5f));
    veil.data.alpha = 0.4f;
    veil.data.flags |= shared::kMaterialAlphaBlend;
    const std::vector<glm::vec3> corners{{0, 0, 0}, {0.8f, 0, 0.1f}, {0, 0.8f, 0.2f}};
    const int solid = b.looseMesh(corners, {{0, 1, 2}}, b.material(lambert(glm::vec3(0.5f))));
    const int cut = b.looseMesh(corners, {{0, 1, 2}}, b.material(veil));
    b.quad({-30, -30, -1}, {60, 0, 0}, {0, 60, 0}, b.material(lambert(glm::vec3(0.5f))));
    const std::array<int, 2> groups{b.node(glm::dmat4(1), {}), b.node(glm::dmat4(1), {})};
    for (const int group : groups)
        b.scene.nodes[static_cast<size_t>(group)].local = core::Transform();
    for (int i = 0; i < 70'000; ++i) {
        const glm::dvec3 place(i % 41 - 20, i / 41 % 41 - 20, i / 1681);
        b.node(glm::translate(glm::dmat4(1), place), {i % 2 == 0 ? solid : cut},
               groups[static_cast<size_t>(i) % 2]);
    }
    animate(b.scene, {channelOf(groups[0], core::AnimationChannel::Path::translation,
                                {{0, 0, 0, 0}, {9, 0, 3, 0}}),
                      channelOf(groups[1], core::AnimationChannel::Path::translation,
                                {{0, 0, 0, 0}, {0, -9, 5, 0}})});
    const auto start = b.world();
    ASSERT_GT(start->movingPieces.size(), 65'536u);
    core::Accel accel(start);
    const auto later = core::poseWorld(start, 0.7);
    ASSERT_TRUE(core::sameTopology(*later, *start));
    accel.setPose(later);
    expectSameHits(accel, core::Accel(core::makeWorld(start->scene, 0.7, 0, start->placement)));
    for (const core::Ray& ray : raysThrough(*later, 1000)) {
        shared::Hit hit;
        if (!accel.closest(ray, hit)) continue;
        const core::WorldTriangle& t = later->triangles[hit.slot];
        const glm::vec2 w = hit.barycentrics;
        const glm::vec3 there = (1 - w.x - w.y) * later->positions[t.v0] +
                                w.x * later->positions[t.v1] + w.y * later->positions[t.v2];
        ASSERT_LT(glm::distance(there, ray.origin + hit.t * ray.direction), 1e-4f);
    }
}

TEST(AccelPose, OutlivesTheWorldsItHasLeft)
{
    core::Accel accel(movingRoom().world(), {}, {}, core::AccelQuality::compact);
    for (const double time : {0.5, 1.5})
        accel.setPose(core::poseWorld(std::make_shared<core::World>(accel.world()), time));
    const core::Accel fresh(core::makeWorld(accel.world().scene, 1.5, 0, accel.world().placement),
                            {}, {}, core::AccelQuality::compact);
    expectSameHits(accel, fresh);
}

/// To the bit, also across a pose with other triangles.
TEST(PathPose, PicturesAfterPosesAreThoseOfFreshWorlds)
{
    for (const auto& start : {asset("animated"), movingRoom().world(), deformingRoom().world(),
                              vanishingRoom().world()}) {
        const auto renderer = core::makeRenderer("path");
        const auto fresh = core::makeRenderer("path");
        std::shared_ptr<const core::World> world = start;
        core::Estimate before;
        for (const double time : {0.0, 0.7, 1.6, 0.7}) {
            SCOPED_TRACE(time);
            world = core::poseWorld(world, time);
            const core::Estimate film = filmOf(*renderer, world);
            const core::Estimate expected =
                filmOf(*fresh, core::makeWorld(start->scene, time, 0, start->placement));
            EXPECT_TRUE(film.mean.pixels == expected.mean.pixels);
            EXPECT_TRUE(film.variance.pixels == expected.variance.pixels);
            EXPECT_FALSE(film.mean.pixels == before.mean.pixels) << "it moves";
            before = film;
        }
    }
}

}  // namespace
