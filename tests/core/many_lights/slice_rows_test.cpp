// M22. Weights of rows against their closed form, in slices that have shading normals, transmission
// and deep receivers and in slices that have none, for which loops of their own leave these out.
#include "core/many_lights/slice_rows.h"

#include <random>

#include <gtest/gtest.h>

#include "core/completion/bits.h"
#include "core/trace/scene_view.h"
#include "tests/support/scenes/test_scenes.h"

namespace core::many_lights {
namespace {

using namespace tests;
using glm::vec3;

constexpr uint32_t kSize = 48, kMaxDepth = 6;

/// A floor, a smooth ball and a rough pane through which light passes, by receivers.
struct Room {
    std::shared_ptr<const core::World> world;
    std::unique_ptr<core::Accel> accel;
    std::vector<Receiver> receivers;
    std::vector<uint32_t> floor, ball, pane;

    Room()
    {
        SceneBuilder b;
        b.quad({-2, -1, 2}, {4, 0, 0}, {0, 0, -4}, b.material(lambert(vec3(0.5f))));
        b.sphere({-0.6f, 0, 0}, 0.7f, 2, b.material(lambert(vec3(0.7f))), false, true);
        core::Material rough = glossy(vec3(0.8f), 0, 0.5f);
        rough.data.transmission = 0.8f;
        b.quad({0.4f, -0.8f, 0}, {1, 0, 0}, {0, 1.4f, 0}, b.material(rough));
        b.camera({0, 0.6, 4}, {0, -0.2, 0}, 0.9);
        world = b.world();
        accel = std::make_unique<core::Accel>(world);
        ReceiverJob job;
        job.accel = accel.get();
        job.settings = core::worldSettings(*world);
        job.settings.maxDepth = kMaxDepth;
        job.settings.rouletteDepth = 2;
        job.settings.seed = 1;
        job.settings.samplerKind = shared::kSamplerIndependent;
        job.settings.imageWidth = job.settings.imageHeight = kSize;
        job.camera = core::cameraData(world->cameras[0], kSize, kSize);
        std::vector<vec3> direct(size_t(kSize) * kSize);
        traceReceivers(job, {0, 0, kSize, kSize}, receivers, direct);
        SliceRows rows;
        const std::vector<uint32_t> all = numbered();
        rows.reset(core::sceneView(*world), receivers, all);
        for (const uint32_t i : all) {
            const vec3 n = rows.shadingNormal(i);
            (n == vec3(0) ? pane : n == receivers[i].normal ? floor : ball).push_back(i);
        }
    }

