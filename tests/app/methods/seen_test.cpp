// What pictures of a moving camera take their edges and textures from: what appears behind panes
// and in mirrors is where it appears to be, on every device.
#include <cmath>

#include <gtest/gtest.h>

#include "app/methods/methods.h"
#include "tests/support/methods/shared_renderer.h"
#include "tests/support/scenes/test_scenes.h"

namespace {

using namespace tests;
using core::Sight;
using glm::vec3;

constexpr glm::uvec2 kSize(24, 20);

class Seen : public testing::TestWithParam<app::DeviceKind> {
protected:
    core::Aovs surfaces(const SceneBuilder& b, Sight sight) const
    {
        const std::shared_ptr<const core::World> world = b.world();
        core::Renderer& renderer = sharedRenderer("path", GetParam());
        renderer.setWorld(world, {});
        const core::Camera& camera = world->cameras.front();
        renderer.setView({camera, {8, 8}, core::methodNamed("path").defaults}, core::Start::anew);
        return renderer.surfaces(camera, kSize, sight);
    }
};

core::Material glass(const vec3& tint)
{
    core::Material m = glossy(tint, 0, 0);
    m.data.transmission = 1;
    return m;
}

/// Two surfaces side by side, the second of which shines to the side of u x v.
void addWalls(SceneBuilder& b, vec3 corner, vec3 u, vec3 v, vec3 along)
{
    b.quad(corner, u, v, b.material(lambert({0.7f, 0.3f, 0.1f})));
    b.quad(corner + along, u, v, b.material(emitter(vec3(2, 1, 3), {0.2f, 0.5f, 0.6f})));
}

/// The same surfaces with `share` of their light.
void expectSeen(const core::Aovs& seen, const core::Aovs& expected, const vec3& share)
{
    size_t surfaces = 0, shining = 0;
    for (size_t i = 0; i < expected.depth.pixels.size(); ++i) {
        EXPECT_NEAR(seen.depth.pixels[i], expected.depth.pixels[i], 2e-4f) << i;
        surfaces += expected.depth.pixels[i] > 0 ? 1u : 0u;
        EXPECT_EQ(seen.ids.pixels[3 * i + 1], expected.ids.pixels[3 * i + 1]) << i;
        for (size_t c = 0; c < 3; ++c) {
            const float part = share[static_cast<int>(c)];
            EXPECT_NEAR(seen.normal.pixels[3 * i + c], expected.normal.pixels[3 * i + c], 1e-4f);
            EXPECT_NEAR(seen.albedo.pixels[3 * i + c], part * expected.albedo.pixels[3 * i + c],
                        2e-3f);
            EXPECT_NEAR(seen.emission.pixels[3 * i + c], part * expected.emission.pixels[3 * i + c],
                        0.01f);
        }
        shining += expected.emission.pixels[3 * i] > 1 ? 1u : 0u;
    }
    EXPECT_GT(surfaces, 100u);
    EXPECT_GT(shining, 20u);
}

TEST_P(Seen, WhatIsBehindPanesIsWhereItIs)
{
    SceneBuilder open;
    addWalls(open, {-3, -3, -2}, {3, 0, 0}, {0, 6, 0}, {3, 0, 0});
    open.constantEnvironment({4, 5, 6});
    open.camera({0, 0, 4}, {0, 0, 0}, 0.5);
    SceneBuilder behind = open;
    const vec3 tint(0.9f, 0.8f, 0.6f);
    for (const float z : {0.0f, 1.0f})
        behind.quad({-3, -3, z}, {6, 0, 0}, {0, 6, 0}, behind.material(glass(tint)));
    // Of ior 1.5; the pane has no thickness in which light would go to and fro.
    constexpr float kThrough = 0.96f;
    const core::Aovs expected = surfaces(open, Sight::first);
    const vec3 share = tint * tint * (kThrough * kThrough);
    expectSeen(surfaces(behind, Sight::clear), expected, share);
    const core::Aovs first = surfaces(behind, Sight::first);
    for (const float depth : first.depth.pixels) EXPECT_LT(depth, 3.5f) << "the pane itself";
}

/// A mirror of 45 degrees about the height, and what it shows as a scene of its own.
TEST_P(Seen, WhatIsInMirrorsIsWhereItAppears)
{
    SceneBuilder before, appears;
    addWalls(before, {-3, -2, -1.5f}, {0, 4, 0}, {0, 0, 1.5f}, {0, 0, 1.5f});
    addWalls(appears, {-1.5f, -2, -3}, {1.5f, 0, 0}, {0, 4, 0}, {1.5f, 0, 0});
    for (SceneBuilder* b : {&before, &appears}) {
        b->constantEnvironment({4, 5, 6});
        b->camera({0, 0, 5}, {0, 0, 0}, 0.3);
    }
    const vec3 silver(0.95f, 0.9f, 0.85f);
    before.quad({-2, -3, -2}, {4, 0, 4}, {0, 6, 0}, before.material(glossy(silver, 1, 0)));
    expectSeen(surfaces(before, Sight::clear), surfaces(appears, Sight::first), silver);
}

TEST_P(Seen, WhereBothWaysCountAPaneIsSeenItself)
{
    SceneBuilder b;
    b.quad({-3, 0, -3}, {6, 0, 0}, {0, 0, 6}, b.material(glass(vec3(1))));
    b.quad({-9, -1, -9}, {18, 0, 0}, {0, 0, 18}, b.material(lambert(vec3(0.5f))));
    SceneBuilder steep = b;
    b.camera({0, 0.5, 4}, {0, 0, 0}, 0.05);
    steep.camera({0, 5, 1}, {0, 0, 0}, 0.05);
    for (const float id : {surfaces(b, Sight::clear).ids.at(12, 10)[1]}) EXPECT_EQ(id, 0.0f);
    for (const float id : {surfaces(steep, Sight::clear).ids.at(12, 10)[1]}) EXPECT_EQ(id, 1.0f);
}

/// Mirrors that face one another, and curved glass that absorbs: the way has an end, and numbers.
TEST_P(Seen, WaysEnd)
{
    SceneBuilder b;
    const int mirror = b.material(glossy(vec3(1), 1, 0));
    b.box({-2, -2, -2}, {2, 2, 2}, mirror, true);
    core::Material solid = glass(vec3(1));
    solid.data.absorption = vec3(0.5f);
    solid.data.flags = shared::kMaterialVolume;
    b.sphere({0, 0, 0}, 0.5f, 3, b.material(solid), false, true);
    b.camera({0, 0.3, 1.9}, {0, 0, 0}, 0.8);
    const core::Aovs seen = surfaces(b, Sight::clear);
    for (const core::Image* image : {&seen.depth, &seen.normal, &seen.albedo, &seen.emission})
        for (const float x : image->pixels) ASSERT_TRUE(std::isfinite(x));
    for (size_t i = 0; i < seen.depth.pixels.size(); ++i) {
        const float* n = &seen.normal.pixels[3 * i];
        EXPECT_NEAR(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1, 1e-3f);
    }
}

INSTANTIATE_TEST_SUITE_P(Device, Seen,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         [](const auto& device) {
                             return std::string(core::enumName(device.param));
                         });

}  // namespace
