// The traversal kernel on the device: the triangles that Embree finds (T17), nothing slips through
// closed surfaces (T15), scenes of several scales (T34), instances (T37), rays that are not finite
// hit nothing, degenerate scenes (N24). Validation is on.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/bench/throughput/bench_rays.h"
#include "app/gpu/rays.h"
#include "core/trace/bvh.h"
#include "core/trace/world_bvh.h"
#include "tests/support/process/kept_objects.h"
#include "tests/support/scenes/instanced_scenes.h"
#include "tests/support/scenes/meshes.h"
#include "tests/support/statistics/random_values.h"

namespace {

using glm::vec3;
using gpu::DeviceHit;
using gpu::DeviceRay;
using tests::Mesh;
using tests::Random;
using tests::worldOf;

/// One device for all tests.
gpu::Device& device()
{
    static gpu::Device& instance = tests::kept(
        std::make_unique<gpu::Device>(gpu::DeviceOptions{.index = -1, .validation = true}));
    return instance;
}

std::vector<DeviceRay> raysThrough(vec3 low, vec3 high, size_t count, uint32_t seed)
{
    Random random(seed);
    const vec3 size = high - low;
    std::vector<DeviceRay> rays(count);
    for (DeviceRay& ray : rays) {
        const vec3 target = low + size * random.cube();
        ray.origin = low + size * (2.0f * random.cube() - 0.5f);
        ray.direction = glm::normalize(target - ray.origin);
        if (random() < 0.1f) {  // parallel to an axis: two zero components
            const int axis = static_cast<int>(random.below(3));
            ray.direction = vec3(0);
            ray.direction[axis] = random() < 0.5f ? 1.0f : -1.0f;
        }
    }
    return rays;
}

class GpuTraverse : public testing::Test {
protected:
    void TearDown() override { EXPECT_EQ(gpu::validationMessages(), messages_); }

private:
    const uint64_t messages_ = gpu::validationMessages();
};

/// Distances must agree with the CPU traversal of the same tree but for rounding (compilers
/// contract and reorder what is not marked precise), and with Embree's triangle or its distance:
/// mismatches at most 1e-5.
void expectSameHits(const Mesh& mesh, size_t count, uint32_t seed)
{
    const auto world = worldOf(mesh);
    gpu::GpuRays onDevice(device(), *world, true);
    const core::EmbreeRays embree(world);
    const std::vector<DeviceRay> rays =
        raysThrough(world->boundsLow, world->boundsHigh, count, seed);
    onDevice.setRays(rays);
    onDevice.traceClosest();
    const std::vector<DeviceHit> hits = onDevice.hits();
    onDevice.traceAny();
    const std::vector<DeviceHit> blocked = onDevice.hits();
    std::vector<DeviceHit> expected(count);
    embree.closest1(rays, expected);
    const core::Bvh bvh = core::buildBvh(world->positions, world->triangles);

    const float size = glm::length(world->boundsHigh - world->boundsLow);
    size_t found = 0, unlikeEmbree = 0, unlikeCpu = 0, unlikeAny = 0;
    for (size_t i = 0; i < count; ++i) {
        const bool hit = hits[i].triangle != shared::kNone;
        found += hit;
        unlikeAny += (blocked[i].triangle == 1) != hit;
        core::BvhHit cpu;
        const bool cpuHit =
            core::traceClosest(bvh, world->positions, world->triangles, rays[i].origin,
                               rays[i].direction, 0, shared::kInfinity, cpu);
        unlikeCpu += hit != cpuHit || (hit && std::abs(hits[i].t - cpu.t) > 1e-6f * size);
        const bool other = expected[i].triangle != shared::kNone;
        const bool near = hit && other && std::abs(hits[i].t - expected[i].t) <= 1e-5f * size;
        unlikeEmbree += hit != other ||
                        (hit && hits[i].triangle != expected[i].triangle && !near) ||
                        (hit && hits[i].triangle == expected[i].triangle && !near);
    }
    // A graphics card found four in 100,000; it may fuse products and sums.
    const size_t allowed = 1 + count / (device().isSoftware() ? 100000 : 20000);
    EXPECT_GT(found, count / 20);
    EXPECT_LE(unlikeEmbree, allowed) << "of " << count;
    EXPECT_LE(unlikeCpu, allowed) << "of " << count;
    EXPECT_EQ(unlikeAny, 0u) << "closest and any hit disagree about whether there is one";
}

void expectSameHitsEverywhere(size_t count)
{
    expectSameHits(tests::roomMesh(101), count, 111);
    expectSameHits(tests::soupMesh(20000, 0.2f, 102), count, 112);
    expectSameHits(tests::sphereMesh(60, 2, 0.1f, vec3(0)), count, 113);
}

TEST_F(GpuTraverse, FindsWhatEmbreeFinds)
{
    expectSameHitsEverywhere(100000);
}

TEST_F(GpuTraverse, SlowFindsWhatEmbreeFinds)
{
    expectSameHitsEverywhere(1000000);
}

/// Instances, as triangles of their prototypes, where
/// the CPU's traversal of the same tree has them.
TEST_F(GpuTraverse, FindsInstances)
{
    for (const int count : {3, 50, 500, 300}) {
        SCOPED_TRACE(count);
        tests::SceneBuilder scene = tests::thicket(count);
        const bool isFar = count == 300;  // rays begin among the instances
        if (isFar) scene.quad({-1e4f, -0.1f, 1e4f}, {2e4f, 0, 0}, {0, 0, -2e4f}, 0);
        const auto world = tests::worldOf(scene, core::Instancing::kept);
        ASSERT_EQ(core::entryOf(*core::bvhOf(*world, {})).way != shared::kBvhDone, isFar);
        gpu::GpuRays onDevice(device(), *world, true);
        const auto inWorld = [&](vec3 p) {
            return static_cast<float>(world->placement.scale) * (p - vec3(world->placement.centre));
        };
        const std::vector<DeviceRay> rays =
            isFar ? raysThrough(inWorld({-10, 0, -10}), inWorld({10, 3, 10}), 20000, 5)
                  : raysThrough(world->boundsLow, world->boundsHigh, 20000, 5);
        onDevice.setRays(rays);
        onDevice.traceClosest();
        const std::vector<DeviceHit> hits = onDevice.hits();
        onDevice.traceAny();
        const std::vector<DeviceHit> blocked = onDevice.hits();
        const auto bvh = core::bvhOf(*world, {});
        size_t unlike = 0, unlikeAny = 0, instanced = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
            core::BvhHit cpu;
            const bool cpuHit =
                core::traceClosest(*bvh, world->positions, world->triangles, rays[i].origin,
                                   rays[i].direction, 0, shared::kInfinity, cpu);
            const bool hit = hits[i].triangle != shared::kNone;
            unlike += hit != cpuHit || (hit && std::abs(hits[i].t - cpu.t) > 1e-5f * world->radius);
            unlikeAny += (blocked[i].triangle == 1) != hit;
            instanced += hit && hits[i].triangle >= core::flatTriangles(*world);
        }
        EXPECT_GT(instanced, rays.size() / 50);
        EXPECT_LE(unlike, 2u);
        EXPECT_EQ(unlikeAny, 0u);
    }
}

