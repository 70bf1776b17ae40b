// Scenes far larger than what is looked at in them (T34): the hierarchy with finer grids is sound,
// loses no hit, finds what Embree finds or what double precision says is right, and takes hardly
// more tests than without what is far away; refits move finer grids along; no grids in scenes of
// one scale.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/trace/bvh.h"
#include "core/trace/bvh_traverse.h"
#include "core/trace/embree_rays.h"
#include "tests/support/scenes/bvh_walk.h"
#include "tests/support/scenes/meshes.h"
#include "tests/support/statistics/random_values.h"

namespace {

using core::Bvh;
using core::BvhHit;
using core::RaySegment;
using glm::vec3;
using tests::bvhOf;
using tests::FarScene;
using tests::Mesh;
using tests::Random;

/// From and to places of both scales; some parallel to an axis, some from far outside.
std::vector<RaySegment> segmentsAmong(const FarScene& scene, int count, uint32_t seed)
{
    Random random(seed);
    std::vector<RaySegment> rays(static_cast<size_t>(count));
    for (RaySegment& ray : rays) {
        const auto place = [&] {
            return random.around(random() < 0.7f ? scene.nearRadius : scene.farRadius);
        };
        ray.origin = random() < 0.05f ? random.around(30 * scene.farRadius) : place();
        ray.direction = glm::normalize(place() - ray.origin);
        if (random() < 0.2f) {
            const float kind = random();
            ray.direction = vec3(0);
            ray.direction[static_cast<int>(3 * random())] = kind < 0.5f ? 1.0f : -1.0f;
        }
    }
    return rays;
}

bool trace(const Bvh& bvh, const Mesh& mesh, const RaySegment& ray, BvhHit& hit)
{
    return core::traceClosest(bvh, mesh.positions, mesh.triangles, ray.origin, ray.direction,
                              ray.tMin, ray.tMax, hit);
}

TEST(BvhFar, IsSoundOnSeveralGrids)
{
    for (const FarScene& scene : tests::farScenes()) {
        SCOPED_TRACE(scene.name);
        const Bvh bvh = bvhOf(scene.mesh);
        EXPECT_GE(bvh.gridChanges(), scene.nearRadius < 1 ? 2u : 1u);
        tests::expectSound(scene.mesh, bvh, {});
    }
}

/// Scales a thousand times apart, one in the other, down to what single precision knows.
TEST(BvhFar, ScalesWithinScales)
{
    Mesh mesh = tests::sphereMesh(12, 1e-6f, 0.1f, vec3(0));
    for (const float radius : {1e-3f, 1.0f, 1e3f, 1e6f})
        mesh = tests::underDome(std::move(mesh), radius, 12);
    const Bvh bvh = bvhOf(mesh);
    EXPECT_GE(bvh.gridChanges(), 2u);
    tests::expectSound(mesh, bvh, {});
    int escaped = 0;
    Random random(5);
    for (int i = 0; i < 20000; ++i) {
        // The innermost ball is closed: seen from inside, nothing further away is.
        BvhHit hit;
        trace(bvh, mesh, {random.around(2e-7f), 0, glm::normalize(random.around(1))}, hit);
        escaped += !(hit.t < 2e-6f);
    }
    EXPECT_EQ(escaped, 0);
}

struct Nearest {
    double t = static_cast<double>(shared::kInfinity);
    uint32_t triangle = shared::kNone;
};

/// The nearest hit in double precision: the truth but for rays at an edge.
Nearest nearestInDouble(const Mesh& mesh, const RaySegment& ray)
{
    const glm::dvec3 o = ray.origin, d = ray.direction;
    Nearest nearest;
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        const core::WorldTriangle& t = mesh.triangles[i];
        const glm::dvec3 a = glm::dvec3(mesh.positions[t.v0]) - o,
                         b = glm::dvec3(mesh.positions[t.v1]) - o,
                         c = glm::dvec3(mesh.positions[t.v2]) - o;
        const double u = glm::dot(d, glm::cross(c, b)), v = glm::dot(d, glm::cross(a, c)),
                     w = glm::dot(d, glm::cross(b, a)), sum = u + v + w;
        const bool inside = (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
        const double distance = glm::dot(d, u * a + v * b + w * c) / (sum * glm::dot(d, d));
        if (inside && sum != 0 && distance > 0 && distance < nearest.t) nearest = {distance, i};
    }
    return nearest;
}

/// The nearest hit by the test of every triangle; `t` is the ray's end where there is none.
struct Tested {
    float t;
    uint32_t triangle = shared::kNone;
};

Tested nearestOfAll(const Mesh& mesh, const RaySegment& ray)
{
    const shared::ShearRay shear = shared::makeShearRay(ray.origin, ray.direction);
    Tested nearest{ray.tMax};
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        const core::WorldTriangle& t = mesh.triangles[i];
        float distance;
        glm::vec2 barycentrics;
        if (shared::intersectTriangle(shear, mesh.positions[t.v0], mesh.positions[t.v1],
                                      mesh.positions[t.v2], ray.tMin, nearest.t, distance,
                                      barycentrics))
            nearest = {distance, i};
    }
    return nearest;
}

