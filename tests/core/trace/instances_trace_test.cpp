// Rays among instances (T37): they find what they find where the same meshes are written out, by
// Embree alone and in packets and by our own hierarchy, whose numbers of slots differ; alpha is
// decided for each instance; a click finds what rays find; motion, finer grids and 10^8 triangles.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include <glm/gtc/matrix_transform.hpp>

#include "core/scene/instances.h"
#include "core/trace/accel.h"
#include "core/trace/bvh_traverse.h"
#include "core/trace/pick.h"
#include "core/trace/scene_view.h"
#include "core/trace/world_bvh.h"
#include "shared/instances.h"
#include "shared/surface.h"
#include "tests/support/scenes/animated_scenes.h"
#include "tests/support/scenes/instanced_scenes.h"
#include "tests/support/statistics/random_values.h"

namespace {

using core::Instancing;
using namespace tests;
using WorldPointer = std::shared_ptr<const core::World>;

std::vector<core::Ray> raysAmong(const core::World& world, size_t count)
{
    Random random(11);
    std::vector<core::Ray> rays(count);
    for (core::Ray& ray : rays) {
        const glm::vec3 margin(0.2f * world.radius);
        ray.origin = random.inBox(world.boundsLow - margin, world.boundsHigh + margin);
        ray.direction = glm::normalize(random.inBox(glm::vec3(-1), glm::vec3(1)));
        ray.seed = static_cast<uint32_t>(random() * 4e9f);
    }
    return rays;
}

/// What renderers make of a hit. The scene's own numbers of triangles differ between worlds.
struct Seen {
    double t = 0;
    shared::SurfacePoint surface;
};

Seen look(const core::World& world, const shared::Hit& hit, glm::vec3 direction)
{
    return {static_cast<double>(hit.t),
            shared::makeSurfacePoint(core::sceneView(world), hit, direction)};
}

bool alike(const Seen& a, const Seen& b)
{
    return std::abs(a.t - b.t) < 1e-4 * (1 + a.t) &&
           glm::distance(a.surface.position, b.surface.position) < 1e-3f &&
           glm::dot(a.surface.normal, b.surface.normal) > 0.9999f &&
           glm::dot(a.surface.frame[2], b.surface.frame[2]) > 0.995f &&
           a.surface.material == b.surface.material && a.surface.backFace == b.surface.backFace;
}

TEST(InstancedRays, FindWhatIsThereWhenItIsWrittenOut)
{
    const SceneBuilder scene = thicket(64);
    const WorldPointer flat = worldOf(scene, Instancing::flat),
                       kept = worldOf(scene, Instancing::kept);
    ASSERT_EQ(kept->instances.size(), 64u);
    const core::Accel inFlat(flat), inKept(kept);
    const std::vector<core::Ray> rays = raysAmong(*flat, 20000);
    std::vector<shared::Hit> packets(rays.size());
    std::vector<uint8_t> blocked(rays.size());
    inKept.closest(rays, packets.data());
    inKept.occluded(rays, blocked.data());
    size_t others = 0, hits = 0, instanced = 0, packed = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
        shared::Hit a, b;
        const bool hitA = inFlat.closest(rays[i], a), hitB = inKept.closest(rays[i], b);
        EXPECT_EQ(inKept.occluded(rays[i]), hitB) << i;
        EXPECT_EQ(blocked[i] != 0, hitB) << i;
        packed += (packets[i].slot == shared::kNone) == hitB ||
                  (hitB && packets[i].slot != b.slot && std::abs(packets[i].t - b.t) > 1e-5f);
        if (hitA != hitB) {
            ++others;
            continue;
        }
        if (!hitA) continue;
        ++hits;
        instanced += b.slot >= shared::kFirstInstancedSlot;
        others +=
            alike(look(*flat, a, rays[i].direction), look(*kept, b, rays[i].direction)) ? 0u : 1u;
    }
    EXPECT_GT(hits, rays.size() / 4);
    EXPECT_GT(instanced, rays.size() / 20);
    EXPECT_LE(others, rays.size() / 2000) << "only at edges";
    EXPECT_LE(packed, rays.size() / 10000);
}

/// Where our hierarchy finds something, and what: the triangle that is stored, and its instance.
struct Met {
    float t = shared::kInfinity;
    uint32_t triangle = shared::kNone, matrix = 0;
};

