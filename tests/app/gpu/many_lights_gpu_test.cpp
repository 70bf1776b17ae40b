// M14. Rendering with many lights on both devices: of the same bits the same picture, on the
// validation layer's watch; progress, pauses and stops as on the CPU.
#include <gtest/gtest.h>

#include "app/gpu/methods/methods.h"
#include "core/methods/method.h"
#include "tests/support/scenes/asset.h"
#include "tests/support/vulkan/staged_memory.h"
#include "tests/support/vulkan/vulkan_faults.h"

namespace core::many_lights {
namespace {

using tests::asset;

core::Image pictureOf(core::Renderer& renderer, const core::World& world,
                      const ManyLightsParams& params, uint32_t samples = 2)
{
    renderer.setView({world.cameras.at(0), {48, 40}, params}, core::Start::anew);
    renderer.advance({.samples = samples}, {});
    return renderer.read(core::Reading::mean).mean;
}

double largestDifference(const core::Image& a, const core::Image& b)
{
    double mean = 0, largest = 0;
    for (const float x : b.pixels) mean += double(x) / double(b.pixels.size());
    for (size_t i = 0; i < a.pixels.size(); ++i)
        largest = std::max(largest, std::abs(double(a.pixels[i]) - double(b.pixels[i])) /
                                        (std::abs(double(b.pixels[i])) + 0.1 * mean));
    return largest;
}

ManyLightsParams fewOnDevice()
{
    return {.lights = 3000, .clusters = 200, .sliceSize = 200};
}

TEST(ManyLightsGpu, PicturesOfBothDevicesAreTheSame)
{
    const uint64_t before = gpu::validationMessages();
    const auto cpu = core::makeRenderer("manylights");
    const auto vulkan = gpu::makeManyLights({.index = -1, .validation = true});
    for (const char* name : {"cornell-glossy", "cornell-rough", "glass", "hall", "lights", "sky",
                             "textured-box", "furnace-50"}) {
        const auto world = asset(name);
        cpu->setWorld(world, {});
        vulkan->setWorld(world, {});
        ManyLightsParams params = fewOnDevice();
        params.completion.method =
            std::string(name) == "hall" ? CompletionMethod::matching : CompletionMethod::full;
        EXPECT_LT(
            largestDifference(pictureOf(*vulkan, *world, params), pictureOf(*cpu, *world, params)),
            1e-4)
            << name;
    }
    EXPECT_EQ(gpu::validationMessages(), before);
}

/// Numbers in place of bits; many columns, which come in pieces.
TEST(ManyLightsGpu, SoAreThoseOfNumbersAndOfPieces)
{
    const auto world = asset("cornell-glossy");
    const auto cpu = core::makeRenderer("manylights");
    const auto vulkan = gpu::makeManyLights({.index = -1, .validation = true});
    cpu->setWorld(world, {});
    vulkan->setWorld(world, {});
    std::vector<ManyLightsParams> all(4, fewOnDevice());
    all[0].completion.method = CompletionMethod::amc;
    all[1].completion.method = CompletionMethod::matching;
    all[1].completion.residualRate = 0.05f;
    all[2].clusters = 100000;
    all[2].sliceSize = 4000;
    all[3].clusters = 1;
    all[3].lights = 1;
    for (size_t i = 0; i < all.size(); ++i)
        EXPECT_LT(largestDifference(pictureOf(*vulkan, *world, all[i], 1),
                                    pictureOf(*cpu, *world, all[i], 1)),
                  2e-4)
            << i;
}

/// Lights with extent. Their samples are the same but where rounding decides about one: where a
/// frame's sense hangs on the sign of a component that is nearly zero (as in the asset glass) the
/// devices draw others, and differ by noise.
TEST(ManyLightsGpu, SoAreThoseOfLightsWithExtent)
{
    const auto world = asset("cornell-glossy");
    const auto cpu = core::makeRenderer("manylights");
    const auto vulkan = gpu::makeManyLights({.index = -1, .validation = true});
    cpu->setWorld(world, {});
    vulkan->setWorld(world, {});
    core::Image point;
    for (const LightShape shape : {LightShape::point, LightShape::sphere, LightShape::disc}) {
        ManyLightsParams params = fewOnDevice();
        params.clusters = 15;
        params.lightShape = shape;
        const core::Image a = pictureOf(*vulkan, *world, params, 1),
                          b = pictureOf(*cpu, *world, params, 1);
        double mean = 0, difference = 0, fromPoint = 0;
        if (shape == LightShape::point) point = b;
        for (size_t i = 0; i < a.pixels.size(); ++i) {
            mean += double(b.pixels[i]);
            difference += std::abs(double(a.pixels[i]) - double(b.pixels[i]));
            fromPoint += std::abs(double(point.pixels[i]) - double(b.pixels[i]));
        }
        EXPECT_LT(difference, 1e-4 * mean) << int(shape);
        if (shape != LightShape::point) {
            EXPECT_GT(fromPoint, 1e-2 * mean) << int(shape);
        }
    }
}

/// Memory that is not mapped goes through copies.
TEST(ManyLightsGpu, StagedMemoryGivesTheSamePicture)
{
    const auto world = asset("cornell-glossy");
    core::Image mapped;
    {
        const auto vulkan = gpu::makeManyLights({});
        vulkan->setWorld(world, {});
        mapped = pictureOf(*vulkan, *world, fewOnDevice());
    }
    tests::VulkanFaults faults;
    const tests::StagedMemory staged(faults);
    const auto vulkan = gpu::makeManyLights({});
    vulkan->setWorld(world, {});
    EXPECT_EQ(pictureOf(*vulkan, *world, fewOnDevice()).pixels, mapped.pixels);
}

/// Another pose, other materials' features, and back.
TEST(ManyLightsGpu, WorldsMayChange)
{
    const auto cpu = core::makeRenderer("manylights");
    const auto vulkan = gpu::makeManyLights({});
    std::vector<std::shared_ptr<const core::World>> worlds{asset("animated")};
    worlds.push_back(core::poseWorld(worlds[0], 0.7));
    worlds.push_back(asset("glass"));
    worlds.push_back(worlds[0]);
    for (const auto& world : worlds) {
        cpu->setWorld(world, {});
        vulkan->setWorld(world, {});
        EXPECT_LT(largestDifference(pictureOf(*vulkan, *world, fewOnDevice()),
                                    pictureOf(*cpu, *world, fewOnDevice())),
                  1e-4);
    }
}

TEST(ManyLightsGpu, ItsStatisticsNameTheDevice)
{
    const auto world = asset("cornell-diffuse");
    const auto vulkan = gpu::makeManyLights({});
    vulkan->setWorld(world, {});
    pictureOf(*vulkan, *world, fewOnDevice());
    const core::RenderStats stats = vulkan->stats();
    EXPECT_NE(stats.device, "cpu");
    EXPECT_NE(stats.driver, "Embree");
    EXPECT_GT(stats.peakDeviceBytes, 1000u);
    for (const core::StatsDetail& d : stats.details)
        if (d.name == "device_seconds_shading") {
            EXPECT_GT(std::get<double>(d.value), 0);
        }
}

/// A lost device is told as such, and so is that a new one is needed.
TEST(ManyLightsGpu, ALostDeviceIsTold)
{
    tests::VulkanFaults faults;
    const auto world = asset("cornell-diffuse");
    const auto vulkan = gpu::makeManyLights({});
    vulkan->setWorld(world, {});
    vulkan->setView({world->cameras.at(0), {48, 40}, fewOnDevice()}, core::Start::anew);
    faults.fail<&gpu::Api::QueueSubmit>(VK_ERROR_DEVICE_LOST);
    EXPECT_THROW(vulkan->advance({.samples = 1}, {}), core::Error);
    EXPECT_THROW(vulkan->advance({.samples = 1}, {}), core::Error);
}

}  // namespace
}  // namespace core::many_lights
