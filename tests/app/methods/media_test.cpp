// Light inside solids that absorb (KHR_materials_volume), in every method that renders light, on
// every device: whatever a way through a solid ends on, and connections that stay within.
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/methods/every_picture.h"
#include "tests/support/methods/reuse_flights.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;

/// A solid that only absorbs; with an `ior` other than one it also refracts.
core::Material tinted(float absorption, float ior = 1)
{
    core::Material material = glossy(glm::vec3(1), 0, 0);
    material.data.specular = ior == 1 ? 0 : 1;
    material.data.ior = ior;
    material.data.transmission = 1;
    material.data.absorption = glm::vec3(absorption);
    material.data.flags = shared::kMaterialVolume;
    return material;
}

TEST(Media, WhatIsInsideIsTinted)
{
    SceneBuilder b;
    b.box({-1, -1, -0.5f}, {1, 1, 0.4f}, b.material(tinted(2)), false);
    b.quad({-0.8f, -0.8f, 0}, {1.6f, 0, 0}, {0, 1.6f, 0}, b.material(emitter(glm::vec3(3))));
    b.camera({0, 0, 5}, {0, 0, 0}, 0.05);
    forEachPicture(b.world(), {8, 8}, 4, [](const PictureTaken& picture) {
        for (const float value : picture.estimate.mean.pixels)
            ASSERT_NEAR(value, 3 * std::exp(-0.8), 0.002) << picture.where;
    });
}

/// A mesh that encloses nothing has no far side: what is infinitely far stays as bright as it is.
TEST(Media, TheSkyBehindAnOpenMeshIsNot)
{
    SceneBuilder b;
    b.quad({-9, -9, 0}, {18, 0, 0}, {0, 18, 0}, b.material(tinted(2)));
    b.constantEnvironment(glm::vec3(0.25f));
    b.camera({0, 0, 5}, {0, 0, 0}, 0.5);
    forEachPicture(b.world(), {8, 8}, 4, [](const PictureTaken& picture) {
        for (const float value : picture.estimate.mean.pixels)
            ASSERT_NEAR(value, 0.25, 1e-4) << picture.where;
    });
}

/// A floor and a small lamp above it in one solid.
TEST(Media, ConnectionsWithinAreDimmed)
{
    constexpr float kAbsorption = 0.7f, kHeight = 1.5f, kSide = 0.05f, kAlbedo = 0.5f;
    SceneBuilder b;
    b.box({-2, -0.5f, -2}, {2, 3, 2}, b.material(tinted(kAbsorption)), false);
    b.quad({-1.5f, 0, 1.5f}, {3, 0, 0}, {0, 0, -3}, b.material(lambert(glm::vec3(kAlbedo))));
    b.quad({-kSide / 2, kHeight, -kSide / 2}, {kSide, 0, 0}, {0, 0, kSide},
           b.material(emitter(glm::vec3(1000))));
    b.camera({1, 1, 6}, {0, 0, 0}, 0.004);
    // The camera looks at the foot of the lamp; the part of its way beyond the face z = 2.
    const double inside = std::sqrt(38.0) * 2 / 6;
    const double expected = double(kAlbedo) / 3.14159265 * 1000 * double(kSide * kSide) /
                            double(kHeight * kHeight) *
                            std::exp(-double(kAbsorption) * (double(kHeight) + inside));
    forEachPicture(b.world(), {8, 8}, 16, [&](const PictureTaken& picture) {
        EXPECT_NEAR(meanOf(picture.estimate.mean) / expected, 1, 0.01) << picture.where;
    });
}

/// A volume means nothing without transmission, nor in a metal: its back is as bright as without,
/// whether or not there are solids elsewhere.
TEST(Media, WhatLetsNoLightThroughIsNoSolid)
{
    for (const bool others : {false, true}) {
        for (const bool metal : {false, true}) {
            if (metal && !others) continue;
            core::Material panel = emitter(glm::vec3(3), glm::vec3(0), true);
            panel.data.flags |= shared::kMaterialVolume;
            panel.data.absorption = glm::vec3(2);
            panel.data.transmission = metal ? 1 : 0;
            panel.data.metallic = metal ? 1 : 0;
            SceneBuilder b;
            b.quad({-1, -1, 0}, {0, 2, 0}, {2, 0, 0}, b.material(panel));  // its back is seen
            if (others) b.box({4, 0, 0}, {5, 1, 1}, b.material(tinted(2)), false);
            b.camera({0, 0, 5}, {0, 0, 0}, 0.05);
            const auto world = b.world();
            for (const app::DeviceKind device : {app::DeviceKind::cpu, app::DeviceKind::vulkan}) {
                if (!app::whyNot("path", device).empty()) continue;
                core::Renderer& renderer = sharedRenderer("path", device);
                renderer.setWorld(world, {});
                renderer.setView({world->cameras.front(), {8, 8}, core::PathParams{}},
                                 core::Start::anew);
                renderer.advance({.samples = 4}, {});
                for (const float value : renderer.read(core::Reading::everything).mean.pixels)
                    ASSERT_NEAR(value, 3, 0.002)
                        << core::enumName(device) << (metal ? ", metal" : "")
                        << (others ? ", solids beside" : "");
            }
        }
    }
}

