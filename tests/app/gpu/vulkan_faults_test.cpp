// Vulkan that fails, on purpose: calls that give errors, devices that lie, work that never ends
// (V4-V7, V12, V13, V16, V18). Nothing here needs a GPU: the faults are
// planted in the table of functions.
#include <numeric>

#include <gtest/gtest.h>

#include "app/gpu/base/memory.h"
#include "app/gpu/methods/path.h"
#include "core/gltf/gltf.h"
#include "shared/bindings.h"
#include "tests/support/leak_on_purpose.h"
#include "tests/support/vulkan_faults.h"

namespace {

using gpu::Api;
using tests::VulkanFaults;

std::shared_ptr<const core::World> asset(const std::string& name)
{
    return core::makeWorld(
        core::loadGltf(std::string(REKINDLE_SOURCE_DIR "/assets/") + name + ".gltf"));
}

/// The device that is chosen when nothing fails.
const std::string& deviceName()
{
    static const std::string name = [] {
        for (const gpu::DeviceInfo& info : gpu::listDevices()) {
            if (info.missing.empty()) return info.name;
        }
        return std::string("no device");
    }();
    return name;
}

class VulkanFails : public testing::Test {
protected:
    static void SetUpTestSuite() { deviceName(); }  // before anything is planted
};

/// What the action's core::Error says, which must carry `code`; fails the test when there is none.
template <class F> std::string errorOf(core::ExitCode code, F action)
{
    try {
        action();
    } catch (const core::Error& error) {
        EXPECT_EQ(error.code(), code) << error.what();
        return error.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return "";
}

void expectSays(const std::string& text, std::initializer_list<std::string> parts)
{
    for (const std::string& part : parts)
        EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' in: " << text;
}

core::Estimate renderSmall(core::Renderer& renderer,
                           const std::shared_ptr<const core::World>& world, uint32_t size = 24)
{
    renderer.setWorld(world, {});
    renderer.setView({world->cameras.at(0), {size, size}, {}}, core::Start::anew);
    renderer.advance({.samples = 1}, {});
    const core::Estimate film = renderer.read(core::Reading::everything);
    return film;
}

double brightness(const core::Estimate& film)
{
    return std::accumulate(film.mean.pixels.begin(), film.mean.pixels.end(), 0.0);
}

// --- V12, V13, V18: devices that are not there, too old or too small

TEST_F(VulkanFails, NoDriverIsToldWithWhatToDo)
{
    VulkanFaults faults;
    faults.fail<&Api::CreateInstance>(VK_ERROR_INCOMPATIBLE_DRIVER, 0, 2);
    expectSays(errorOf(core::ExitCode::noDevice, [] { gpu::Device device({}); }),
               {"no Vulkan driver", "VK_ERROR_INCOMPATIBLE_DRIVER", "mesa-vulkan-drivers",
                "--device cpu"});
    expectSays(errorOf(core::ExitCode::noDevice, [] { gpu::listDevices(); }), {"no Vulkan driver"});
    EXPECT_EQ(faults.objects().complaints(), "");
}

TEST_F(VulkanFails, NoDeviceIsTold)
{
    VulkanFaults faults;
    faults.replace<&Api::EnumeratePhysicalDevices>(
        [](auto, VkInstance, uint32_t* count, VkPhysicalDevice*) {
            *count = 0;
            return VK_SUCCESS;
        });
    expectSays(errorOf(core::ExitCode::noDevice, [] { gpu::Device device({}); }),
               {"no suitable", "none", "--device cpu"});
    EXPECT_TRUE(gpu::listDevices().empty());
    EXPECT_EQ(faults.objects().complaints(), "");
}

/// Plants a lie about the device's properties.
template <class F> void lieAboutProperties(VulkanFaults& faults, F lie)
{
    faults.replace<&Api::GetPhysicalDeviceProperties2>(
        [lie](auto driver, VkPhysicalDevice physical, VkPhysicalDeviceProperties2* properties) {
            driver(physical, properties);
            lie(properties->properties);
        });
}

void expectMissing(VulkanFaults& faults, std::initializer_list<std::string> parts)
{
    const std::string text = errorOf(core::ExitCode::noDevice, [] { gpu::Device device({}); });
    expectSays(text, {"no suitable Vulkan device", "lacks", deviceName(), "--device cpu"});
    expectSays(text, parts);
    const std::vector<gpu::DeviceInfo> list = gpu::listDevices();
    ASSERT_FALSE(list.empty());
    ASSERT_FALSE(list[0].missing.empty());
    EXPECT_EQ(faults.objects().complaints(), "");
}

TEST_F(VulkanFails, AnOldDeviceSaysItsVersion)
{
    VulkanFaults faults;
    lieAboutProperties(faults, [](VkPhysicalDeviceProperties& p) {
        p.apiVersion = VK_MAKE_API_VERSION(0, 1, 1, 77);
    });
    expectMissing(faults, {"Vulkan 1.3", "1.1.77"});
}

TEST_F(VulkanFails, ADeviceWithoutComputeIsRefused)
{
    VulkanFaults faults;
    faults.replace<&Api::GetPhysicalDeviceQueueFamilyProperties>(
        [](auto driver, VkPhysicalDevice physical, uint32_t* count,
           VkQueueFamilyProperties* families) {
            driver(physical, count, families);
            if (families == nullptr) return;
            for (uint32_t i = 0; i < *count; ++i)
                families[i].queueFlags &= ~VkQueueFlags(VK_QUEUE_COMPUTE_BIT);
        });
    expectMissing(faults, {"a compute queue"});
}

TEST_F(VulkanFails, EachMissingFeatureIsNamed)
{
    VulkanFaults faults;
    faults.replace<&Api::GetPhysicalDeviceFeatures2>([](auto driver, VkPhysicalDevice physical,
                                                        VkPhysicalDeviceFeatures2* features) {
        driver(physical, features);
        for (auto* link = static_cast<VkBaseOutStructure*>(features->pNext); link != nullptr;
             link = link->pNext) {
            if (link->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES) {
                reinterpret_cast<VkPhysicalDeviceVulkan12Features*>(link)->scalarBlockLayout =
                    VK_FALSE;
            }
            if (link->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES) {
                reinterpret_cast<VkPhysicalDeviceVulkan13Features*>(link)->maintenance4 = VK_FALSE;
            }
        }
    });
    expectMissing(faults, {"scalarBlockLayout", "maintenance4"});
}

TEST_F(VulkanFails, EachLimitThatIsTooLowIsToldInNumbers)
{
    struct Case {
        const char* name;
        uint32_t value;
        void (*lower)(VkPhysicalDeviceLimits&, uint32_t);
    };
    const Case cases[] = {
        {"maxComputeWorkGroupInvocations", 32,
         [](auto& l, uint32_t v) { l.maxComputeWorkGroupInvocations = v; }},
        {"maxComputeWorkGroupSize", 63,
         [](auto& l, uint32_t v) { l.maxComputeWorkGroupSize[0] = v; }},
        {"maxComputeWorkGroupCount", 100,
         [](auto& l, uint32_t v) { l.maxComputeWorkGroupCount[0] = v; }},
        {"maxPushConstantsSize", 64, [](auto& l, uint32_t v) { l.maxPushConstantsSize = v; }},
        {"maxUniformBufferRange", 100, [](auto& l, uint32_t v) { l.maxUniformBufferRange = v; }},
        {"maxPerStageDescriptorStorageBuffers", 4,
         [](auto& l, uint32_t v) { l.maxPerStageDescriptorStorageBuffers = v; }},
        {"maxPerStageDescriptorSampledImages", 8,
         [](auto& l, uint32_t v) { l.maxPerStageDescriptorSampledImages = v; }},
        {"maxPerStageResources", 16, [](auto& l, uint32_t v) { l.maxPerStageResources = v; }},
        {"maxTexelBufferElements", 65536,
         [](auto& l, uint32_t v) { l.maxTexelBufferElements = v; }},
        {"maxStorageBufferRange", 65536, [](auto& l, uint32_t v) { l.maxStorageBufferRange = v; }},
    };
    for (const Case& c : cases) {
        VulkanFaults faults;
        lieAboutProperties(faults,
                           [&c](VkPhysicalDeviceProperties& p) { c.lower(p.limits, c.value); });
        const std::string has = "it has " + std::to_string(c.value);
        expectMissing(faults, {c.name, has});
    }
}

TEST_F(VulkanFails, ADeviceThatDoesNotOpenIsTold)
{
    VulkanFaults faults;
    faults.fail<&Api::CreateDevice>(VK_ERROR_INITIALIZATION_FAILED);
    expectSays(errorOf(core::ExitCode::noDevice, [] { gpu::Device device({}); }),
               {deviceName(), "does not open", "VK_ERROR_INITIALIZATION_FAILED", "devices"});
    EXPECT_EQ(faults.objects().complaints(), "");
}

TEST_F(VulkanFails, ARealDeviceGoesBeforeSoftwareAndTheUnsuitable)
{
    // Three devices in place of one: their handles are made up, every query about them goes to the
    // real one.
    static std::vector<VkPhysicalDevice> handles;
    static VkPhysicalDevice real = VK_NULL_HANDLE;
    handles.clear();
    VulkanFaults faults;
    static int storage[3];
    for (int& s : storage) handles.push_back(reinterpret_cast<VkPhysicalDevice>(&s));
    faults.replace<&Api::EnumeratePhysicalDevices>(
        [](auto driver, VkInstance instance, uint32_t* count, VkPhysicalDevice* out) {
            uint32_t one = 1;
            driver(instance, &one, &real);
            if (out != nullptr) std::copy(handles.begin(), handles.end(), out);
            *count = 3;
            return VK_SUCCESS;
        });
    faults.replace<&Api::GetPhysicalDeviceProperties2>(
        [](auto driver, VkPhysicalDevice p, VkPhysicalDeviceProperties2* out) {
            driver(real, out);
            const auto index = std::find(handles.begin(), handles.end(), p) - handles.begin();
            const char* names[] = {"software", "too old", "real"};
            std::snprintf(out->properties.deviceName, sizeof(out->properties.deviceName), "%s",
                          names[index]);
            if (index > 0) out->properties.deviceType = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
            if (index == 1) out->properties.apiVersion = VK_API_VERSION_1_2;
        });
    faults.replace<&Api::GetPhysicalDeviceFeatures2>(
        [](auto driver, VkPhysicalDevice, auto* f) { driver(real, f); });
    faults.replace<&Api::GetPhysicalDeviceMemoryProperties>(
        [](auto driver, VkPhysicalDevice, auto* m) { driver(real, m); });
    faults.replace<&Api::GetPhysicalDeviceQueueFamilyProperties>(
        [](auto driver, VkPhysicalDevice, uint32_t* count, auto* families) {
            driver(real, count, families);
        });
    faults.replace<&Api::CreateDevice>(
        [](auto driver, VkPhysicalDevice, const VkDeviceCreateInfo* info, auto* allocator,
           VkDevice* out) { return driver(real, info, allocator, out); });
    EXPECT_EQ(gpu::Device({}).info().name, "real");
    EXPECT_EQ(gpu::Device({.index = 0}).info().name, "software");
    expectSays(errorOf(core::ExitCode::noDevice, [] { gpu::Device device({.index = 1}); }),
               {"too old lacks Vulkan 1.3"});
    expectSays(errorOf(core::ExitCode::noDevice, [] { gpu::Device device({.index = 3}); }),
               {"no Vulkan device 3", "lists 3"});
    EXPECT_EQ(faults.objects().complaints(), "");
}

TEST_F(VulkanFails, ScenesBeyondTheLimitsAreRefusedWithTheNumbers)
{
    VulkanFaults faults;
    constexpr uint32_t kLow = (1u << 16) * shared::kStateWords;
    lieAboutProperties(
        faults, [](VkPhysicalDeviceProperties& p) { p.limits.maxTexelBufferElements = kLow; });
    const auto renderer = gpu::makePathRenderer({});
    auto big = std::make_shared<core::World>(*asset("cornell-diffuse"));
    big->texels = std::vector<core::Texel>(kLow + 2);
    expectSays(errorOf(core::ExitCode::deviceLost, [&] { renderer->setWorld(big, {}); }),
               {"the textures", std::to_string(kLow + 2), std::to_string(kLow), deviceName(),
                "--device cpu"});
    EXPECT_GT(brightness(renderSmall(*renderer, asset("cornell-diffuse"))), 0);  // and goes on
}

TEST_F(VulkanFails, ImagesBeyondTheLimitsAreRefusedWithTheNumbers)
{
    VulkanFaults faults;
    lieAboutProperties(
        faults, [](VkPhysicalDeviceProperties& p) { p.limits.maxStorageBufferRange = 4 << 20; });
    const auto world = asset("cornell-diffuse");
    const auto renderer = gpu::makePathRenderer({});
    renderer->setWorld(world, {});
    expectSays(
        errorOf(core::ExitCode::deviceLost,
                [&] {
                    renderer->setView({world->cameras.at(0), {4000, 3000}, {}}, core::Start::anew);
                }),
        {"MiB", "4 MiB", "smaller image"});
    EXPECT_GT(brightness(renderSmall(*renderer, world)), 0);
}

TEST_F(VulkanFails, WithoutTimestampsTheHostsClockServes)
{
    VulkanFaults faults;
    faults.replace<&Api::GetPhysicalDeviceQueueFamilyProperties>(
        [](auto driver, VkPhysicalDevice physical, uint32_t* count,
           VkQueueFamilyProperties* families) {
            driver(physical, count, families);
            if (families == nullptr) return;
            for (uint32_t i = 0; i < *count; ++i) families[i].timestampValidBits = 0;
        });
    {
        gpu::Device device({});
        EXPECT_FALSE(device.info().timestamps);
        gpu::Buffer buffer(device, "a test", 1 << 20);
        const double seconds = device.submit([&](VkCommandBuffer commands) {
            gpu::vk.CmdFillBuffer(commands, buffer.get(), 0, VK_WHOLE_SIZE, 1);
        });
        EXPECT_GT(seconds, 0);
        EXPECT_LT(seconds, 10);
    }
    EXPECT_EQ(faults.calls<&Api::CmdWriteTimestamp>(), 0u);
    EXPECT_EQ(faults.objects().complaints(), "");
}

TEST_F(VulkanFails, TimestampsOfFewBitsWrapAround)
{
    VulkanFaults faults;
    faults.replace<&Api::GetPhysicalDeviceQueueFamilyProperties>(
        [](auto driver, VkPhysicalDevice physical, uint32_t* count,
           VkQueueFamilyProperties* families) {
            driver(physical, count, families);
            if (families == nullptr) return;
            for (uint32_t i = 0; i < *count; ++i) families[i].timestampValidBits = 36;
        });
    faults.replace<&Api::GetQueryPoolResults>([](auto, VkDevice, VkQueryPool, uint32_t, uint32_t,
                                                 size_t, void* data, VkDeviceSize,
                                                 VkQueryResultFlags) {
        const uint64_t ticks[2] = {(uint64_t(1) << 36) - 1000, 500};
        std::memcpy(data, ticks, sizeof(ticks));
        return VK_SUCCESS;
    });
    gpu::Device device({});
    EXPECT_NEAR(device.submit([](VkCommandBuffer) {}),
                1500e-9 * double(device.limits().timestampPeriod), 1e-12);
}

// --- V16: windows

/// A surface that does not exist, and a driver that presents to it from `presenting` families (bit
/// per family). The driver's one family appears as two: the first computes only.
void plantSurface(VulkanFaults& faults, uint32_t presenting)
{
    faults.replace<&Api::GetPhysicalDeviceQueueFamilyProperties>(
        [](auto driver, VkPhysicalDevice physical, uint32_t* count,
           VkQueueFamilyProperties* families) {
            if (families != nullptr) {
                uint32_t one = 1;
                driver(physical, &one, families);
                families[1] = families[0];
                families[0].queueFlags = VK_QUEUE_COMPUTE_BIT;
            }
            *count = 2;
        });
    faults.replace<&Api::GetPhysicalDeviceSurfaceSupportKHR>(
        [presenting](auto, VkPhysicalDevice, uint32_t family, VkSurfaceKHR, VkBool32* supported) {
            *supported = (presenting >> family & 1u) != 0 ? VK_TRUE : VK_FALSE;
            return VK_SUCCESS;
        });
    faults.replace<&Api::DestroySurfaceKHR>(
        [](auto, VkInstance, VkSurfaceKHR, const VkAllocationCallbacks*) {});
    faults.replace<&Api::CreateDevice>([](auto driver, VkPhysicalDevice physical,
                                          const VkDeviceCreateInfo* info, auto* allocator,
                                          VkDevice* out) {
        VkDeviceQueueCreateInfo queue = info->pQueueCreateInfos[0];
        queue.queueFamilyIndex = 0;
        VkDeviceCreateInfo changed = *info;
        changed.pQueueCreateInfos = &queue;
        return driver(physical, &changed, allocator, out);
    });
    faults.replace<&Api::GetDeviceQueue>([](auto driver, VkDevice device, uint32_t, uint32_t index,
                                            VkQueue* out) { driver(device, 0, index, out); });
    faults.replace<&Api::CreateCommandPool>([](auto driver, VkDevice device,
                                               const VkCommandPoolCreateInfo* info, auto* allocator,
                                               VkCommandPool* out) {
        VkCommandPoolCreateInfo changed = *info;
        changed.queueFamilyIndex = 0;
        return driver(device, &changed, allocator, out);
    });
}

gpu::DeviceOptions forWindow()
{
    static int storage;
    gpu::DeviceOptions options;
    options.instanceExtensions = {VK_KHR_SURFACE_EXTENSION_NAME};
    options.surface = [](VkInstance) { return reinterpret_cast<VkSurfaceKHR>(&storage); };
    return options;
}

TEST_F(VulkanFails, TheQueueThatCanPresentIsTaken)
{
    VulkanFaults faults;
    plantSurface(faults, 2);
    {
        const gpu::Device window(forWindow());
        EXPECT_EQ(window.queueFamily(), 1u);
        const gpu::Device renderer({});
        EXPECT_EQ(renderer.queueFamily(), 0u);  // any that computes
    }
    EXPECT_EQ(faults.calls<&Api::DestroySurfaceKHR>(), 1u);
    EXPECT_EQ(faults.objects().complaints(), "");
}

TEST_F(VulkanFails, AQueueThatPresentsButDoesNotDrawIsNotEnough)
{
    VulkanFaults faults;
    plantSurface(faults, 1);
    expectSays(
        errorOf(core::ExitCode::noDevice, [] { gpu::Device device(forWindow()); }),
        {"window", deviceName(), "a queue that computes, draws and presents", "rekindle render"});
    EXPECT_EQ(faults.calls<&Api::DestroySurfaceKHR>(), 1u);
    EXPECT_EQ(faults.objects().complaints(), "");
}

TEST_F(VulkanFails, ADeviceWithoutSwapchainsIsNoneForAWindow)
{
    VulkanFaults faults;
    plantSurface(faults, 3);
    faults.replace<&Api::EnumerateDeviceExtensionProperties>(
        [](auto, VkPhysicalDevice, const char*, uint32_t* count, VkExtensionProperties*) {
            *count = 0;
            return VK_SUCCESS;
        });
    expectSays(errorOf(core::ExitCode::noDevice, [] { gpu::Device device(forWindow()); }),
               {"VK_KHR_swapchain"});
    EXPECT_TRUE(gpu::Device({}).info().missing.empty());  // without a window this is not asked
    EXPECT_EQ(faults.objects().complaints(), "");
}

// --- V4: work that does not end

void neverSignal(VulkanFaults& faults)
{
    faults.replace<&Api::WaitForFences>(
        [](auto, VkDevice, uint32_t, const VkFence*, VkBool32, uint64_t) { return VK_TIMEOUT; });
}

TEST_F(VulkanFails, ABusyDeviceIsToldOnceAndWaitedFor)
{
    VulkanFaults faults;
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

/// A device that never answers: it throws after `waits` steps and is left alone.
void expectGivenUp(int expectedWaits, bool software)
{
    VulkanFaults faults;
    lieAboutProperties(faults, [software](VkPhysicalDeviceProperties& p) {
        p.deviceType =
            software ? VK_PHYSICAL_DEVICE_TYPE_CPU : VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
    });
    neverSignal(faults);
    {
        const tests::LeakOnPurpose leak;
        gpu::DeviceOptions options;
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
        expectSays(text, {"lost", "not answered", std::to_string(2 * expectedWaits), "the work"});
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

TEST_F(VulkanFails, ASoftwareDeviceIsGivenUpAfterAMinute)
{
    expectGivenUp(30, true);
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
        expectSays(
            errorOf(core::ExitCode::deviceLost, [&] { renderer->advance({.samples = 1}, {}); }),
            {deviceName(), "vkWaitForFences",
             "bounces of " + std::to_string(world->triangles.size()) + " triangles",
             "tiles 0 to 14 of 15", "samples 3 to 3"});
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
