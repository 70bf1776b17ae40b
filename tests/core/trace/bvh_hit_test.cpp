// Rays against the BVH on the CPU: equal to testing every triangle, equal to Embree (T17),
// watertight (T15), without hits for rays that are not finite. The GPU runs the same text, see
// gpu_traverse_test.cpp.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/trace/bvh.h"
#include "core/trace/embree.h"
#include "tests/support/scenes/meshes.h"
#include "tests/support/statistics/random_values.h"

namespace {

using core::Bvh;
using core::BvhHit;
using glm::vec3;
using tests::Mesh;
using tests::Random;

struct TestRay {
    vec3 origin, direction;
};

struct Bounds {
    vec3 low, high;

    explicit Bounds(const Mesh& mesh) : low(3e38f), high(-3e38f)
    {
        for (const vec3& p : mesh.positions) {
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
    }
};

/// Rays from in and around the mesh; every fourth parallel to an axis, some starting far away.
TestRay randomRay(const Bounds& bounds, Random& random)
{
    const vec3 size = bounds.high - bounds.low;
    const vec3 target = bounds.low + size * random.cube();
    const float reach = random() < 0.2f ? 100.0f : 1.5f;
    vec3 origin = bounds.low + size * (0.5f + reach * (random.cube() - 0.5f));
    vec3 direction = random() < 0.5f ? random.direction() : target - origin;
    if (random() < 0.25f) {
        const int axis = static_cast<int>(random.below(3));
        direction = vec3(0);
        direction[axis] = random() < 0.5f ? 1.0f : -1.0f;
        const vec3 across = target;
        for (int a = 0; a < 3; ++a) {
            if (a != axis) origin[a] = across[a];
        }
    }
    return {origin, direction};
}

/// The nearest of all triangles, each tested alone.
BvhHit bruteForce(const Mesh& mesh, const TestRay& ray, float tMin, float tMax)
{
    BvhHit best;
    const shared::ShearRay shear = shared::makeShearRay(ray.origin, ray.direction);
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        const core::WorldTriangle& t = mesh.triangles[i];
        BvhHit h;
        if (shared::intersectTriangle(shear, mesh.positions[t.v0], mesh.positions[t.v1],
                                      mesh.positions[t.v2], tMin, tMax, h.t, h.barycentrics)) {
            h.slot = i;
            best = h;
            tMax = h.t;
        }
    }
    return best;
}

/// The tree may lose nothing that a test of every triangle finds: not one ray.
void expectEqualToBruteForce(const Mesh& mesh, int rays, uint32_t seed)
{
    const Bounds bounds(mesh);
    for (const float budget : {0.0f, 1.0f}) {
        const Bvh bvh = core::buildBvh(mesh.positions, mesh.triangles, {.duplicateBudget = budget});
        Random random(seed);
        int hits = 0;
        for (int i = 0; i < rays; ++i) {
            const TestRay ray = randomRay(bounds, random);
            const float tMin = random() < 0.3f ? 0.2f * random() : 0.0f;
            const float tMax = random() < 0.3f ? random() : shared::kInfinity;
            const BvhHit expected = bruteForce(mesh, ray, tMin, tMax);
            BvhHit hit;
            const bool found = core::traceClosest(bvh, mesh.positions, mesh.triangles, ray.origin,
                                                  ray.direction, tMin, tMax, hit);
            const bool blocked = core::traceAny(bvh, mesh.positions, mesh.triangles, ray.origin,
                                                ray.direction, tMin, tMax);
            ASSERT_EQ(found, expected.slot != shared::kNone) << "ray " << i;
            ASSERT_EQ(blocked, found) << "ray " << i;
            if (!found) continue;
            ++hits;
            ASSERT_EQ(hit.t, expected.t)
                << "ray " << i;  // of several at the same t, any may be reported
        }
        EXPECT_GT(hits, rays / 200) << "the rays miss too often to prove anything";
    }
}

TEST(BvhHit, EqualsBruteForce)
{
    expectEqualToBruteForce(tests::soupMesh(300, 0.4f, 21), 20000, 31);
    expectEqualToBruteForce(tests::soupMesh(2, 1.0f, 22), 20000, 32);
    expectEqualToBruteForce(tests::hairMesh(30, 23), 20000, 33);
    expectEqualToBruteForce(tests::nestedMesh(200), 10000, 34);
    expectEqualToBruteForce(tests::identicalMesh(100), 10000, 35);
    expectEqualToBruteForce(tests::sphereMesh(8, 2, 0.1f, {0, 0, 0}), 20000, 36);
    expectEqualToBruteForce(tests::sphereMesh(8, 1e-4f, 0.1f, {0, 0, 0}), 10000, 37);
    expectEqualToBruteForce(tests::sphereMesh(8, 1e6f, 0.1f, {0, 0, 0}), 10000, 38);
    expectEqualToBruteForce(tests::sphereMesh(8, 2, 0.1f, {148376, 1234, -223423}), 10000, 39);
    Mesh flat = tests::soupMesh(300, 0.4f, 24);
    for (vec3& p : flat.positions) p.y = 0;
    expectEqualToBruteForce(flat, 10000, 40);
}

/// Embree over the same arrays, robust and with its best build.
class Reference {
public:
    explicit Reference(const Mesh& mesh)
        : device_(rtcNewDevice("threads=2")), scene_(rtcNewScene(device_))
    {
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        // Embree reads 16 bytes per vertex: its own copy, since the mesh has no spare one at its
        // end.
        auto* positions = static_cast<vec3*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                    sizeof(vec3), mesh.positions.size()));
        std::copy(mesh.positions.begin(), mesh.positions.end(), positions);
        auto* indices = static_cast<core::WorldTriangle*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    sizeof(core::WorldTriangle), mesh.triangles.size()));
        std::copy(mesh.triangles.begin(), mesh.triangles.end(), indices);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
    }
    ~Reference()
    {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    Reference(const Reference&) = delete;
    Reference& operator=(const Reference&) = delete;

    RTCRayHit trace(const TestRay& ray) const
    {
        RTCRayHit h{};
        h.ray = {ray.origin.x,
                 ray.origin.y,
                 ray.origin.z,
                 0,
                 ray.direction.x,
                 ray.direction.y,
                 ray.direction.z,
                 0,
                 shared::kInfinity,
                 ~0u,
                 0,
                 0};
        h.hit.geomID = h.hit.primID = h.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        core::EmbreeQuery().closest(scene_, h);
        return h;
    }

private:
    RTCDevice device_;
    RTCScene scene_;
};