    std::vector<uint32_t> numbered() const
    {
        std::vector<uint32_t> all(receivers.size());
        for (uint32_t i = 0; i < all.size(); ++i) all[i] = i;
        return all;
    }
};

std::vector<VirtualLight> lightsIn(const core::World& world)
{
    std::vector<VirtualLight> lights;
    for (const LightKind kind : {LightKind::surface, LightKind::point, LightKind::directional})
        for (const vec3 from :
             {vec3(0.2f, 1.5f, 1.5f), vec3(-1.8f, -0.7f, 0.3f), vec3(1, 0.2f, -1.5f)})
            for (const uint32_t bothSides : {0u, 1u})
                for (const uint32_t bounces : {0u, kMaxDepth - 2, kMaxDepth}) {
                    VirtualLight light;
                    light.kind = kind;
                    light.position = vec3(world.placement.toWorld(glm::dvec3(from)));
                    light.normal = glm::normalize(vec3(0.1f, -0.2f, -0.3f) - from);
                    light.bounces = bounces;
                    light.bothSides = bothSides;
                    lights.push_back(light);
                }
    return lights;
}

/// By number of receiver; -1 of those that are not in the slice.
std::vector<float> weightsIn(const Room& room, const std::vector<uint32_t>& chosen,
                             const VirtualLight& light)
{
    SliceRows rows;
    rows.reset(core::sceneView(*room.world), room.receivers, chosen);
    std::vector<float> weights(chosen.size());
    rows.weigh({&light, 1, 0}, {kMaxDepth, 0.01f}, weights);
    std::vector<float> found(room.receivers.size(), -1.0f);
    for (size_t i = 0; i < chosen.size(); ++i) found[chosen[i]] = weights[i];
    return found;
}

/// Of a receiver that is not the pane's, in double precision.
double closedForm(const Receiver& receiver, const vec3& shadingNormal, const VirtualLight& light)
{
    if (receiver.events + light.bounces >= kMaxDepth) return 0;
    const glm::dvec3 d(towards(light, receiver.position));
    const double a = glm::dot(d, glm::dvec3(shadingNormal));
    if (a <= 0 || glm::dot(d, glm::dvec3(receiver.normal)) <= 0) return 0;
    if (light.kind == LightKind::directional) return a;
    const double r2 = glm::dot(d, d);
    if (light.kind == LightKind::point) return a / (r2 * std::sqrt(r2));
    const double leaves = -glm::dot(d, glm::dvec3(light.normal));
    return a * (light.bothSides != 0 ? std::abs(leaves) : std::max(leaves, 0.0)) / (r2 * r2);
}

TEST(SliceRows, WeightsAreTheirClosedForm)
{
    const Room room;
    SliceRows rows;
    rows.reset(core::sceneView(*room.world), room.receivers, room.numbered());
    size_t lit = 0, normalsDisagree = 0;
    for (const VirtualLight& light : lightsIn(*room.world)) {
        const std::vector<float> found = weightsIn(room, room.numbered(), light);
        for (const std::vector<uint32_t>* part : {&room.floor, &room.ball})
            for (const uint32_t i : *part) {
                const vec3 normal = rows.shadingNormal(i),
                           d = towards(light, room.receivers[i].position);
                const double expected = closedForm(room.receivers[i], normal, light);
                const float a = glm::dot(normal, d), g = glm::dot(room.receivers[i].normal, d);
                lit += expected > 0 ? 1 : 0;
                normalsDisagree += a * g < 0 ? 1 : 0;
                // At a horizon rounding decides.
                if (std::min(std::abs(a), std::abs(g)) < 1e-5f) continue;
                ASSERT_NEAR(found[i], expected, 1e-4 * expected) << "row " << i;
            }
    }
    EXPECT_GT(lit, 1000u);
    EXPECT_GT(normalsDisagree, 20u) << "else one normal would do";
}

/// What a slice does not have must make no difference.
TEST(SliceRows, ARowWeighsTheSameInEverySlice)
{
    const Room room;
    ASSERT_GT(room.floor.size(), 200u);
    ASSERT_GT(room.ball.size(), 100u);
    ASSERT_GT(room.pane.size(), 50u);
    std::vector<uint32_t> opaque = room.floor;
    opaque.insert(opaque.end(), room.ball.begin(), room.ball.end());
    size_t throughPane = 0;
    for (const VirtualLight& light : lightsIn(*room.world)) {
        const std::vector<float> all = weightsIn(room, room.numbered(), light);
        for (const std::vector<uint32_t>& slice : {room.floor, room.ball, opaque, room.pane}) {
            const std::vector<float> found = weightsIn(room, slice, light);
            for (const uint32_t i : slice) ASSERT_EQ(found[i], all[i]) << "row " << i;
        }
        for (const uint32_t i : room.pane)
            throughPane += all[i] > 0 && glm::dot(towards(light, room.receivers[i].position),
                                                  room.receivers[i].normal) < 0;
    }
    EXPECT_GT(throughPane, 50u);
}

/// One deep row turns no other dark, and light that is as deep does not reach it.
TEST(SliceRows, DeepRowsAreDarkAlone)
{
    Room room;
    const uint32_t deep = room.floor[room.floor.size() / 2];
    bool wasLit = false;
    for (const VirtualLight& light : lightsIn(*room.world)) {
        room.receivers[deep].events = 0;
        const std::vector<float> shallow = weightsIn(room, room.floor, light);
        room.receivers[deep].events = 3;
        const std::vector<float> found = weightsIn(room, room.floor, light);
        for (const uint32_t i : room.floor) {
            const bool dark = i == deep && light.bounces + 3 >= kMaxDepth;
            wasLit = wasLit || (dark && shallow[i] > 0);
            ASSERT_EQ(found[i], dark ? 0.0f : shallow[i]) << "row " << i;
        }
    }
    EXPECT_TRUE(wasLit);
}

/// Whether told by bounds or row by row.
TEST(SliceRows, RowsThatAreReachedAreThoseThatWeighSomething)
{
    const Room room;
    std::vector<uint32_t> opaque = room.floor;
    opaque.insert(opaque.end(), room.ball.begin(), room.ball.end());
    const std::vector<VirtualLight> lights = lightsIn(*room.world);
    for (const std::vector<uint32_t>& slice :
         {room.floor, room.ball, opaque, room.pane, room.numbered()}) {
        SliceRows rows;
        rows.reset(core::sceneView(*room.world), room.receivers, slice);
        std::vector<float> weights(slice.size()), scratch(slice.size());
        Words reached(wordsFor(rows.count())), expected(reached.size());
        for (const VirtualLight& light : lights) {
            const Column column{&light, 1, 0};
            rows.weigh(column, {kMaxDepth, 0.01f}, weights);
            positiveToBits(weights, expected);
            rows.findReached(column, {kMaxDepth, 0.01f}, scratch, reached);
            ASSERT_EQ(reached, expected);
        }
    }
}

/// Patches of a sphere, from almost flat to more than half of it, and flat ones, which lights of
/// all kinds surround.
struct Patches {
    RowTriple position, normal;
    uint32_t count = 0;