class OwnHierarchy {
public:
    explicit OwnHierarchy(const core::World& world)
        : world_(world), bvh_(core::bvhOf(world, {})),
          table_(core::makeInstanceTable(world, bvh_->prototypeSlots)),
          view_(core::sceneView(world))
    {
        view_.instances = table_.data();
    }

    Met trace(const core::Ray& ray) const
    {
        core::BvhHit hit;
        if (!core::traceClosest(*bvh_, world_.positions, world_.triangles, ray.origin,
                                ray.direction, 0, ray.tMax, hit))
            return {};
        const shared::StoredTriangle stored = shared::findTriangle(view_, hit.slot);
        return {hit.t, bvh_->triangle(stored.slot), stored.matrix};
    }
    bool any(const core::Ray& ray) const
    {
        return core::traceAny(*bvh_, world_.positions, world_.triangles, ray.origin, ray.direction,
                              0, ray.tMax);
    }
    const core::Bvh& bvh() const { return *bvh_; }

private:
    const core::World& world_;
    std::shared_ptr<const core::Bvh> bvh_;
    std::vector<glm::uvec4> table_;
    shared::SceneView view_;
};

size_t disagreements(const WorldPointer& pointer, size_t count)
{
    const core::World& world = *pointer;
    const OwnHierarchy own(world);
    const core::Accel accel(pointer);
    size_t others = 0;
    for (const core::Ray& ray : raysAmong(world, count)) {
        shared::Hit hit;
        const bool any = accel.closest(ray, hit);
        const Met met = own.trace(ray);
        if (any != (met.triangle != shared::kNone)) {
            ++others;
            continue;
        }
        if (!any) continue;
        const shared::StoredTriangle stored =
            shared::findTriangle(core::sceneView(world), hit.slot);
        const bool same = stored.slot == met.triangle && stored.matrix == met.matrix;
        others += !same && std::abs(hit.t - met.t) > 1e-4f * hit.t ? 1u : 0u;
        EXPECT_EQ(own.any(ray), met.triangle != shared::kNone);
    }
    return others;
}

TEST(InstancedRays, OwnHierarchyFindsWhatEmbreeFinds)
{
    for (const int count : {3, 4, 64, 400}) {
        SCOPED_TRACE(count);
        const WorldPointer kept = worldOf(thicket(count), Instancing::kept);
        ASSERT_FALSE(kept->instances.empty());
        EXPECT_LE(disagreements(kept, 10000), 2u);
        EXPECT_LE(core::bvhOf(*kept, {})->depth, shared::kBvhMaxDepth);
    }
}

/// A ground of 200 kilometres below: rays begin on a finer grid around the instances.
TEST(InstancedRays, OnFinerGrids)
{
    SceneBuilder scene = thicket(300);
    const float far = 100000;
    scene.quad({-far, -0.1f, far}, {2 * far, 0, 0}, {0, 0, -2 * far}, 0);
    const WorldPointer kept = worldOf(scene, Instancing::kept);
    const OwnHierarchy own(*kept);
    EXPECT_GE(own.bvh().gridChanges(), 1u);
    EXPECT_NE(core::entryOf(own.bvh()).way, shared::kBvhDone);
    const core::Accel accel(kept);
    const auto scale = static_cast<float>(kept->placement.scale);
    Random random(11);
    size_t others = 0;
    for (int i = 0; i < 10000; ++i) {
        core::Ray ray;
        ray.origin = scale * random.inBox({-10, 0.1f, -10}, {10, 3, 10}) -
                     scale * glm::vec3(kept->placement.centre);
        ray.direction = glm::normalize(random.inBox(glm::vec3(-1), glm::vec3(1)));
        shared::Hit hit;
        const bool any = accel.closest(ray, hit);
        const Met met = own.trace(ray);
        // Of the ground, which is that large, single precision knows the place less well.
        const bool ground = any && hit.slot < shared::kFirstInstancedSlot && met.matrix == 0;
        others += any != (met.triangle != shared::kNone) ||
                  (any && !ground && std::abs(hit.t - met.t) > 1e-3f * hit.t);
    }
    EXPECT_LE(others, 10u);
}

