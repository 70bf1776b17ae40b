// Clicking on a scene finds what a renderer's first hits find there.
#include <string>

#include <gtest/gtest.h>

#include "core/gltf/gltf.h"
#include "core/methods/method.h"
#include "core/trace/pick.h"
#include "core/trace/world_bvh.h"
#include "tests/support/scenes/test_scenes.h"

namespace {

TEST(Pick, FindsTheFirstHitsOfTheRenderer)
{
    const auto world =
        core::makeWorld(core::loadGltf(REKINDLE_SOURCE_DIR "/assets/cornell-diffuse.gltf"));
    const core::Camera camera = world->cameras.front();
    constexpr uint32_t kWidth = 37, kHeight = 23;
    const std::unique_ptr<core::Renderer> renderer = core::makeRenderer("path");
    renderer->setWorld(world, {});
    renderer->setView({camera, {kWidth, kHeight}, {}}, core::Start::anew);
    const core::Aovs aovs = renderer->aovs();
    int hits = 0, others = 0;
    for (uint32_t y = 0; y < kHeight; ++y) {
        for (uint32_t x = 0; x < kWidth; ++x) {
            const auto picked = core::pick(*world, camera, {kWidth, kHeight},
                                           {(x + 0.5) / kWidth, (y + 0.5) / kHeight});
            const float depth = *aovs.depth.at(x, y);
            ASSERT_EQ(picked.has_value(), depth > 0) << x << ' ' << y;
            if (!picked) continue;
            ++hits;
            EXPECT_NEAR(picked->distance, static_cast<double>(depth),
                        1e-4 * static_cast<double>(depth))
                << x << ' ' << y;
            others += static_cast<float>(picked->material) != aovs.ids.at(x, y)[1] ? 1 : 0;
            EXPECT_NEAR(glm::distance(picked->position, camera.position), picked->distance, 1e-4);
        }
    }
    EXPECT_GT(hits, 200);
    EXPECT_LE(others, hits / 50) << "only where two triangles share the edge that is hit";
}

TEST(Pick, FindsNothingOutsideOrWithoutTriangles)
{
    const auto world =
        core::makeWorld(core::loadGltf(REKINDLE_SOURCE_DIR "/assets/cornell-diffuse.gltf"));
    core::Camera away = world->cameras.front();
    away.forward = -away.forward;
    away.position = away.position + 1000.0 * away.forward;
    EXPECT_FALSE(core::pick(*world, away, {16, 16}, {0.5, 0.5}).has_value());
    EXPECT_FALSE(core::pick(core::World{}, away, {16, 16}, {0.5, 0.5}).has_value());
}

/// What a mask cuts away is not clicked on, nor what blends by less than a half; with a hierarchy
/// and without.
TEST(Pick, FindsWhatIsBehindHoles)
{
    for (const float alpha : {0.3f, 0.7f}) {
        for (const uint32_t kind : {shared::kMaterialAlphaMask, shared::kMaterialAlphaBlend}) {
            tests::SceneBuilder b;
            core::Material veil = tests::lambert(glm::vec3(0.2f));
            veil.data.flags |= kind;
            veil.data.alpha = alpha;
            veil.data.alphaCutoff = 0.5f;
            const int wall = b.material(tests::lambert(glm::vec3(0.5f)));
            const int before = b.material(veil);
            b.quad({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, before);
            b.quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, wall);
            b.camera({0, 0, 5}, {0, 0, 0}, 0.1);
            const auto world = b.world();
            const auto expected = static_cast<uint32_t>(alpha > 0.5f ? before : wall);
            for (const bool hierarchy : {false, true}) {
                ASSERT_EQ(core::bvhIfMade(*world) != nullptr, hierarchy);
                const auto picked = core::pick(*world, world->cameras.front(), {8, 8}, {0.4, 0.6});
                ASSERT_TRUE(picked.has_value());
                EXPECT_EQ(picked->material, expected) << alpha << ' ' << kind << ' ' << hierarchy;
                core::bvhOf(*world);
            }
        }
    }
}

TEST(Pick, FindsTheSameThroughAHierarchy)
{
    for (const char* name : {"hall", "animated"}) {
        const auto scene =
            core::loadGltf(REKINDLE_SOURCE_DIR "/assets/" + std::string(name) + ".gltf");
        const auto world = core::makeWorld(scene);
        const auto searched = core::makeWorld(scene);  // another world: it has no hierarchy
        ASSERT_GT(core::bvhOf(*world)->nodeCount(), 0u);
        ASSERT_EQ(core::bvhIfMade(*searched), nullptr);
        constexpr uint32_t kWidth = 48, kHeight = 32;
        int hits = 0;
        for (uint32_t y = 0; y < kHeight; ++y) {
            for (uint32_t x = 0; x < kWidth; ++x) {
                const glm::dvec2 place((x + 0.5) / kWidth, (y + 0.5) / kHeight);
                const auto& camera = world->cameras.front();
                const auto a = core::pick(*world, camera, {kWidth, kHeight}, place);
                const auto b = core::pick(*searched, camera, {kWidth, kHeight}, place);
                ASSERT_EQ(a.has_value(), b.has_value()) << x << ' ' << y;
                if (!a) continue;
                ++hits;
                EXPECT_EQ(a->triangle, b->triangle) << x << ' ' << y;
                EXPECT_EQ(a->distance, b->distance) << x << ' ' << y;
                EXPECT_EQ(a->material, b->material) << x << ' ' << y;
            }
        }
        EXPECT_GT(hits, 300) << name;
    }
}

}  // namespace