    Patches(std::mt19937& random, float angle, bool flat)
    {
        std::uniform_real_distribution<float> uniform(-1, 1);
        for (int word = 0; word < 40; ++word) {
            const vec3 axis = direction(random), middle = 3.0f * direction(random);
            const vec3 x = glm::normalize(glm::cross(axis, direction(random))),
                       y = glm::cross(axis, x);
            for (uint32_t i = 0; i < RowBounds::kRows; ++i) {
                const float a = angle * uniform(random), b = 3.2f * uniform(random);
                const vec3 across = std::cos(b) * x + std::sin(b) * y,
                           n = flat ? axis : std::cos(a) * axis + std::sin(a) * across;
                const vec3 p = middle + (flat ? a * across : n);
                for (int c = 0; c < 3; ++c) {
                    position[size_t(c)].push_back(p[c]);
                    normal[size_t(c)].push_back(n[c]);
                }
                ++count;
            }
        }
    }

    static vec3 direction(std::mt19937& random)
    {
        std::normal_distribution<float> number;
        return glm::normalize(vec3(number(random), number(random), number(random)));
    }
};

/// What bounds tell of 64 rows at once holds for each, and of most flat patches they tell.
TEST(RowBounds, AreTrueOfEachRow)
{
    std::mt19937 random(17);
    for (const bool flat : {true, false})
        for (const float angle : {0.02f, 0.3f, 1.2f, 2.5f}) {
            const Patches patches(random, angle, flat);
            RowBounds bounds;
            bounds.reset(patches.position, patches.normal, patches.normal, patches.count);
            size_t told = 0, words = 0;
            for (uint32_t k = 0; k < 600; ++k) {
                VirtualLight light;
                light.kind = static_cast<LightKind>(k % 3);
                light.bothSides = k / 3 % 2;
                light.position = (k % 5 == 0 ? 1.2f : 4.0f) * Patches::direction(random);
                light.normal = Patches::direction(random);
                const std::span<const float> reach = bounds.reach(light, k % 2 == 0);
                ASSERT_EQ(reach.size(), patches.count / RowBounds::kRows);
                for (size_t w = 0; w < reach.size(); ++w, ++words) {
                    if (reach[w] == RowBounds::kSome) continue;
                    ++told;
                    for (size_t i = RowBounds::kRows * w; i < RowBounds::kRows * (w + 1); ++i) {
                        const auto of = [i](const RowTriple& t) {
                            return vec3(t[0][i], t[1][i], t[2][i]);
                        };
                        const vec3 d = towards(light, of(patches.position));
                        const float leaves = -glm::dot(d, light.normal);
                        const bool shines = light.kind != LightKind::surface || leaves > 0 ||
                                            (light.bothSides != 0 && leaves < 0);
                        ASSERT_EQ(glm::dot(d, of(patches.normal)) > 0 && shines,
                                  reach[w] == RowBounds::kAll)
                            << "angle " << angle << ", light " << k << ", row " << i;
                    }
                }
            }
            if (angle < 0.1f) {
                EXPECT_GT(double(told), 0.85 * double(words)) << flat;
            }
        }
}

}  // namespace
}  // namespace core::many_lights