/// Where the test of every triangle is right, the hierarchy finds the very same, to the bit. It is
/// not always: to a ray that passes kilometres from a triangle of millimetres the three vertices
/// are one place, and rounding alone decides on which side of an edge that is. Boxes know better.
TEST(BvhFar, LosesNoHit)
{
    for (const FarScene& scene : tests::farScenes()) {
        SCOPED_TRACE(scene.name);
        const Mesh& mesh = scene.mesh;
        const Bvh bvh = bvhOf(mesh);
        int wrong = 0, hits = 0;
        const int count = 1000;
        for (const RaySegment& ray : segmentsAmong(scene, count, 21)) {
            const auto [nearest, triangle] = nearestOfAll(mesh, ray);
            if (nearestInDouble(mesh, ray).triangle != triangle) {
                ++wrong;
                continue;
            }
            BvhHit hit;
            const bool found = trace(bvh, mesh, ray, hit);
            ASSERT_EQ(hit.t, nearest);
            ASSERT_EQ(found, core::traceAny(bvh, mesh.positions, mesh.triangles, ray.origin,
                                            ray.direction, 0, shared::kInfinity));
            hits += found;
        }
        EXPECT_LE(wrong, count / 50);  // 4 to 18, by scene
        EXPECT_GT(hits, count / 4);
    }
}

/// What Embree and the hierarchy find differs by the rounding of the triangle test alone; where it
/// is more, double precision judges, and the hierarchy must be right at least as often.
TEST(BvhFar, EqualsEmbree)
{
    const int count = 50000;
    for (const FarScene& scene : tests::farScenes()) {
        SCOPED_TRACE(scene.name);
        const Bvh bvh = bvhOf(scene.mesh);
        const core::EmbreeRays embree(tests::worldOf(scene.mesh));
        std::vector<RaySegment> rays = segmentsAmong(scene, count, 31);
        std::vector<core::SegmentHit> others(rays.size());
        embree.closest1(rays, others);
        int differ = 0, oursWrong = 0, theirsWrong = 0, hits = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
            BvhHit hit;
            const bool found = trace(bvh, scene.mesh, rays[i], hit);
            const bool other = others[i].triangle != shared::kNone;
            if (!found && !other) continue;
            ++hits;
            const uint32_t triangle = found ? bvh.triangle(hit.slot) : others[i].triangle;
            const float error =
                tests::distanceError(scene.mesh, triangle, rays[i].origin, rays[i].direction);
            if (found && other && std::abs(hit.t - others[i].t) <= error) continue;
            ++differ;
            const double truth = nearestInDouble(scene.mesh, rays[i]).t;
            const auto wrong = [&](bool any, float t) {
                const double x = static_cast<double>(any ? t : shared::kInfinity);
                return std::abs(x - truth) > static_cast<double>(error);
            };
            oursWrong += wrong(found, hit.t);
            theirsWrong += wrong(other, others[i].t);
        }
        EXPECT_GT(hits, count / 4);
        EXPECT_LE(differ, count / 2000);
        EXPECT_LE(oursWrong, theirsWrong + 2) << "of " << differ << " that differ";
        RecordProperty(scene.name, differ);
    }
}

/// Box pairs and triangles that nearest hits test.
double testsOf(const Bvh& bvh, const Mesh& mesh, const std::vector<RaySegment>& rays)
{
    core::TraversalCounts counts;
    for (const RaySegment& ray : rays) {
        float tMax = ray.tMax;
        const auto leaf = [&](uint32_t slot, const core::LocalRay& local) {
            const core::WorldTriangle& t = mesh.triangles[bvh.triangle(slot)];
            float distance;
            glm::vec2 barycentrics;
            if (shared::intersectTriangle(local.shear, mesh.positions[t.v0], mesh.positions[t.v1],
                                          mesh.positions[t.v2], ray.tMin, tMax, distance,
                                          barycentrics))
                tMax = distance;
            return false;
        };
        core::traverse(bvh, ray.origin, ray.direction, ray.tMin, tMax, leaf, &counts);
    }
    return static_cast<double>(counts.nodes + counts.triangles) / static_cast<double>(rays.size());
}

