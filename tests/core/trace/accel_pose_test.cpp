// Embree over poses (T38): what a sequence of poses leaves behind finds the hits of one that was
// built there, and the still triangles are not built again.
#include <gtest/gtest.h>

#include <random>

#include "core/gltf/gltf.h"
#include "core/methods/method.h"
#include "core/trace/accel.h"
#include "tests/support/deforming_scenes.h"

namespace {

using namespace tests;

std::shared_ptr<const core::World> animated()
{
    return core::makeWorld(core::loadGltf(REKINDLE_SOURCE_DIR "/assets/animated.gltf"));
}

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
    for (const auto& start : {animated(), movingRoom().world(), deformingRoom().world()}) {
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
    for (const auto& start :
         {animated(), movingRoom().world(), deformingRoom().world(), vanishingRoom().world()}) {
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
