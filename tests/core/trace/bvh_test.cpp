// The BVH as a data structure: every triangle reachable through boxes that contain it, bounded
// depth on the shapes that break builders (N24), the same bytes on any number of threads,
// cancellation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "core/trace/bvh.h"
#include "tests/support/scenes/bvh_walk.h"
#include "tests/support/scenes/meshes.h"

namespace {

using core::Bvh;
using core::BvhOptions;
using tests::bvhOf;
using tests::expectSound;
using tests::Mesh;

void expectSoundAllWays(const Mesh& mesh)
{
    for (const float budget : {0.0f, 0.3f, 2.0f}) {
        for (const uint32_t leafSize : {1u, 4u, 8u, 14u}) {
            const BvhOptions options{.leafSize = leafSize, .duplicateBudget = budget};
            SCOPED_TRACE(testing::Message() << "budget " << budget << ", leaf size " << leafSize);
            expectSound(mesh, bvhOf(mesh, options), options);
        }
    }
}

bool sameBytes(const Bvh& a, const Bvh& b)
{
    return a.moving.nodes == b.moving.nodes && a.still.nodes == b.still.nodes &&
           a.moving.slots == b.moving.slots && a.still.slots == b.still.slots &&
           a.gridLow == b.gridLow && a.gridScale == b.gridScale && a.depth == b.depth;
}

TEST(Bvh, FewTriangles)
{
    for (uint32_t n = 0; n <= 9; ++n) expectSoundAllWays(tests::soupMesh(n, 0.5f, 11 + n));
}

TEST(Bvh, Room)
{
    expectSoundAllWays(tests::roomMesh(1));
}

TEST(Bvh, Hair)
{
    expectSoundAllWays(tests::hairMesh(1500, 2));
}

TEST(Bvh, Soup)
{
    expectSoundAllWays(tests::soupMesh(20000, 0.2f, 3));
}

TEST(Bvh, FarFromTheOrigin)
{
    expectSoundAllWays(tests::sphereMesh(40, 2, 0.1f, {148376, 1234, -223423}));
}

TEST(Bvh, FlatMesh)
{
    Mesh mesh = tests::soupMesh(5000, 0.1f, 4);
    for (glm::vec3& p : mesh.positions) p.y = 0.125f;
    expectSoundAllWays(mesh);
    for (glm::vec3& p : mesh.positions) p.z = -3;  // and a line, of no area at all
    expectSoundAllWays(mesh);
    for (glm::vec3& p : mesh.positions) p.x = 1;  // and a point
    expectSoundAllWays(mesh);
}

TEST(Bvh, IdenticalTriangles)
{
    const Mesh mesh = tests::identicalMesh(100000);
    const Bvh bvh = bvhOf(mesh);
    expectSound(mesh, bvh, {});
    EXPECT_LE(bvh.depth, 20u) << "nothing but halving is of use here";
}

TEST(Bvh, NestedTriangles)
{
    expectSound(tests::nestedMesh(50000), bvhOf(tests::nestedMesh(50000)), {});
}

TEST(Bvh, GeometricLine)
{
    // By the SAH every split but the unbalanced one is bad: the depth bound has to take over.
    for (const float ratio : {1.0f, 1.01f, 1.5f, 3.0f}) {
        const Mesh mesh = tests::lineMesh(50000, ratio);
        SCOPED_TRACE(ratio);
        expectSound(mesh, bvhOf(mesh), {});
    }
}

TEST(SlowBvh, MillionIdenticalNestedAndInALine)
{
    for (const Mesh& mesh : {tests::identicalMesh(1000000), tests::nestedMesh(1000000),
                             tests::lineMesh(1000000, 1.0f), tests::lineMesh(1000000, 1.5f)}) {
        expectSound(mesh, bvhOf(mesh), {});
    }
}

TEST(Bvh, SameBytesOnAnyNumberOfThreads)
{
    for (const Mesh& mesh :
         {tests::soupMesh(60000, 0.3f, 5), tests::hairMesh(5000, 6), tests::roomMesh(7)}) {
        std::vector<Bvh> built;
        for (const int threads : {1, 2, 5}) {
            const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 5);
            tbb::task_arena arena(threads);
            arena.execute([&] { built.push_back(bvhOf(mesh)); });
        }
        EXPECT_TRUE(sameBytes(built[0], built[1]));
        EXPECT_TRUE(sameBytes(built[0], built[2]));
    }
}

TEST(Bvh, SpatialSplitsLowerTheCost)
{
    // Walls of two triangles next to fine geometry are what spatial splits are for.
    const Mesh mesh = tests::roomMesh(8);
    const Bvh without = bvhOf(mesh, {.duplicateBudget = 0});
    const Bvh with = bvhOf(mesh, {.duplicateBudget = 0.3f});
    EXPECT_EQ(without.slotCount(), mesh.triangles.size());
    EXPECT_GT(with.slotCount(), mesh.triangles.size());
    EXPECT_LT(with.cost, without.cost);
}

TEST(Bvh, ReportsProgressAndStops)
{
    const Mesh mesh = tests::soupMesh(100000, 0.05f, 9);
    double last = 0;
    int calls = 0;
    core::buildBvh(mesh.positions, mesh.triangles, {}, [&](double fraction) {
        EXPECT_GE(fraction, last);
        EXPECT_LE(fraction, 1.0);
        last = fraction;
        ++calls;
    });
    EXPECT_EQ(last, 1.0);
    EXPECT_GT(calls, 5);

    std::stop_source source;
    const Bvh stopped = core::buildBvh(
        mesh.positions, mesh.triangles, {}, [&](double) { source.request_stop(); },
        source.get_token());
    EXPECT_TRUE(stopped.nodeCount() == 0);
}

}  // namespace
