// The validation layer with every check that finds something here switched on (V1): core,
// synchronization, and synchronization between submissions, over all assets and all methods, with
// scenes loaded and released repeatedly.
#include <gtest/gtest.h>

#include <cstdlib>
#include <span>

#include "app/gpu/base/memory.h"
#include "app/gpu/methods/methods.h"
#include "app/gpu/methods/path.h"
#include "core/methods/method.h"
#include "tests/support/scenes/asset.h"
#include "tests/support/vulkan/vulkan_faults.h"

namespace {

using tests::asset;

/// Checks between submissions are off unless they are asked for by name; the separator is a colon
/// on Linux, any other makes the layer ignore the setting silently.
class ThoroughLayer {
public:
    ThoroughLayer()
    {
        setenv("VK_LAYER_ENABLES",
               "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT:"
               "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT",
               1);
    }
    ~ThoroughLayer() { unsetenv("VK_LAYER_ENABLES"); }
    ThoroughLayer(const ThoroughLayer&) = delete;
    ThoroughLayer& operator=(const ThoroughLayer&) = delete;
};

const char* const kFewAssets[] = {"textured-box", "lights"};
const char* const kCleanAssets[] = {"animated",
                                    "cornell-diffuse",
                                    "cornell-glossy",
                                    "cornell-moderate",
                                    "cornell-rough",
                                    "door-ajar",
                                    "furnace-50",
                                    "furnace-80",
                                    "furnace-sphere",
                                    "glass",
                                    "hall",
                                    "lights",
                                    "sky",
                                    "textured-box"};

void renderTwice(core::Renderer& renderer, const std::shared_ptr<const core::World>& world,
                 core::Kernel kernel, uint32_t size)
{
    renderer.setWorld(world, {});
    core::PathParams params;
    params.kernel = kernel;
    params.maxDepth = 20;
    renderer.setView({world->cameras.at(0), {size, size}, params}, core::Start::anew);
    renderer.advance({.samples = 2}, {});
    renderer.advance({.samples = 1}, {});
    const core::Estimate film = renderer.read(core::Reading::everything);
    const core::Image mean = renderer.read(core::Reading::mean).mean;
    renderer.aovs();
}

/// Two submissions that write one buffer with neither a barrier nor a wait in between.
void submitHazard(gpu::Device& device, VkBuffer buffer)
{
    VkCommandPoolCreateInfo pool{};
    pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    pool.queueFamilyIndex = device.queueFamily();
    VkCommandPool object;
    VK_CHECK(gpu::vk.CreateCommandPool(device.get(), &pool, nullptr, &object));
    const gpu::Handle<VkCommandPool, &gpu::Api::DestroyCommandPool> owner(device.get(), object);
    VkCommandBufferAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    allocate.commandPool = object;
    allocate.commandBufferCount = 2;
    VkCommandBuffer commands[2];
    VK_CHECK(gpu::vk.AllocateCommandBuffers(device.get(), &allocate, commands));
    for (const VkCommandBuffer& c : commands) {
        VkCommandBufferBeginInfo begin{};
        begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
        VK_CHECK(gpu::vk.BeginCommandBuffer(c, &begin));
        gpu::vk.CmdFillBuffer(c, buffer, 0, VK_WHOLE_SIZE, 0);
        VK_CHECK(gpu::vk.EndCommandBuffer(c));
        VkSubmitInfo submit{};
        submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
        submit.commandBufferCount = 1;
        submit.pCommandBuffers = &c;
        VK_CHECK(gpu::vk.QueueSubmit(device.queue(), 1, &submit, VK_NULL_HANDLE));
    }
    VK_CHECK(gpu::vk.DeviceWaitIdle(device.get()));
}

TEST(VulkanClean, TheLayerIsAwakeBetweenSubmissions)
{
    // A process of its own: its messages are not a failure here
    testing::GTEST_FLAG(death_test_style) = "threadsafe";
    EXPECT_EXIT(
        {
            const ThoroughLayer layer;
            gpu::Device device({.index = -1, .validation = true});
            const gpu::Buffer buffer(device, "a test", 1024);
            submitHazard(device, buffer.get());
            std::_Exit(gpu::validationMessages() > 0 ? 7 : 0);
        },
        testing::ExitedWithCode(7), "WRITE.AFTER.WRITE");
}

void expectClean(std::span<const char* const> names)
{
    const ThoroughLayer layer;
    const uint64_t before = gpu::validationMessages();
    tests::VulkanFaults faults;
    {
        const auto renderer = gpu::makePathRenderer({.index = -1, .validation = true});
        core::Kernel kernel = core::Kernel::wavefront;
        for (const char* name : names) {
            renderTwice(*renderer, asset(name), kernel, 16);
            kernel = kernel == core::Kernel::wavefront ? core::Kernel::megakernel
                                                       : core::Kernel::wavefront;
        }
    }
    EXPECT_EQ(gpu::validationMessages(), before);
    EXPECT_EQ(faults.objects().complaints(), "");
}

TEST(VulkanClean, NoMessageForSomeAssets)
{
    expectClean(kFewAssets);
}

/// Two views of each method, the second one moved.
TEST(VulkanClean, SlowNoMessageForAnyMethod)
{
    const ThoroughLayer layer;
    const uint64_t before = gpu::validationMessages();
    tests::VulkanFaults faults;
    const auto world = asset("textured-box");
    for (const gpu::Method& method : gpu::methods()) {
        if (method.make == nullptr) continue;
        const auto renderer = method.make({.index = -1, .validation = true});
        renderer->setWorld(world, {});
        core::Camera camera = world->cameras.at(0);
        for (const core::Start start : {core::Start::anew, core::Start::moved}) {
            const core::AnyParams& params = core::findMethod(method.id)->defaults;
            renderer->setView({camera, {16, 12}, params}, start);
            for (int i = 0; i < 2; ++i) renderer->advance({.samples = 1}, {});
            renderer->read(core::Reading::everything);
            renderer->aovs();
            camera.position.x += 0.01;
        }
        EXPECT_EQ(gpu::validationMessages(), before) << method.id;
    }
    EXPECT_EQ(faults.objects().complaints(), "");
}

TEST(VulkanClean, SlowNoMessageForAnyAsset)
{
    expectClean(kCleanAssets);
}

TEST(VulkanClean, SlowScenesComeAndGoTwentyTimes)
{
    const ThoroughLayer layer;
    const uint64_t before = gpu::validationMessages();
    tests::VulkanFaults faults;
    {
        const auto renderer = gpu::makePathRenderer({.index = -1, .validation = true});
        size_t after = 0;
        for (uint32_t round = 0; round < 20; ++round) {
            for (const char* name : kCleanAssets) {
                renderTwice(*renderer, asset(name),
                            round % 2 == 0 ? core::Kernel::automatic : core::Kernel::megakernel,
                            16 + 8 * (round % 3));
            }
            const size_t alive =
                faults.objects().alive("Buffer") + faults.objects().alive("Memory");
            if (round == 2) after = alive;
            if (round >= 2) {
                EXPECT_EQ(alive, after) << "round " << round;
            }
        }
    }
    EXPECT_EQ(gpu::validationMessages(), before);
    EXPECT_EQ(faults.objects().complaints(), "");
}

}  // namespace