/// From anywhere in roomMesh, in all directions.
std::vector<RaySegment> raysInRoom(size_t count, uint32_t seed)
{
    Random random(seed);
    std::vector<RaySegment> rays(count);
    for (RaySegment& ray : rays) {
        ray.origin = vec3(0, 1.5f, 0) + random.around(1) * vec3(3.9f, 1.4f, 2.9f);
        ray.direction = glm::normalize(random.around(1));
    }
    return rays;
}

/// Among the things of a room, what surrounds it costs a few tests per ray: a ground of two
/// triangles these two and a node, one of many squares and a dome the nodes whose boxes contain the
/// room.
TEST(BvhFar, CostsAFewTests)
{
    const Mesh room = tests::roomMesh(94);
    const std::vector<RaySegment> rays = raysInRoom(20000, 41);
    const double alone = testsOf(bvhOf(room), room, rays);
    for (const float scale : {100.0f, 1000.0f, 5000.0f, 1e6f}) {
        SCOPED_TRACE(scale);
        const Mesh ground = tests::onGround(room, scale, 1);
        const Mesh squares = tests::onGround(room, scale, 40);
        const Mesh dome = tests::underDome(room, scale, 20);
        EXPECT_LE(testsOf(bvhOf(ground), ground, rays), alone + 4);
        EXPECT_LE(testsOf(bvhOf(squares), squares, rays), alone + 4);
        // At the largest scale a cell of the dome's grid is larger than the room: near the centre
        // all eight octants of the dome are met.
        EXPECT_LE(testsOf(bvhOf(dome), dome, rays), (scale < 1e5f ? 1.5 : 2.2) * alone);
    }
}

/// Rays begin in the room and end there, however it is surrounded: not one test more. The last dome
/// consists of triangles that are smaller than the walls.
TEST(BvhFar, RaysThatStayInsidePayNothing)
{
    const Mesh room = tests::roomMesh(98);
    const std::vector<RaySegment> rays = raysInRoom(20000, 42);
    const double alone = testsOf(bvhOf(room), room, rays);
    std::vector<Mesh> surrounded{tests::underDome(room, 80, 60)};
    for (const float scale : {1000.0f, 5000.0f, 1e6f}) {
        surrounded.push_back(tests::onGround(room, scale, 1));
        surrounded.push_back(tests::onGround(room, scale, 40));
        surrounded.push_back(tests::underDome(room, scale, 20));
    }
    for (const Mesh& mesh : surrounded) {
        SCOPED_TRACE(mesh.triangles.size());
        const Bvh bvh = bvhOf(mesh);
        const shared::BvhEntry entry = core::entryOf(bvh);
        ASSERT_NE(entry.way, shared::kBvhDone);
        EXPECT_EQ(entry.apart, 1u);
        EXPECT_NEAR(testsOf(bvh, mesh, rays), alone, 0.01 * alone);
        tests::expectSound(mesh, bvh, {});
    }
}

/// Beside a ball, within its box: what misses the ball meets the dome, which is closed.
TEST(BvhFar, RaysLeaveWhereTheyBegin)
{
    const Mesh mesh = tests::underDome(tests::sphereMesh(40, 1, 0, vec3(0)), 1000, 12);
    const Bvh bvh = bvhOf(mesh);
    ASSERT_EQ(core::entryOf(bvh).apart, 1u);
    Random random(45);
    int missed = 0, far = 0;
    const int count = 5000;
    for (int i = 0; i < count; ++i) {
        BvhHit hit;
        missed += !trace(bvh, mesh, {vec3(0.8f, 0.8f, -0.8f), 0, random.around(1)}, hit);
        far += hit.t > 100;
    }
    EXPECT_EQ(missed, 0);
    EXPECT_GT(far, count / 2);
}

/// A ground that goes through the room is met in there, on any part of a ray.
TEST(BvhFar, SurroundingsMayReachIn)
{
    Mesh mesh = tests::roomMesh(99);
    const uint32_t inRoom = static_cast<uint32_t>(mesh.triangles.size());
    const float half = 5000, high = 1.5f;
    mesh.add({-half, high, -half}, {half, high, half}, {half, high, -half});
    mesh.add({-half, high, -half}, {-half, high, half}, {half, high, half});
    const Bvh bvh = bvhOf(mesh);
    ASSERT_NE(core::entryOf(bvh).way, shared::kBvhDone);
    EXPECT_EQ(core::entryOf(bvh).apart, 0u);
    Random random(43);
    int ground = 0, room = 0, none = 0;
    for (RaySegment ray : raysInRoom(3000, 44)) {
        ray.tMin = random() < 0.5f ? 0.0f : 6 * random();
        ray.tMax = random() < 0.5f ? ray.tMin + 6 * random() : shared::kInfinity;
        const auto [nearest, triangle] = nearestOfAll(mesh, ray);
        BvhHit hit;
        const bool found = trace(bvh, mesh, ray, hit);
        ASSERT_EQ(found, triangle != shared::kNone);
        ASSERT_EQ(found, core::traceAny(bvh, mesh.positions, mesh.triangles, ray.origin,
                                        ray.direction, ray.tMin, ray.tMax));
        if (found) {
            ASSERT_EQ(hit.t, nearest);
        }
        ++(!found ? none : triangle >= inRoom ? ground : room);
    }
    EXPECT_GT(ground, 300);
    EXPECT_GT(room, 300);
    EXPECT_GT(none, 300);
}

