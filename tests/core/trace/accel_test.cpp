// Embree behind core::Accel: it sees the same triangles as a brute-force search, filters alpha, and
// is never hit again by a ray that leaves a surface (T16).
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "core/base/check.h"
#include "core/trace/accel.h"
#include "core/trace/scene_view.h"
#include "shared/intersect.h"
#include "shared/path.h"
#include "tests/support/scenes/instanced_scenes.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/random_values.h"

namespace {

using namespace tests;

glm::vec3 randomDirection(std::mt19937& random)
{
    return shared::sampleSphere({uniform(random), uniform(random)});
}

/// Distance to a triangle in double, or infinity (Moeller-Trumbore).
double distanceTo(const core::World& world, const core::WorldTriangle& t, const core::Ray& ray)
{
    const glm::dvec3 a(world.positions[t.v0]), ab = glm::dvec3(world.positions[t.v1]) - a,
                                               ac = glm::dvec3(world.positions[t.v2]) - a;
    const glm::dvec3 d(ray.direction), o = glm::dvec3(ray.origin) - a;
    const glm::dvec3 p = glm::cross(d, ac), q = glm::cross(o, ab);
    const double det = glm::dot(ab, p), u = glm::dot(o, p) / det, v = glm::dot(d, q) / det;
    const double distance = glm::dot(ac, q) / det;
    const bool hit = det != 0 && u >= 0 && v >= 0 && u + v <= 1 && distance > 0;
    return hit ? distance : std::numeric_limits<double>::infinity();
}

SceneBuilder randomTriangles(int count, unsigned seed)
{
    SceneBuilder b;
    const int grey = b.material(lambert(glm::vec3(0.5f)));
    std::mt19937 random(seed);
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;
    for (int i = 0; i < count; ++i) {
        const glm::vec3 centre = 4.0f * randomDirection(random) * uniform(random);
        for (int k = 0; k < 3; ++k) positions.push_back(centre + randomDirection(random));
        const auto first = static_cast<unsigned>(3 * i);
        triangles.push_back({first, first + 1, first + 2});
    }
    b.mesh(std::move(positions), std::move(triangles), grey);
    return b;
}

TEST(Accel, AgreesWithBruteForce)
{
    const auto world = randomTriangles(200, 3).world();
    const core::Accel accel(world);
    std::mt19937 random(5);
    std::vector<core::Ray> rays;
    size_t disagreeing = 0, hits = 0;
    for (int i = 0; i < 4000; ++i) {
        core::Ray ray;
        ray.origin = 6.0f * randomDirection(random);
        ray.direction = glm::normalize(2.0f * randomDirection(random) - ray.origin);
        rays.push_back(ray);
        double nearest = std::numeric_limits<double>::infinity();
        uint32_t slot = shared::kNone;
        for (uint32_t t = 0; t < world->triangles.size(); ++t) {
            const double distance = distanceTo(*world, world->triangles[t], ray);
            if (distance < nearest) {
                nearest = distance;
                slot = t;
            }
        }
        shared::Hit hit;
        const bool found = accel.closest(ray, hit);
        EXPECT_EQ(accel.occluded(ray), found);
        if (found != (slot != shared::kNone) || (found && hit.slot != slot)) {
            ++disagreeing;  // an edge seen from both sides of rounding
            continue;
        }
        if (!found) continue;
        ++hits;
        EXPECT_NEAR(static_cast<double>(hit.t) / nearest, 1.0, 1e-4);
        const core::WorldTriangle& t = world->triangles[slot];
        const glm::vec3 p = (1 - hit.barycentrics.x - hit.barycentrics.y) * world->positions[t.v0] +
                            hit.barycentrics.x * world->positions[t.v1] +
                            hit.barycentrics.y * world->positions[t.v2];
        EXPECT_LT(glm::distance(p, ray.origin + hit.t * ray.direction), 1e-4f);
        core::Ray shorter = ray;
        shorter.tMax = 0.999f * hit.t;
        EXPECT_FALSE(accel.occluded(shorter));
    }
    EXPECT_GT(hits, 2000u);
    EXPECT_LE(disagreeing, 1u);

    // Packets see what single rays see.
    std::vector<shared::Hit> packet(rays.size());
    std::vector<uint8_t> blocked(rays.size());
    accel.closest(rays, packet.data());
    accel.occluded(rays, blocked.data());
    size_t different = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
        shared::Hit hit;
        const bool found = accel.closest(rays[i], hit);
        different += found ? packet[i].slot != hit.slot : packet[i].slot != shared::kNone;
        different += (blocked[i] != 0) != found;
    }
    EXPECT_LE(different, 1u);
}

