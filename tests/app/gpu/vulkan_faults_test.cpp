// Vulkan that is not what is needed, on purpose: devices that lie, lack something or cannot present
// (V12, V13, V16, V18). Nothing here needs a GPU: the faults are planted in the table of functions.
#include "app/gpu/base/memory.h"
#include "shared/bindings.h"
#include "tests/support/vulkan/leak_on_purpose.h"
#include "tests/support/vulkan/vulkan_fails.h"

namespace {

using namespace tests;
using gpu::Api;

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
            out->properties.deviceType =
                index > 0 ? VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU : VK_PHYSICAL_DEVICE_TYPE_CPU;
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

}  // namespace
