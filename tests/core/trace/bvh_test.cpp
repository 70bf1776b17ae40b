// The BVH as a data structure: every triangle reachable through boxes that contain it, bounded
// depth on the shapes that break builders (N24), the same bytes on any number of threads,
// cancellation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "core/trace/bvh.h"
#include "tests/support/meshes.h"

namespace {

using core::Bvh;
using core::BvhOptions;
using shared::uvec4;
using tests::Mesh;

/// A box in cells, as a child record holds it.
struct Cells {
    glm::dvec3 low{0}, high{65535};

    /// With the slack that makeGridRay adds on its side.
    bool contains(glm::dvec3 p) const
    {
        constexpr double slack = 0.02;
        return glm::all(glm::greaterThanEqual(p, low - slack)) &&
               glm::all(glm::lessThanEqual(p, high + slack));
    }
};

/// One leaf's occurrence of a triangle, with the intersection of all boxes on the way down.
struct Occurrence {
    uint32_t triangle;
    Cells cells;
};

struct Walk {
    std::vector<Occurrence> occurrences;
    std::vector<uint32_t> slotUse;  // how many leaves hold each slot
    std::vector<uint32_t> nodeUse;
    uint32_t depth = 0;
    uint32_t largestLeaf = 0;
};

void walk(const Bvh& bvh, uint32_t reference, const Cells& cells, uint32_t depth, Walk& out)
{
    if (reference == shared::kBvhDone) return;
    if ((reference & shared::kBvhLeaf) != 0) {
        const uint32_t count = (reference >> shared::kBvhCountShift) & shared::kBvhCountMask;
        const uint32_t first = reference & shared::kBvhIndexMask;
        EXPECT_GT(count, 0u);
        out.largestLeaf = std::max(out.largestLeaf, count);
        for (uint32_t i = first; i < first + count; ++i) {
            ASSERT_LT(i, bvh.slots.size());
            ++out.slotUse[i];
            out.occurrences.push_back({bvh.slots[i], cells});
        }
        return;
    }
    ASSERT_LT(reference, bvh.nodes.size() / 2);
    ++out.nodeUse[reference];
    out.depth = std::max(out.depth, depth + 1);
    for (uint32_t k = 0; k < 2; ++k) {
        const uvec4 child = bvh.nodes[2 * reference + k];
        Cells inside = cells;
        for (int a = 0; a < 3; ++a) {
            inside.low[a] = std::max(inside.low[a], static_cast<double>(child[a] & 0xffffu));
            inside.high[a] = std::min(inside.high[a], static_cast<double>(child[a] >> 16));
        }
        walk(bvh, child.w, inside, depth + 1, out);
    }
}

/// Everything that must hold of any BVH over a mesh.
void expectSound(const Mesh& mesh, const Bvh& bvh, const BvhOptions& options)
{
    ASSERT_GE(bvh.nodes.size(), 2u);
    Walk w;
    w.slotUse.resize(bvh.slots.size());
    w.nodeUse.resize(bvh.nodes.size() / 2);
    walk(bvh, 0, {}, 0, w);
    EXPECT_EQ(w.depth, bvh.depth);
    EXPECT_LE(bvh.depth, shared::kBvhMaxDepth);
    EXPECT_LE(w.largestLeaf, options.leafSize);
    const bool oneLeaf = bvh.nodes.size() == 2 && bvh.nodes[0].w == bvh.nodes[1].w;
    for (const uint32_t n : w.slotUse) {
        ASSERT_EQ(n, oneLeaf ? 2u : 1u) << "every slot lies in exactly one leaf";
    }
    for (const uint32_t n : w.nodeUse) ASSERT_EQ(n, 1u) << "every node has exactly one parent";
    const double budget =
        static_cast<double>(options.duplicateBudget) * static_cast<double>(mesh.triangles.size());
    EXPECT_LE(static_cast<double>(bvh.slots.size()),
              static_cast<double>(mesh.triangles.size()) + budget);

    std::ranges::sort(w.occurrences, {}, &Occurrence::triangle);
    std::mt19937 engine(7);
    std::uniform_real_distribution<double> uniform(0, 1);
    size_t i = 0;
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const size_t begin = i;
        while (i < w.occurrences.size() && w.occurrences[i].triangle == t) ++i;
        ASSERT_GT(i, begin) << "triangle " << t << " is in no leaf";
        const core::WorldTriangle& tri = mesh.triangles[t];
        const glm::dvec3 a = mesh.positions[tri.v0], b = mesh.positions[tri.v1],
                         c = mesh.positions[tri.v2];
        for (int k = 0; k < 8; ++k) {
            // Corners first, then points inside: each lies in the boxes of at least one of its
            // leaves.
            const double s = std::sqrt(uniform(engine)), u = uniform(engine);
            const glm::dvec3 p =
                k == 0 ? a
                       : (k == 1 ? b : (k == 2 ? c : (1 - s) * a + s * (1 - u) * b + s * u * c));
            const glm::dvec3 cell = (p - glm::dvec3(bvh.gridLow)) * glm::dvec3(bvh.gridScale);
            const bool covered =
                std::any_of(w.occurrences.begin() + static_cast<std::ptrdiff_t>(begin),
                            w.occurrences.begin() + static_cast<std::ptrdiff_t>(i),
                            [&](const Occurrence& o) { return o.cells.contains(cell); });
            ASSERT_TRUE(covered) << "triangle " << t << ", point " << k;
        }
    }
}

