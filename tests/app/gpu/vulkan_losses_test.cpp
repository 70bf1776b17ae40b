// Vulkan that fails while it works, on purpose: calls that give errors, work that never ends,
// memory that runs out (V4-V7). Nothing here needs a GPU: the faults are planted in the table of
// functions.
#include <cmath>
#include <ctime>

#include "app/gpu/base/memory.h"
#include "shared/bindings.h"
#include "tests/support/vulkan/leak_on_purpose.h"
#include "tests/support/vulkan/vulkan_fails.h"

namespace {

using namespace tests;
using gpu::Api;

// --- V4: work that does not end

void neverSignal(VulkanFaults& faults)
{
    faults.replace<&Api::WaitForFences>(
        [](auto, VkDevice, uint32_t, const VkFence*, VkBool32, uint64_t) { return VK_TIMEOUT; });
}

TEST_F(VulkanFails, ABusyDeviceIsToldOnceAndWaitedFor)
{
    VulkanFaults faults;
    lieAboutProperties(faults, [](VkPhysicalDeviceProperties& p) {
        p.deviceType = VK_PHYSICAL_DEVICE_TYPE_CPU;  // a graphics card is given up after 20 s
    });
    int waits = 0;
    faults.replace<&Api::WaitForFences>([&waits](auto driver, VkDevice device, uint32_t count,
                                                 const VkFence* fences, VkBool32 all,
                                                 uint64_t timeout) {
        EXPECT_EQ(timeout, 2'000'000'000u);  // never endless
        return ++waits < 25 ? VK_TIMEOUT : driver(device, count, fences, all, timeout);
    });
    std::vector<std::string> notices;
    gpu::DeviceOptions options;
    options.notice = [&notices](const std::string& text) { notices.push_back(text); };
    gpu::Device device(options);
    device.submit([](VkCommandBuffer) {}, "a long piece");
    EXPECT_EQ(waits, 25);
    ASSERT_EQ(notices.size(), 1u);
    expectSays(notices[0], {"GPU busy", "a long piece", "6 s"});
    EXPECT_FALSE(device.lost());
}

/// A device that never answers: it throws after `waits` steps of `step` seconds and is left alone.
/// `busy`: the process works meanwhile.
void expectGivenUp(int expectedWaits, bool software, double step = 2, bool busy = false)
{
    VulkanFaults faults;
    lieAboutProperties(faults, [software](VkPhysicalDeviceProperties& p) {
        p.deviceType =
            software ? VK_PHYSICAL_DEVICE_TYPE_CPU : VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
    });
    if (busy) {
        faults.replace<&Api::WaitForFences>(
            [step](auto, VkDevice, uint32_t, const VkFence*, VkBool32, uint64_t) {
                const std::clock_t until =
                    std::clock() + static_cast<std::clock_t>(step * CLOCKS_PER_SEC);
                while (std::clock() < until) {
                }
                return VK_TIMEOUT;
            });
    } else {
        neverSignal(faults);
    }
    {
        const tests::LeakOnPurpose leak;
        gpu::DeviceOptions options;
        options.waitStep = step;
        options.notice = [](const std::string&) {};
        gpu::Device device(options);
        gpu::Buffer buffer(device, "a test", 1 << 10);
        const std::string text = errorOf(core::ExitCode::deviceLost, [&] {
            device.submit(
                [&](VkCommandBuffer c) {
                    gpu::vk.CmdFillBuffer(c, buffer.get(), 0, VK_WHOLE_SIZE, 1);
                },
                "the work");
        });
        expectSays(text, {"lost", "not answered",
                          std::to_string(std::lround(step * expectedWaits)) + " s", "the work"});
        EXPECT_EQ(faults.calls<&Api::WaitForFences>(), static_cast<uint64_t>(expectedWaits));
        EXPECT_TRUE(device.lost());
    }
    // The work may still run: nothing that it uses may be destroyed, and nothing may wait for it.
    EXPECT_EQ(faults.objects().alive("Buffer"), 1u);
    EXPECT_EQ(faults.objects().alive("Device"), 1u);
    EXPECT_EQ(faults.calls<&Api::DeviceWaitIdle>(), 0u);
}

TEST_F(VulkanFails, ARealDeviceIsGivenUpAfterTwentySeconds)
{
    expectGivenUp(10, false);
}

/// Thirty steps of 2 s.
TEST_F(VulkanFails, ASoftwareDeviceThatWorksIsGivenUpAfterAMinute)
{
    expectGivenUp(30, true, 0.05, true);
}

/// Where others have the processors it is slow, and given up only after ten minutes.
TEST_F(VulkanFails, ASoftwareDeviceThatIsStarvedGetsMoreTime)
{
    expectGivenUp(300, true);
}

TEST_F(VulkanFails, AWaitThatFailsLeavesTheDeviceToItself)
{
    VulkanFaults faults;
    {
        const tests::LeakOnPurpose leak;
        gpu::Device device({});
        faults.fail<&Api::WaitForFences>(VK_ERROR_OUT_OF_HOST_MEMORY);
        expectSays(errorOf(core::ExitCode::deviceLost,
                           [&] { device.submit([](VkCommandBuffer) {}, "the work"); }),
                   {"vkWaitForFences", "VK_ERROR_OUT_OF_HOST_MEMORY", "the work"});
        EXPECT_TRUE(device.lost());
    }
    EXPECT_EQ(faults.objects().alive("Device"), 1u);  // the work may still run
}

// --- V5: lost devices

TEST_F(VulkanFails, TheFirstLossIsTheLastCall)
{
    VulkanFaults faults;
    {
        gpu::Device device({});
        gpu::Buffer buffer(device, "a test", 64);
        faults.fail<&Api::QueueSubmit>(VK_ERROR_DEVICE_LOST);
        expectSays(errorOf(core::ExitCode::deviceLost,
                           [&] { device.submit([](VkCommandBuffer) {}, "tiles 3 to 9"); }),
                   {"lost", "vkQueueSubmit", "VK_ERROR_DEVICE_LOST", "tiles 3 to 9", deviceName()});
        EXPECT_TRUE(device.lost());
        const uint64_t calls = faults.failableCalls();
        std::byte data[64]{};
        for (int i = 0; i < 3; ++i) {
            const std::string text =
                errorOf(core::ExitCode::deviceLost, [&] { device.submit([](VkCommandBuffer) {}); });
            EXPECT_EQ(text.find("tiles"), std::string::npos) << "told again: " << text;
            errorOf(core::ExitCode::deviceLost, [&] { buffer.read(data); });
            errorOf(core::ExitCode::deviceLost, [&] { buffer.write(data); });
            errorOf(core::ExitCode::deviceLost,
                    [&] { gpu::Buffer another(device, "another", 16); });
        }
        EXPECT_EQ(faults.failableCalls(), calls) << "a lost device was asked again";
    }
    EXPECT_EQ(faults.objects().complaints(), "");
    EXPECT_EQ(faults.calls<&Api::DeviceWaitIdle>(), 0u);
}

TEST_F(VulkanFails, ALossWhileRenderingNamesTheWork)
{
    const auto world = asset("cornell-diffuse");
    VulkanFaults faults;
    const auto renderer = gpu::makePathRenderer({});
    renderer->setWorld(world, {});
    for (const core::Kernel kernel : {core::Kernel::megakernel, core::Kernel::wavefront}) {
        core::PathParams params;
        params.kernel = kernel;
        renderer->setView({world->cameras.at(0), {40, 24}, params}, core::Start::anew);
        renderer->advance({.samples = 3}, {});
        if (kernel == core::Kernel::megakernel) continue;
        faults.fail<&Api::WaitForFences>(VK_ERROR_DEVICE_LOST);
        // How many tiles a piece has depends on how fast the device was before.
        expectSays(
            errorOf(core::ExitCode::deviceLost, [&] { renderer->advance({.samples = 1}, {}); }),
            {deviceName(), "vkWaitForFences",
             "bounces of " + std::to_string(world->triangles.size()) + " triangles", "tiles 0 to ",
             " of 15, ", "samples 3 to 3"});
    }
}

/// A loss at every `stride`-th call of a render that returns a VkResult.
void expectLossesAreSeen(uint64_t first, uint64_t stride)
{
    const auto world = asset("cornell-diffuse");
    uint64_t count = 0;
    {
        VulkanFaults faults;
        renderSmall(*gpu::makePathRenderer({}), world);
        count = faults.failableCalls();
        EXPECT_EQ(faults.objects().complaints(), "");
    }
    ASSERT_GT(count, 100u);
    for (uint64_t k = first; k < count; k += stride) {
        VulkanFaults faults;
        faults.failAny(VK_ERROR_DEVICE_LOST, k);
        try {
            renderSmall(*gpu::makePathRenderer({}), world);
            // The last call of all waits for the idle device before its end: nothing comes after
            // it.
            EXPECT_EQ(k, count - 1);
        } catch (const core::Error& error) {
            EXPECT_TRUE(error.code() == core::ExitCode::deviceLost ||
                        error.code() == core::ExitCode::noDevice)
                << k << ": " << error.what();
        }
        EXPECT_EQ(faults.struck(), 1u) << k;
        EXPECT_EQ(faults.objects().complaints(), "") << k;
    }
}

TEST_F(VulkanFails, ALossAtAnyCallEndsInAnErrorAndNoLeak)
{
    expectLossesAreSeen(5, 31);
}

TEST_F(VulkanFails, SlowALossAtEveryCallEndsInAnErrorAndNoLeak)
{
    expectLossesAreSeen(0, 1);
}

// --- V6, V7: memory that runs out

/// Lets what `plan(faults, k)` plants happen for k = first, first + stride, ... while a renderer
/// takes a scene and renders it, until no fault happens any more; then the same renderer must
/// render a smaller scene as if there had been none. Returns how many times something happened.
template <class Plan>
int surviveMemory(uint64_t first, uint64_t stride, const Plan& plan,
                  const std::function<void(const std::string&)>& check)
{
    const auto small = asset("cornell-diffuse");
    // Of the same kernels: most of the time goes to compiling
    auto large = std::make_shared<core::World>(*small);
    large->texels = std::vector<core::Texel>(1 << 16);
    const core::Estimate expected = renderSmall(*gpu::makePathRenderer({}), small);
    int happened = 0;
    for (uint64_t k = first;; k += stride) {
        VulkanFaults faults;
        bool struck = false;
        {
            const auto renderer = gpu::makePathRenderer({});
            plan(faults, k);
            try {
                renderSmall(*renderer, large, 40);
            } catch (const core::Error& error) {
                EXPECT_EQ(error.code(), core::ExitCode::deviceLost) << k;
                check(error.what());
            } catch (const std::bad_alloc&) {
                check("bad_alloc");
            }
            struck = faults.struck() > 0;
            faults.clearPlans();
            if (struck) {
                EXPECT_EQ(renderSmall(*renderer, small).mean.pixels, expected.mean.pixels) << k;
            }
        }
        EXPECT_EQ(faults.objects().complaints(), "") << k;
        if (!struck) return happened;
        ++happened;
    }
}

void expectDeviceMemorySurvived(uint64_t first, uint64_t stride, int least)
{
    const int happened = surviveMemory(
        first, stride,
        [](VulkanFaults& faults, uint64_t k) {
            faults.fail<&Api::AllocateMemory>(VK_ERROR_OUT_OF_DEVICE_MEMORY, k);
        },
        [](const std::string& text) {
            expectSays(text, {"out of device memory", "needs", "MiB beyond the", "in use",
                              deviceName(), "has", "--device cpu"});
        });
    EXPECT_GE(happened, least);
}

TEST_F(VulkanFails, DeviceMemoryMayEndAtAnAllocation)
{
    expectDeviceMemorySurvived(2, 11, 1);
}

TEST_F(VulkanFails, SlowDeviceMemoryMayEndAtEveryAllocation)
{
    expectDeviceMemorySurvived(0, 1, 12);
}

void expectHostMemorySurvived(uint64_t first, uint64_t stride, int least)
{
    const auto plan = [](VulkanFaults& faults, uint64_t k) {
        if (k % 2 == 0) {
            faults.interruptAny([] { throw std::bad_alloc(); }, k / 2);
        } else {
            faults.failAny(VK_ERROR_OUT_OF_HOST_MEMORY, k / 2);
        }
    };
    EXPECT_GE(surviveMemory(first, stride, plan, [](const std::string&) {}), least);
}

TEST_F(VulkanFails, HostMemoryMayEndAtACall)
{
    expectHostMemorySurvived(31, 131, 1);
}

TEST_F(VulkanFails, SlowHostMemoryMayEndAtEveryCall)
{
    expectHostMemorySurvived(0, 1, 100);
}

}  // namespace