/// From and to places of both scales, the small one first and most often.
std::vector<DeviceRay> raysAmong(const tests::FarScene& scene, size_t count, uint32_t seed)
{
    Random random(seed);
    std::vector<DeviceRay> rays(count);
    for (DeviceRay& ray : rays) {
        const auto place = [&] {
            const float r = random() < 0.7f ? scene.nearRadius : scene.farRadius;
            return 2.0f * r * (random.cube() - 0.5f);
        };
        ray.origin = place();
        ray.direction = glm::normalize(place() - ray.origin);
    }
    return rays;
}

/// T34 on the device: what the CPU finds in the same tree, and Embree's triangle, or a distance
/// that differs by rounding; that of a triangle of kilometres is of millimetres.
TEST_F(GpuTraverse, FarGeometry)
{
    const size_t count = 50000;
    for (const tests::FarScene& scene : tests::farScenes()) {
        SCOPED_TRACE(scene.name);
        const auto world = worldOf(scene.mesh);
        const core::Bvh bvh = core::buildBvh(world->positions, world->triangles);
        ASSERT_GT(bvh.gridChanges(), 0u);
        gpu::GpuRays onDevice(device(), *world, true);
        const core::EmbreeRays embree(world);
        const std::vector<DeviceRay> rays = raysAmong(scene, count, 151);
        onDevice.setRays(rays);
        onDevice.traceClosest();
        const std::vector<DeviceHit> hits = onDevice.hits();
        onDevice.traceAny();
        const std::vector<DeviceHit> blocked = onDevice.hits();
        std::vector<DeviceHit> expected(count);
        embree.closest1(rays, expected);
        size_t found = 0, unlikeEmbree = 0, unlikeCpu = 0, unlikeAny = 0;
        for (size_t i = 0; i < count; ++i) {
            const uint32_t triangle = hits[i].triangle;
            const bool hit = triangle != shared::kNone;
            found += hit;
            unlikeAny += (blocked[i].triangle == 1) != hit;
            const auto near = [&](float t) {
                return std::abs(hits[i].t - t) <= tests::distanceError(scene.mesh, triangle,
                                                                       rays[i].origin,
                                                                       rays[i].direction);
            };
            core::BvhHit cpu;
            const bool cpuHit =
                core::traceClosest(bvh, world->positions, world->triangles, rays[i].origin,
                                   rays[i].direction, 0, shared::kInfinity, cpu);
            unlikeCpu += hit != cpuHit || (hit && !near(cpu.t));
            const bool other = expected[i].triangle != shared::kNone;
            unlikeEmbree += hit != other || (hit && !near(expected[i].t));
        }
        EXPECT_GT(found, count / 4);
        EXPECT_LE(unlikeEmbree, 1 + count / 10000) << "of " << count;
        EXPECT_LE(unlikeCpu, 1 + count / 100000) << "of " << count;
        EXPECT_EQ(unlikeAny, 0u) << "closest and any hit disagree about whether there is one";
    }
}