/// A bowl of glass-clear dye with a block in it, under a white sky.
SceneBuilder bowl()
{
    SceneBuilder b;
    b.box({-1, -1, -1}, {1, 1, 1}, b.material(tinted(0.8f, 1.3f)), false);
    b.box({-0.6f, -0.9f, -0.5f}, {0.4f, 0.2f, 0.5f}, b.material(lambert({0.8f, 0.7f, 0.6f})),
          false);
    b.quad({-4, -1.2f, 4}, {8, 0, 0}, {0, 0, -8}, b.material(lambert(glm::vec3(0.5f))));
    b.constantEnvironment(glm::vec3(1));
    b.camera({0.5, 1.2, 3.45}, {0, 0, 0}, 0.6);
    return b;
}

TEST(Media, StrategiesAndMethodsAgree)
{
    const auto world = bowl().world();
    const auto picture = [&](core::Strategy strategy) {
        return estimate(render(world, 24, 24, 256, independentParams(strategy, 12)));
    };
    const PictureMean truth = picture(core::Strategy::mis);
    EXPECT_LT(std::abs(score(picture(core::Strategy::bsdf), truth)), kScore);
    EXPECT_LT(detectable(truth, truth.mean), 0.02);
    forEachPicture(world, {24, 24}, 64, [&](const PictureTaken& taken) {
        EXPECT_NEAR(meanOf(taken.estimate.mean) / truth.mean, 1, 0.02) << taken.where;
    });
}

/// Surfaces of a rough solid are lit from within, too.
TEST(Media, RoughSolidsAreLitThroughWhatIsInThem)
{
    SceneBuilder b;
    core::Material rough = tinted(1.5f, 1.3f);
    rough.data.roughness = 0.6f;
    b.box({-1, -1, -1}, {1, 1, 1}, b.material(rough), false);
    b.box({-0.6f, -0.9f, -0.5f}, {0.4f, 0.2f, 0.5f}, b.material(lambert({0.8f, 0.7f, 0.6f})),
          false);
    b.quad({-0.3f, 0.9f, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}, b.material(emitter(glm::vec3(10))));
    b.camera({0.5, 1.2, 3.45}, {0, 0, 0}, 0.6);
    const PictureMean truth =
        estimate(render(b.world(), 24, 24, 512, independentParams(core::Strategy::mis, 8)));
    EXPECT_LT(detectable(truth, truth.mean), 0.05);
    forEachPicture(b.world(), {24, 24}, 128, [&](const PictureTaken& taken) {
        EXPECT_NEAR(meanOf(taken.estimate.mean) / truth.mean, 1, 0.04) << taken.where;
    });
}

class MovedMedia : public ReuseFlights {};

/// Samples that are kept in a solid stay dimmed by as much as new ones.
TEST_P(MovedMedia, AMoveLeavesTheMeanAsItIs)
{
    constexpr uint32_t kFlights = 24, kFrames = 6;
    world_ = bowl().world();
    renderer_->setWorld(world_, {});
    size_ = {24, 24};
    const double expected = meanOf(reference(1024).mean);
    for (const core::ReuseBias bias : {core::ReuseBias::fast, core::ReuseBias::unbiased}) {
        Moments means;
        for (uint32_t flight = 0; flight < kFlights; ++flight) {
            ReuseParams params = with(ReuseStrategy::ra, 700 + flight);
            params.bias = bias;
            means.add(meanOf(fly(params, kFrames, 1).mean));
        }
        const double error = std::sqrt(means.varianceOfMean());
        EXPECT_LT(std::abs(means.mean() - expected), 0.005 * expected + kScore * error)
            << core::enumName(bias);
        EXPECT_LT(error, 0.01 * expected) << "underpowered";
    }
}

INSTANTIATE_TEST_SUITE_P(Device, MovedMedia,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());

}  // namespace