Bvh build(const Mesh& mesh, const BvhOptions& options = {})
{
    return core::buildBvh(mesh.positions, mesh.triangles, options);
}

void expectSoundAllWays(const Mesh& mesh)
{
    for (const float budget : {0.0f, 0.3f, 2.0f}) {
        for (const uint32_t leafSize : {1u, 4u, 8u, 14u}) {
            const BvhOptions options{.leafSize = leafSize, .duplicateBudget = budget};
            SCOPED_TRACE(testing::Message() << "budget " << budget << ", leaf size " << leafSize);
            expectSound(mesh, build(mesh, options), options);
        }
    }
}

bool sameBytes(const Bvh& a, const Bvh& b)
{
    return a.nodes.size() == b.nodes.size() && a.slots == b.slots && a.gridLow == b.gridLow &&
           a.gridScale == b.gridScale && a.depth == b.depth &&
           std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.size() * sizeof(uvec4)) == 0;
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
    const Bvh bvh = build(mesh);
    expectSound(mesh, bvh, {});
    EXPECT_LE(bvh.depth, 20u) << "nothing but halving is of use here";
}

TEST(Bvh, NestedTriangles)
{
    expectSound(tests::nestedMesh(50000), build(tests::nestedMesh(50000)), {});
}

TEST(Bvh, GeometricLine)
{
    // By the SAH every split but the unbalanced one is bad: the depth bound has to take over.
    for (const float ratio : {1.0f, 1.01f, 1.5f, 3.0f}) {
        const Mesh mesh = tests::lineMesh(50000, ratio);
        SCOPED_TRACE(ratio);
        expectSound(mesh, build(mesh), {});
    }
}

TEST(SlowBvh, MillionIdenticalNestedAndInALine)
{
    for (const Mesh& mesh : {tests::identicalMesh(1000000), tests::nestedMesh(1000000),
                             tests::lineMesh(1000000, 1.0f), tests::lineMesh(1000000, 1.5f)}) {
        expectSound(mesh, build(mesh), {});
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
            arena.execute([&] { built.push_back(build(mesh)); });
        }
        EXPECT_TRUE(sameBytes(built[0], built[1]));
        EXPECT_TRUE(sameBytes(built[0], built[2]));
    }
}

TEST(Bvh, SpatialSplitsLowerTheCost)
{
    // Walls of two triangles next to fine geometry are what spatial splits are for.
    const Mesh mesh = tests::roomMesh(8);
    const Bvh without = build(mesh, {.duplicateBudget = 0});
    const Bvh with = build(mesh, {.duplicateBudget = 0.3f});
    EXPECT_EQ(without.slots.size(), mesh.triangles.size());
    EXPECT_GT(with.slots.size(), mesh.triangles.size());
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
    EXPECT_TRUE(stopped.nodes.empty());
}

}  // namespace