TEST_F(GpuTraverse, FewTriangles)
{
    for (uint32_t n = 1; n <= 9; ++n) {
        const Mesh mesh = tests::soupMesh(n, 2.0f, 120 + n);
        const auto world = worldOf(mesh);
        gpu::GpuRays onDevice(device(), *world, true);
        const core::EmbreeRays embree(world);
        const std::vector<DeviceRay> rays =
            raysThrough(world->boundsLow, world->boundsHigh, 2000, n);
        onDevice.setRays(rays);
        onDevice.traceClosest();
        const std::vector<DeviceHit> hits = onDevice.hits();
        std::vector<DeviceHit> expected(rays.size());
        embree.closest1(rays, expected);
        size_t different = 0, found = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
            different += hits[i].triangle != expected[i].triangle;
            found += hits[i].triangle != shared::kNone;
        }
        EXPECT_LE(different, 1u) << n << " triangles";
        EXPECT_GT(found, 20u) << n << " triangles";
    }
}

/// T15 on the device: rays from inside at vertices and at points of edges; counts those that
/// escape. A million at a time, which fits the smallest storage range.
size_t escapes(const Mesh& mesh, vec3 centre, bool vertices, size_t count, uint32_t seed)
{
    const auto world = worldOf(mesh);
    gpu::GpuRays onDevice(device(), *world, true);
    Random random(seed);
    size_t escaped = 0;
    for (size_t begin = 0; begin < count; begin += 1000000) {
        std::vector<DeviceRay> rays(std::min<size_t>(1000000, count - begin));
        for (DeviceRay& ray : rays) {
            const core::WorldTriangle& t = mesh.triangles[random.below(mesh.triangles.size())];
            const uint32_t index[3] = {t.v0, t.v1, t.v2};
            const uint32_t k = random.below(3);
            const vec3 a = mesh.positions[index[k]], b = mesh.positions[index[(k + 1) % 3]];
            ray.origin = centre + 0.5f * (random.cube() - 0.5f);
            ray.direction = (vertices ? a : glm::mix(a, b, random())) - ray.origin;
        }
        onDevice.setRays(rays);
        onDevice.traceClosest();
        for (const DeviceHit& hit : onDevice.hits()) escaped += hit.triangle == shared::kNone;
    }
    return escaped;
}