/// Leaves ones on the stack below the caller, where functions called next have their variables.
[[gnu::noinline]] void soilStack()
{
    volatile uint64_t words[8192];
    for (volatile uint64_t& word : words) word = ~uint64_t(0);
}

/// A packet sees what single rays see, whatever its idle lanes and the stack hold.
void expectPacketsSeeWhatSingleRaysSee(const core::Accel& accel)
{
    std::mt19937 random(7);
    size_t blocked = 0, different = 0, traced = 0;
    std::array<core::Ray, core::RayPacket::kSize> rays;
    std::array<shared::Hit, core::RayPacket::kSize> hits;
    for (int round = 0; round < 400; ++round) {
        core::RayPacket packet;
        std::memset(&packet, 0xff, sizeof(packet));  // not a number in every lane
        const auto count = static_cast<uint32_t>(1 + random() % core::RayPacket::kSize);
        uint32_t expected = 0;
        for (uint32_t i = 0; i < count; ++i) {
            core::Ray& ray = rays[i];
            ray.origin = 6.0f * randomDirection(random);
            ray.direction = glm::normalize(2.0f * randomDirection(random) - ray.origin);
            ray.tMax = 8 * uniform(random);
            packet.originX[i] = ray.origin.x;
            packet.originY[i] = ray.origin.y;
            packet.originZ[i] = ray.origin.z;
            packet.directionX[i] = ray.direction.x;
            packet.directionY[i] = ray.direction.y;
            packet.directionZ[i] = ray.direction.z;
            packet.tMax[i] = ray.tMax;
            packet.seed[i] = ray.seed;
            expected |= (accel.occluded(ray) ? 1u : 0u) << i;
        }
        soilStack();
        const uint32_t found = accel.occluded(packet, count);
        soilStack();
        accel.closest({rays.data(), count}, hits.data(), true);
        uint32_t hit = 0;
        for (uint32_t i = 0; i < count; ++i) hit |= (hits[i].slot != shared::kNone ? 1u : 0u) << i;
        different += static_cast<size_t>(std::popcount((found ^ expected) | (hit ^ expected)));
        blocked += static_cast<size_t>(std::popcount(found));
        traced += count;
    }
    EXPECT_LE(different, 1u);
    EXPECT_GT(blocked, traced / 5);
    EXPECT_LT(blocked, traced * 4 / 5);
}

/// In each hierarchy that Embree has functions of its own for; some of them do not come back from
/// packets that are called coherent.
TEST(Accel, PacketsSeeWhatSingleRaysSee)
{
    const SceneBuilder triangles = randomTriangles(200, 6);
    expectPacketsSeeWhatSingleRaysSee(core::Accel(triangles.world()));
    expectPacketsSeeWhatSingleRaysSee(
        core::Accel(triangles.world(), {}, {}, core::AccelQuality::compact));
    expectPacketsSeeWhatSingleRaysSee(core::Accel(worldOf(thicket(64), core::Instancing::kept)));
}

TEST(Accel, EmptySceneIsNeverHit)
{
    const core::Accel accel(SceneBuilder().world());
    shared::Hit hit;
    EXPECT_FALSE(accel.closest({}, hit));
    EXPECT_FALSE(accel.occluded({}));
}

TEST(Accel, RaysThatAreNotFiniteHitNothing)
{
    const core::Accel accel(randomTriangles(1000, 4).world());
    const float nan = std::numeric_limits<float>::quiet_NaN(),
                infinity = std::numeric_limits<float>::infinity();
    shared::Hit hit;
    for (const float bad : {nan, infinity, -infinity}) {
        core::Ray ray;
        ray.origin.x = bad;
        accel.closest(ray, hit);
        ray = {};
        ray.direction = glm::vec3(bad);
        accel.closest(ray, hit);
        const std::array<core::Ray, 3> some{core::Ray{}, ray, core::Ray{}};
        std::array<shared::Hit, 3> hits;
        std::array<uint8_t, 3> blocked;
        accel.closest(some, hits.data());
        EXPECT_EQ(hits[1].slot, shared::kNone);
        accel.occluded(some, blocked.data());
        EXPECT_EQ(blocked[1], 0);
    }
}