/// How far a hit lies inside its triangle: the distance to the nearest edge.
float edgeDistance(const Mesh& mesh, uint32_t triangle, glm::vec2 barycentrics)
{
    const core::WorldTriangle& t = mesh.triangles[triangle];
    const vec3 v[3] = {mesh.positions[t.v0], mesh.positions[t.v1], mesh.positions[t.v2]};
    const float weight[3] = {1 - barycentrics.x - barycentrics.y, barycentrics.x, barycentrics.y};
    const float area = glm::length(glm::cross(v[1] - v[0], v[2] - v[0]));
    float nearest = shared::kInfinity;
    for (int i = 0; i < 3; ++i) {
        const float edge = glm::length(v[(i + 2) % 3] - v[(i + 1) % 3]);
        nearest = std::min(nearest, weight[i] * area / edge);
    }
    return nearest;
}

/// T17: where both do not name the same triangle, either the distances tie, or what one of them
/// found and the other did not is hit within rounding of its edge (a silhouette); anything else in
/// at most 1e-5 of the rays.
void expectEqualToEmbree(const Mesh& mesh, int rays, uint32_t seed)
{
    const Bvh bvh = core::buildBvh(mesh.positions, mesh.triangles);
    const Reference reference(mesh);
    const Bounds bounds(mesh);
    const vec3 size = bounds.high - bounds.low;
    Random random(seed);
    int mismatches = 0, silhouettes = 0, hits = 0, farOff = 0;
    for (int i = 0; i < rays; ++i) {
        TestRay ray = randomRay(bounds, random);
        // Embree's rounding grows with the distance: far origins are compared with brute force
        // only.
        ray.origin = glm::clamp(ray.origin, bounds.low - size, bounds.high + size);
        ray.direction = glm::normalize(ray.direction);
        BvhHit hit;
        const bool found = core::traceClosest(bvh, mesh.positions, mesh.triangles, ray.origin,
                                              ray.direction, 0, shared::kInfinity, hit);
        const RTCRayHit other = reference.trace(ray);
        const bool otherFound = other.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        if (!found && !otherFound) continue;
        ++hits;
        const bool same = found && otherFound && bvh.triangle(hit.slot) == other.hit.primID;
        const bool near =
            found && otherFound &&
            std::abs(hit.t - other.ray.tfar) <= 1e-5f * std::max(other.ray.tfar, glm::length(size));
        farOff += same && !near;
        if (same || near) continue;
        const bool oursIsNearer = found && (!otherFound || hit.t < other.ray.tfar);
        const float margin = oursIsNearer
                                 ? edgeDistance(mesh, bvh.triangle(hit.slot), hit.barycentrics)
                                 : edgeDistance(mesh, other.hit.primID, {other.hit.u, other.hit.v});
        const bool silhouette = margin <= 1e-6f * glm::length(size);
        silhouettes += silhouette;
        mismatches += !silhouette;
    }
    EXPECT_GT(hits, rays / 20);
    EXPECT_LE(mismatches, static_cast<int>(1e-5 * rays)) << "of " << rays;
    EXPECT_LE(silhouettes, 2 + static_cast<int>(1e-4 * rays)) << "of " << rays;
    EXPECT_EQ(farOff, 0) << "same triangle, another distance";
}