/// What moves has records that change from pose to pose: rays begin at the root.
TEST(BvhFar, RaysBeginAtTheRootOfWhatMoves)
{
    Mesh mesh = tests::sphereMesh(40, 0.1f, 0.1f, {0, 0.2f, 0});
    core::BvhOptions options;
    options.moving = {0, static_cast<uint32_t>(mesh.triangles.size())};
    mesh = tests::onGround(std::move(mesh), 5000, 1);
    const Bvh bvh = bvhOf(mesh, options);
    ASSERT_GT(bvh.moving.gridChanges, 0u);
    const shared::BvhEntry entry = core::entryOf(bvh);
    EXPECT_EQ(entry.way, shared::kBvhDone);
    EXPECT_EQ(entry.node, 0u);
    EXPECT_EQ(entry.gridScale, bvh.gridScale);
}

TEST(BvhFar, OneGridWhereThereIsOneScale)
{
    for (const Mesh& mesh :
         {tests::roomMesh(95), tests::soupMesh(20000, 0.2f, 96), tests::hairMesh(1500, 97),
          tests::sphereMesh(60, 2, 0.1f, vec3(0)), tests::identicalMesh(5000)})
        EXPECT_EQ(bvhOf(mesh).gridChanges(), 0u);
}

/// A ball of 20 cm on a ground of 10 km, with a mast: its finer grid is within the tree that moves.
TEST(BvhFar, RefitsMoveFinerGrids)
{
    Mesh mesh = tests::sphereMesh(40, 0.1f, 0.1f, {0, 0.2f, 0});
    const size_t ball = mesh.positions.size();
    core::BvhOptions options;
    options.moving = {0, static_cast<uint32_t>(mesh.triangles.size())};
    options.reachLow = vec3(-3000, -1, -3000);
    options.reachHigh = vec3(3000, 3000, 3000);
    mesh = tests::onGround(std::move(mesh), 5000, 1);
    mesh.add({4000, 0, 4000}, {4001, 0, 4000}, {4000, 3000, 4000});
    const Bvh first = bvhOf(mesh, options);
    ASSERT_GT(first.moving.gridChanges, 0u);
    tests::expectSound(mesh, first, options);
    const auto same = core::refitBvh(first, mesh.positions, mesh.triangles);
    ASSERT_TRUE(same.has_value());
    EXPECT_EQ(same->moving.nodes, first.moving.nodes) << "nothing has moved";
    EXPECT_NEAR(core::looseness(*same), 1, 1e-6);

    const auto expectRight = [&](const Bvh& bvh, vec3 centre, float radius) {
        tests::expectSound(mesh, bvh, options);
        const Bvh fresh = bvhOf(mesh);
        Random random(51);
        int found = 0;
        for (int i = 0; i < 5000; ++i) {
            const vec3 origin = centre + random.around(8 * radius);
            const vec3 target = centre + random.around(radius);
            BvhHit x, y;
            trace(bvh, mesh, {origin, 0, target - origin}, x);
            trace(fresh, mesh, {origin, 0, target - origin}, y);
            ASSERT_EQ(x.t, y.t);
            found += x.slot != shared::kNone && bvh.triangle(x.slot) < options.moving.end;
        }
        EXPECT_GT(found, 500);
    };
    for (const float size : {1.0f, 0.01f, 40.0f}) {
        const vec3 to(1000, 700, -2000);
        SCOPED_TRACE(size);
        Mesh posed = mesh;
        for (size_t v = 0; v < ball; ++v) posed.positions[v] = size * mesh.positions[v] + to;
        std::swap(posed, mesh);
        const auto refitted = core::refitBvh(first, mesh.positions, mesh.triangles);
        ASSERT_TRUE(refitted.has_value());
        EXPECT_TRUE(refitted->still.nodes.sharesWith(first.still.nodes));
        expectRight(*refitted, to, 0.1f * size);
        const auto rebuilt = core::rebuildMoving(first, mesh.positions, mesh.triangles, options);
        if (rebuilt) expectRight(*rebuilt, to, 0.1f * size);
        std::swap(posed, mesh);
    }
}

}  // namespace