TEST(Accel, MaskedSurfacesLetLightThrough)
{
    SceneBuilder b;
    const int grey = b.material(lambert(glm::vec3(0.5f)));
    core::Material clear = lambert(glm::vec3(0.5f));
    clear.data.flags |= shared::kMaterialAlphaMask;
    clear.data.alpha = 0.4f;  // below the cut-off of 0.5
    b.quad({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, b.material(clear));
    b.quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, grey);
    const auto world = b.world();
    EXPECT_TRUE(world->features & shared::kFeatureAlpha);
    const core::Accel accel(world);
    core::Ray ray;
    ray.origin = {0.1f, 0.2f, 3};
    ray.direction = {0, 0, -1};
    shared::Hit hit;
    ASSERT_TRUE(accel.closest(ray, hit));
    EXPECT_EQ(world->materials[world->triangles[hit.slot].material].flags &
                  shared::kMaterialAlphaMask,
              0u);
    ray.direction = {0, 0, 1};
    ray.origin.z = 0.5f;
    EXPECT_FALSE(accel.occluded(ray));
}

/// Blending is chance by alpha: half the seeds pass a surface of alpha one half.
TEST(Accel, BlendedSurfacesAreThereByChance)
{
    SceneBuilder b;
    core::Material veil = lambert(glm::vec3(0.5f));
    veil.data.flags |= shared::kMaterialAlphaBlend;
    veil.data.alpha = 0.3f;
    b.quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, b.material(veil));
    const core::Accel accel(b.world());
    const int draws = 40000;
    int blocked = 0, packetBlocked = 0;
    std::vector<core::Ray> rays(draws);
    std::vector<uint8_t> flags(draws);
    for (int i = 0; i < draws; ++i) {
        core::Ray& ray = rays[static_cast<size_t>(i)];
        ray.origin = {0.1f, 0.2f, 3};
        ray.direction = {0, 0, -1};
        ray.seed = static_cast<uint32_t>(i) * 7919u;
        blocked += accel.occluded(ray);
    }
    accel.occluded(rays, flags.data());
    for (const uint8_t f : flags) packetBlocked += f;
    const double sigma = std::sqrt(0.3 * 0.7 * draws);
    EXPECT_LT(std::abs(blocked - 0.3 * draws), 4.21 * sigma);
    EXPECT_EQ(blocked, packetBlocked);
}