void compareAllWithEmbree(int rays)
{
    expectEqualToEmbree(tests::roomMesh(41), rays, 51);
    expectEqualToEmbree(tests::soupMesh(50000, 0.1f, 42), rays, 52);
    expectEqualToEmbree(tests::hairMesh(5000, 43), rays, 53);
    expectEqualToEmbree(tests::sphereMesh(100, 2, 0.1f, {0, 0, 0}), rays, 54);
}

TEST(BvhHit, EqualsEmbree)
{
    compareAllWithEmbree(100000);
}

TEST(SlowBvhHit, EqualsEmbree)
{
    compareAllWithEmbree(1000000);
}

enum class Aim { vertices, edges };

/// T15: rays from inside a closed mesh at points of its edges; counts those that escape.
int escapes(const Mesh& mesh, vec3 centre, Aim aim, int rays, uint32_t seed)
{
    const Bvh bvh = core::buildBvh(mesh.positions, mesh.triangles);
    Random random(seed);
    int missed = 0;
    for (int i = 0; i < rays; ++i) {
        const core::WorldTriangle& t = mesh.triangles[random.below(mesh.triangles.size())];
        const uint32_t index[3] = {t.v0, t.v1, t.v2};
        const uint32_t k = random.below(3);
        const vec3 a = mesh.positions[index[k]], b = mesh.positions[index[(k + 1) % 3]];
        const vec3 target = aim == Aim::vertices ? a : glm::mix(a, b, random());
        const vec3 origin = centre + 0.5f * (random.cube() - 0.5f);
        BvhHit hit;
        missed += !core::traceClosest(bvh, mesh.positions, mesh.triangles, origin, target - origin,
                                      0, shared::kInfinity, hit);
    }
    return missed;
}

void expectWatertight(int rays)
{
    for (const float bump : {0.0f, 0.05f}) {
        const Mesh mesh = tests::sphereMesh(100, 2, bump, vec3(0));
        EXPECT_EQ(escapes(mesh, vec3(0), Aim::vertices, rays, 61), 0);
        EXPECT_EQ(escapes(mesh, vec3(0), Aim::edges, rays, 62), 0);
        const vec3 far(148376, 1234, -223423);
        const Mesh moved = tests::sphereMesh(100, 2, bump, far);
        const int allowed = static_cast<int>(2e-5 * rays);
        EXPECT_LE(escapes(moved, far, Aim::vertices, rays, 63), allowed);
        EXPECT_LE(escapes(moved, far, Aim::edges, rays, 64), allowed);
    }
}

TEST(BvhHit, Watertight)
{
    expectWatertight(200000);
}

TEST(SlowBvhHit, Watertight)
{
    expectWatertight(10000000);
}