void expectWatertightOnDevice(size_t count)
{
    const vec3 far(148376, 1234, -223423);
    for (const float bump : {0.0f, 0.05f}) {
        for (const bool vertices : {true, false}) {
            EXPECT_EQ(
                escapes(tests::sphereMesh(100, 2, bump, vec3(0)), vec3(0), vertices, count, 131),
                0u);
            EXPECT_LE(escapes(tests::sphereMesh(100, 2, bump, far), far, vertices, count, 132),
                      static_cast<size_t>(2e-5 * static_cast<double>(count)));
        }
    }
}

TEST_F(GpuTraverse, Watertight)
{
    expectWatertightOnDevice(200000);
}

TEST_F(GpuTraverse, SlowWatertight)
{
    expectWatertightOnDevice(10000000);
}

TEST_F(GpuTraverse, RaysThatAreNotFiniteHitNothing)
{
    const auto world = worldOf(tests::sphereMesh(10, 2, 0, vec3(0)));
    gpu::GpuRays onDevice(device(), *world, true);
    const float nan = std::numeric_limits<float>::quiet_NaN(),
                inf = std::numeric_limits<float>::infinity();
    // Every other ray is sound, so that lanes with and without work mix.
    std::vector<DeviceRay> rays;
    const DeviceRay sound{vec3(0), 0, {0.1f, 0.2f, 1}, shared::kInfinity};
    const auto add = [&](const DeviceRay& bad) {
        rays.push_back(sound);
        rays.push_back(bad);
    };
    add({vec3(0), 0, vec3(0), shared::kInfinity});
    add({vec3(0), 5, {0, 0, 1}, shared::kInfinity});
    add({vec3(0), 0, {0, 0, 1}, 1});
    for (const float bad : {nan, inf, -inf}) {
        for (int axis = 0; axis < 3; ++axis) {
            vec3 v(0.1f, 0.2f, 0.3f);
            v[axis] = bad;
            add({vec3(0), 0, v, shared::kInfinity});
            add({v, 0, {0, 0, 1}, shared::kInfinity});
        }
    }
    onDevice.setRays(rays);
    onDevice.traceClosest();
    const std::vector<DeviceHit> closest = onDevice.hits();
    onDevice.traceAny();
    const std::vector<DeviceHit> any = onDevice.hits();
    for (size_t i = 0; i < rays.size(); ++i) {
        EXPECT_EQ(closest[i].triangle != shared::kNone, i % 2 == 0) << "ray " << i;
        EXPECT_EQ(any[i].triangle, i % 2 == 0 ? 1u : 0u) << "ray " << i;
    }
}

TEST_F(GpuTraverse, IdenticalAndNestedTriangles)
{
    for (const Mesh& mesh :
         {tests::identicalMesh(2000), tests::nestedMesh(2000), tests::lineMesh(2000, 1.01f)}) {
        const auto world = worldOf(mesh);
        gpu::GpuRays onDevice(device(), *world, true);
        const core::EmbreeRays embree(world);
        Random random(141);
        std::vector<DeviceRay> rays(2000);
        for (DeviceRay& ray : rays) {  // at the middles of triangles, from close by, not grazing
            const core::WorldTriangle& t = mesh.triangles[random.below(mesh.triangles.size())];
            const vec3 a = mesh.positions[t.v0], b = mesh.positions[t.v1], c = mesh.positions[t.v2];
            const vec3 middle = (a + b + c) / 3.0f;
            const vec3 n = glm::normalize(glm::cross(b - a, c - a));
            ray.origin = middle + glm::length(b - a) * (0.3f * (random.cube() - 0.5f) + 0.5f * n);
            ray.direction = middle - ray.origin;
        }
        onDevice.setRays(rays);
        onDevice.traceClosest();
        const std::vector<DeviceHit> hits = onDevice.hits();
        std::vector<DeviceHit> expected(rays.size());
        embree.closest1(rays, expected);
        size_t different = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
            const bool hit = hits[i].triangle != shared::kNone;
            const bool other = expected[i].triangle != shared::kNone;
            const float difference = std::abs(hits[i].t - expected[i].t);
            different += hit != other || (hit && difference > 1e-4f * expected[i].t + 1e-5f);
        }
        EXPECT_LE(different, 1u);
    }
}

}  // namespace