TEST(InstancedRays, BesideWhatMoves)
{
    SceneBuilder scene = thicket(64);
    const auto node = static_cast<int>(scene.scene.nodes.size()) - 2;
    ASSERT_FALSE(scene.scene.nodes[static_cast<size_t>(node)].meshes.empty());
    scene.scene.nodes[static_cast<size_t>(node)].local = core::Transform();
    animate(scene.scene, {channelOf(node, core::AnimationChannel::Path::translation,
                                    {{0, 0, 0, 0}, {-8, 5, -3, 0}})});
    WorldPointer world = worldOf(scene, Instancing::kept);
    EXPECT_EQ(world->instances.size(), 63u);
    for (const double time : {0.0, 0.4, 0.9}) {
        world = core::poseWorld(world, time);
        EXPECT_LE(disagreements(world, 5000), 2u) << time;
    }
}

/// Two half transparent quads that are instances of one: a quarter of the rays passes both. If the
/// decision were the triangle's alone, half of them would.
TEST(InstancedRays, EachInstanceDecidesAboutItsAlpha)
{
    SceneBuilder scene;
    core::Material veil = lambert(glm::vec3(0.5f));
    veil.data.flags |= shared::kMaterialAlphaBlend;
    veil.data.alpha = 0.5f;
    const int mesh = scene.looseMesh({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}},
                                     {{0, 1, 2}, {0, 2, 3}}, scene.material(veil));
    for (const double z : {0.0, 1.0})
        scene.node(glm::translate(glm::dmat4(1), glm::dvec3(0, 0, z)), {mesh});
    scene.camera({0, 0, 5}, {0, 0, 0}, 0.5);
    for (const Instancing instancing : {Instancing::flat, Instancing::kept}) {
        const WorldPointer world = worldOf(scene, instancing);
        ASSERT_EQ(world->instances.size(), instancing == Instancing::kept ? 2u : 0u);
        const core::Accel accel(world);
        constexpr int kRays = 40000;
        int passed = 0;
        Random random(11);
        for (int i = 0; i < kRays; ++i) {
            core::Ray ray;
            ray.origin = glm::vec3(0.5f * random(), 0.5f * random() - 0.25f, 10);
            ray.direction = {0, 0, -1};
            ray.seed = shared::hashUint(static_cast<uint32_t>(i));
            passed += accel.occluded(ray) ? 0 : 1;
        }
        EXPECT_NEAR(passed, 0.25 * kRays, 5 * std::sqrt(0.1875 * kRays));
    }
}

TEST(InstancedRays, AClickFindsThemWithAndWithoutAHierarchy)
{
    const SceneBuilder scene = thicket(30);
    const WorldPointer flat = worldOf(scene, Instancing::flat),
                       searched = worldOf(scene, Instancing::kept),
                       kept = worldOf(scene, Instancing::kept);
    core::bvhOf(*kept, {});
    ASSERT_EQ(core::bvhIfMade(*searched), nullptr);
    int hits = 0, instanced = 0, others = 0;
    for (int y = 0; y < 24; ++y) {
        for (int x = 0; x < 32; ++x) {
            const auto at = [&](const core::World& world) {
                return core::pick(world, world.cameras.front(), {32, 24},
                                  {(x + 0.5) / 32, (y + 0.5) / 24});
            };
            const auto a = at(*flat), b = at(*kept), c = at(*searched);
            ASSERT_EQ(b.has_value(), c.has_value());
            if (!b || !a) {
                others += a.has_value() != b.has_value();
                continue;
            }
            ++hits;
            instanced += b->instance != shared::kNone;
            EXPECT_EQ(b->triangle, c->triangle);
            EXPECT_EQ(b->instance, c->instance);
            others += std::abs(a->distance - b->distance) > 1e-3 ||
                      glm::dot(glm::normalize(a->normal), glm::normalize(b->normal)) < 0.999 ||
                      a->material != b->material;
        }
    }
    EXPECT_GT(hits, 300);
    EXPECT_GT(instanced, 50);
    EXPECT_LE(others, 3);
}

/// 3200 things of 32770 triangles: 10^8 are shown, 65 thousand stored.
TEST(InstancedRays, AHundredMillionTrianglesTakeLittleMemory)
{
    const WorldPointer world = worldOf(thicket(3200, {.levels = 6}), Instancing::automatic);
    EXPECT_GT(core::shownTriangles(*world), 100'000'000u);
    EXPECT_LT(world->triangles.size(), 100'000u);
    const core::Accel accel(world);
    EXPECT_LT(accel.stats().peakBytes, 100u << 20);
    const auto bvh = core::bvhOf(*world, {});
    EXPECT_LT(bvh->nodeCount() * 32 + bvh->slotCount() * 48, 20u << 20);
    EXPECT_LE(disagreements(world, 1000), 1u);
}

}  // namespace