TEST(BvhHit, WatertightSlivers)
{
    // N6: a closed needle, 1 : 1e6.
    Mesh mesh = tests::sphereMesh(50, 1, 0, vec3(0));
    for (vec3& p : mesh.positions) p = {p.x * 1e-3f, p.y * 1e3f, p.z * 1e-3f};
    const Bvh bvh = core::buildBvh(mesh.positions, mesh.triangles);
    Random random(71);
    int missed = 0;
    const int rays = 200000;
    for (int i = 0; i < rays; ++i) {
        const vec3 origin(0, 500 * (random() - 0.5f), 0);
        const core::WorldTriangle& t = mesh.triangles[random.below(mesh.triangles.size())];
        const vec3 target = i % 2 == 0
                                ? mesh.positions[t.v0]
                                : glm::mix(mesh.positions[t.v0], mesh.positions[t.v1], random());
        BvhHit hit;
        missed += !core::traceClosest(bvh, mesh.positions, mesh.triangles, origin, target - origin,
                                      0, shared::kInfinity, hit);
    }
    EXPECT_LE(missed, static_cast<int>(2e-5 * rays));
}

TEST(BvhHit, DegenerateTrianglesChangeNothing)
{
    // N5: points, lines and needles of zero area among a sound mesh are never hit and hide nothing.
    const Mesh sound = tests::roomMesh(81);
    Mesh broken = sound;
    Random random(82);
    for (int i = 0; i < 500; ++i) {
        const vec3 a = vec3(-4, 0, -3) + vec3(8, 3, 6) * random.cube();
        const vec3 b = vec3(-4, 0, -3) + vec3(8, 3, 6) * random.cube();
        if (i % 3 == 0) broken.add(a, a, a);
        if (i % 3 == 1) broken.add(a, a, b);
        if (i % 3 == 2) broken.add({a.x, 1, 1}, {b.x, 1, 1}, {0.5f * (a.x + b.x), 1, 1});
    }
    const Bvh a = core::buildBvh(sound.positions, sound.triangles);
    const Bvh b = core::buildBvh(broken.positions, broken.triangles);
    const Bounds bounds(sound);
    for (int i = 0; i < 50000; ++i) {
        const TestRay ray = randomRay(bounds, random);
        BvhHit x, y;
        const bool foundX = core::traceClosest(a, sound.positions, sound.triangles, ray.origin,
                                               ray.direction, 0, shared::kInfinity, x);
        const bool foundY = core::traceClosest(b, broken.positions, broken.triangles, ray.origin,
                                               ray.direction, 0, shared::kInfinity, y);
        ASSERT_EQ(foundX, foundY);
        if (foundX) {
            ASSERT_EQ(x.t, y.t);
            ASSERT_LT(b.triangle(y.slot), sound.triangles.size());
        }
    }
}

TEST(BvhHit, RaysThatAreNotFiniteHitNothing)
{
    const Mesh mesh = tests::sphereMesh(10, 2, 0, vec3(0));
    const Bvh bvh = core::buildBvh(mesh.positions, mesh.triangles);
    const float nan = std::numeric_limits<float>::quiet_NaN(),
                inf = std::numeric_limits<float>::infinity();
    BvhHit hit;
    const auto both = [&](vec3 origin, vec3 direction, float tMin, float tMax) {
        return core::traceClosest(bvh, mesh.positions, mesh.triangles, origin, direction, tMin,
                                  tMax, hit) ||
               core::traceAny(bvh, mesh.positions, mesh.triangles, origin, direction, tMin, tMax);
    };
    EXPECT_TRUE(both(vec3(0), {0, 0, 1}, 0, shared::kInfinity));
    EXPECT_FALSE(both(vec3(0), vec3(0), 0, shared::kInfinity));
    for (const float bad : {nan, inf, -inf}) {
        for (int a = 0; a < 3; ++a) {
            vec3 v(0.1f, 0.2f, 0.3f);
            v[a] = bad;
            EXPECT_FALSE(both(vec3(0), v, 0, shared::kInfinity));
            EXPECT_FALSE(both(v, {0, 0, 1}, 0, shared::kInfinity));
        }
    }
    EXPECT_FALSE(both(vec3(0), {0, 0, 1}, 3, shared::kInfinity)) << "behind tMin only";
    EXPECT_FALSE(both(vec3(0), {0, 0, 1}, 0, 1)) << "beyond tMax only";
    EXPECT_FALSE(both(vec3(0), {0, 0, 1}, 3, 1)) << "an empty interval";
}

}  // namespace