TEST(Accel, StopEndsTheBuild)
{
    std::stop_source source;
    source.request_stop();
    try {
        const core::Accel accel(randomTriangles(200'000, 6).world(), {}, source.get_token());
        // Embree does not check for stops early in a build: a small one may finish.
    } catch (const core::Error& e) {
        EXPECT_EQ(e.code(), core::ExitCode::interrupted);
    }
}

// --- T16

struct Reintersection {
    double scale, distance, allowed;
};

class LeavingRays : public testing::TestWithParam<Reintersection> {};

/// Rays that leave a random point of a triangle, half of them at grazing angles, do not meet that
/// triangle again.
TEST_P(LeavingRays, DoNotMeetTheirOwnTriangle)
{
    const auto [scale, distance, allowed] = GetParam();
    std::mt19937 random(23);
    const int triangleCount = 400, raysPerTriangle = 1000;
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;
    for (int i = 0; i < triangleCount; ++i) {
        const glm::vec3 centre = static_cast<float>(distance) * randomDirection(random);
        for (int k = 0; k < 3; ++k)
            positions.push_back(centre + static_cast<float>(scale) * randomDirection(random));
        const auto first = static_cast<unsigned>(3 * i);
        triangles.push_back({first, first + 1, first + 2});
    }
    SceneBuilder b;
    b.mesh(std::move(positions), std::move(triangles), b.material(lambert(glm::vec3(0.5f))));
    const auto world = b.world();
    const core::Accel accel(world);
    const shared::SceneView scene = core::sceneView(*world);
    size_t self = 0, total = 0;
    for (uint32_t slot = 0; slot < world->triangles.size(); ++slot) {
        for (int k = 0; k < raysPerTriangle; ++k) {
            const glm::vec2 w = shared::sampleTriangle({uniform(random), uniform(random)});
            const shared::SurfacePoint s =
                shared::makeSurfacePoint(scene, {1.0f, w, slot}, {0.6f, 0.0f, 0.8f});
            glm::vec3 local = shared::sampleCosineHemisphere({uniform(random), uniform(random)});
            if (k % 2 == 0) {
                const float phi = 6.2831853f * uniform(random);
                local = glm::normalize(glm::vec3(std::cos(phi), std::sin(phi), 1e-3f));
            }
            const glm::vec3 outside = k % 4 < 2 ? s.normal : -s.normal;
            core::Ray ray;
            ray.direction = glm::normalize(shared::toWorld(shared::makeFrame(outside), local));
            ray.origin = shared::offsetRay(s.position, outside);
            shared::Hit hit;
            ++total;
            self += accel.closest(ray, hit) && hit.slot == slot;
        }
    }
    EXPECT_GE(total, 390'000u);
    EXPECT_LE(static_cast<double>(self), allowed * static_cast<double>(total));
}

INSTANTIATE_TEST_SUITE_P(T16, LeavingRays,
                         testing::Values(Reintersection{1, 10, 0}, Reintersection{1e-4, 1e-4, 1e-5},
                                         Reintersection{1e2, 1e3, 1e-5},
                                         Reintersection{1e4, 1e6, 1e-5},
                                         Reintersection{0.1, 50, 0}));

/// A plane of two triangles, `tilt` degrees from lying flat, beside the centre.
struct TiltedPlane {
    glm::dvec3 along, across, normal;
    std::array<glm::vec3, 4> corners;

    TiltedPlane(double tilt, double side, double width, double below)
    {
        const double t = glm::radians(tilt);
        normal = {0.6 * std::sin(t), std::cos(t), 0.8 * std::sin(t)};
        along = glm::normalize(glm::cross(glm::dvec3(0.1, 0, 1), normal));
        across = glm::cross(along, normal);
        const auto at = [&](double x, double z) {
            return glm::vec3(x * side * along + z * width * across - below * normal);
        };
        corners = {at(-1, 1), at(1, 1), at(1, -1), at(-1, -1)};
    }
};

/// The error of a hit is that of its triangle, however small the hit's own coordinates are: of
/// Embree's hits, and of those of the test that our own traversals make.
TEST(T16, RaysThatLeaveLargeTrianglesNearTheCentreDoNotMeetThem)
{
    std::mt19937 random(29);
    const auto around = [&] { return 2.0 * static_cast<double>(uniform(random)) - 1; };
    size_t total = 0;
    for (const double tilt : {0.0, 5.0, 15.0, 45.0}) {
        for (const double width : {60.0, 2.0, 0.1}) {
            const TiltedPlane plane(tilt, 60, width, 0.05);
            SceneBuilder b;
            b.mesh({plane.corners.begin(), plane.corners.end()}, {{0, 1, 2}, {0, 2, 3}},
                   b.material(lambert(glm::vec3(0.5f))));
            const auto world = b.world();
            const core::Accel accel(world);
            const shared::SceneView scene = core::sceneView(*world);
            const auto meetsOne = [&](const core::Ray& ray, shared::Hit& hit) {
                const shared::ShearRay shear = shared::makeShearRay(ray.origin, ray.direction);
                hit.t = shared::kInfinity;
                for (hit.slot = 0; hit.slot < 2; ++hit.slot) {
                    const auto& t = world->triangles[hit.slot];
                    if (shared::intersectTriangle(shear, world->positions[t.v0],
                                                  world->positions[t.v1], world->positions[t.v2], 0,
                                                  shared::kInfinity, hit.t, hit.barycentrics))
                        return true;
                }
                return false;
            };
            size_t self = 0, selfByEmbree = 0;
            for (int i = 0; i < 20'000; ++i) {
                const glm::dvec3 target = around() * plane.along +
                                          std::min(1.0, width) * around() * plane.across -
                                          0.05 * plane.normal - world->placement.centre;
                core::Ray ray;
                ray.origin = glm::vec3(target + plane.normal + 0.5 * around() * plane.along);
                ray.direction = glm::normalize(glm::vec3(target) - ray.origin);
                const glm::vec2 u{uniform(random), uniform(random)};
                const auto leaves = [&](const shared::Hit& hit) {
                    const shared::SurfacePoint s =
                        shared::makeSurfacePoint(scene, hit, ray.direction);
                    core::Ray next;
                    next.origin = shared::originOnSide(s, 1);
                    next.direction =
                        shared::toWorld(shared::makeFrame(s.backFace != 0 ? -s.normal : s.normal),
                                        shared::sampleCosineHemisphere(u));
                    return next;
                };
                shared::Hit hit, again;
                if (meetsOne(ray, hit)) {
                    ++total;
                    self += meetsOne(leaves(hit), again) ? 1u : 0u;
                }
                if (accel.closest(ray, hit)) selfByEmbree += accel.occluded(leaves(hit)) ? 1u : 0u;
            }
            EXPECT_EQ(self, 0u) << "tilted by " << tilt << ", " << width << " wide";
            EXPECT_EQ(selfByEmbree, 0u) << "tilted by " << tilt << ", " << width << " wide";
        }
    }
    EXPECT_GT(total, 230'000u);
}

}  // namespace
