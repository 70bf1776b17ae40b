// Poses on the GPU: what moves is uploaded and nothing else, and pictures are those of worlds that
// were made at their time.
#include <gtest/gtest.h>

#include "app/gpu/methods/path.h"
#include "app/gpu/rays.h"
#include "core/gltf/gltf.h"
#include "core/methods/method.h"
#include "tests/support/scenes/asset.h"
#include "tests/support/scenes/deforming_scenes.h"
#include "tests/support/statistics/compare_films.h"

namespace {

using namespace tests;

class GpuPose : public testing::Test {
protected:
    void TearDown() override { EXPECT_EQ(gpu::validationMessages(), messages_); }

private:
    const uint64_t messages_ = gpu::validationMessages();
};

/// A pose writes the moving triangles with their vertices' attributes and the nodes above them.
TEST_F(GpuPose, UploadsWhatMoves)
{
    gpu::Device device({.index = -1, .validation = true});
    const gpu::SharedLayouts layouts(device);
    auto scene = std::make_shared<core::Scene>(
        *core::loadGltf(REKINDLE_SOURCE_DIR "/assets/textured-box.gltf"));
    int moved = -1;
    for (size_t n = 0; n < scene->nodes.size() && moved < 0; ++n)
        moved = scene->nodes[n].meshes.empty() ? -1 : static_cast<int>(n);
    animate(*scene, {channelOf(moved, core::AnimationChannel::Path::rotation,
                               {{0, 0, 0, 1}, {0, 0.7071068f, 0, 0.7071068f}})});
    const auto world = core::makeWorld(scene);
    gpu::GpuScene onDevice(device, layouts, *world, {});
    const uint64_t loaded = device.writtenBytes;
    EXPECT_GE(loaded, world->texels.size() * sizeof(core::Texel));
    const auto turned = core::poseWorld(world, 0.5);
    onDevice.setWorld(*turned, {});
    const uint64_t written = device.writtenBytes - loaded;
    const uint64_t triangles = world->movingTriangles.size();
    EXPECT_GE(written, triangles * 48);
    // Nodes: at most one per triangle, a quarter of room, the root; emitters and their CDF.
    EXPECT_LE(written, triangles * (48 + 40) + 64 + world->movingVertices.size() * 16 +
                           world->emitters.size() * 68 + 4);
    EXPECT_LT(written, world->texels.size() * sizeof(core::Texel));
    onDevice.setWorld(*core::poseWorld(turned, 0.5), {});
    EXPECT_EQ(device.writtenBytes - loaded, written) << "the same pose again costs nothing";
}

/// Also across a pose with other triangles. The trees differ (one is refitted, and grids are laid
/// over the pose that came first), the triangles that rays meet do not.
TEST_F(GpuPose, PicturesAfterPosesAreThoseOfFreshWorlds)
{
    const auto renderer = gpu::makePathRenderer({.index = -1, .validation = true});
    const auto fresh = gpu::makePathRenderer({.index = -1, .validation = true});
    for (const auto& start :
         {asset("animated"), deformingRoom().world(), vanishingRoom().world()}) {
        std::shared_ptr<const core::World> world = start;
        core::Estimate before;
        for (const double time : {0.0, 0.7, 1.6, 0.7}) {
            SCOPED_TRACE(time);
            world = core::poseWorld(world, time);
            const core::Estimate film = filmOf(*renderer, world);
            const core::Estimate expected =
                filmOf(*fresh, core::makeWorld(start->scene, time, 0, start->placement));
            ASSERT_EQ(film.mean.pixels.size(), expected.mean.pixels.size());
            size_t others = 0;
            for (size_t p = 0; p < film.mean.pixels.size(); ++p)
                others += film.mean.pixels[p] != expected.mean.pixels[p];
            EXPECT_EQ(others, 0u) << "pixels";
            EXPECT_FALSE(film.mean.pixels == before.mean.pixels) << "it moves";
            before = film;
        }
    }
}

/// T38: a frame of meshes that deform, light by Welch's test, first hits pixel by pixel.
TEST_F(GpuPose, DeformedFramesAgreeWithTheCpu)
{
    const auto world = core::poseWorld(deformingRoom().world(), 0.7);
    const std::unique_ptr<core::Renderer> renderers[2] = {
        gpu::makePathRenderer({.index = -1, .validation = true}), core::makeRenderer("path")};
    core::Estimate films[2];
    core::Aovs hits[2];
    for (uint32_t i = 0; i < 2; ++i) {
        core::PathParams params;
        params.sampler = core::SamplerKind::independent;
        params.seed = 1 + i;
        params.maxDepth = 6;
        renderers[i]->setWorld(world, {});
        renderers[i]->setView({world->cameras.front(), {64, 64}, params}, core::Start::anew);
        renderers[i]->advance({.samples = 300}, {});
        films[i] = renderers[i]->read(core::Reading::everything);
        EXPECT_TRUE(films[i].counters.clean());
        renderers[i]->setView({world->cameras.front(), {64, 64}, {}}, core::Start::anew);
        hits[i] = renderers[i]->aovs();
    }
    const FilmComparison c = compareFilms(films[0], films[1]);
    EXPECT_TRUE(c.agree()) << c.describe();
    EXPECT_LT(c.detectable, 0.02) << c.describe();
    size_t others = 0, moving = 0;
    for (size_t p = 0; p < 64 * 64; ++p) {
        const auto triangle = static_cast<uint32_t>(hits[1].ids.pixels[3 * p]);
        const float depth = hits[1].depth.pixels[p];
        bool same = std::abs(hits[0].depth.pixels[p] - depth) <= 1e-5f * depth;
        // On an edge, where depths are equal, either triangle may be named.
        if (hits[0].ids.pixels[3 * p] == hits[1].ids.pixels[3 * p])
            for (size_t k = 3 * p; k < 3 * p + 3; ++k)
                same =
                    same && std::abs(hits[0].normal.pixels[k] - hits[1].normal.pixels[k]) < 1e-3f;
        if (!same) ++others;
        if (triangle >= world->movingTriangles.begin && triangle < world->movingTriangles.end)
            ++moving;
    }
    EXPECT_LE(others, 4u);
    EXPECT_GT(moving, 200u);
}

}  // namespace
