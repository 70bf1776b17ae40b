// What is asked of a device: Vulkan 1.3 with scalar block layout, maintenance4 and subgroup ballot,
// and a few limits.
#include "app/gpu/base/device_choice.h"

#include <algorithm>
#include <string_view>

#include "shared/bindings.h"

namespace gpu {

namespace {

bool hasSwapchains(VkPhysicalDevice physical)
{
    uint32_t count = 0;
    VK_CHECK(vk.EnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr));
    std::vector<VkExtensionProperties> extensions(count);
    VK_CHECK(vk.EnumerateDeviceExtensionProperties(physical, nullptr, &count, extensions.data()));
    return std::any_of(
        extensions.begin(), extensions.end(), [](const VkExtensionProperties& extension) {
            return std::string_view(extension.extensionName) == VK_KHR_SWAPCHAIN_EXTENSION_NAME;
        });
}

std::string version(uint32_t v)
{
    return std::to_string(VK_API_VERSION_MAJOR(v)) + "." + std::to_string(VK_API_VERSION_MINOR(v)) +
           "." + std::to_string(VK_API_VERSION_PATCH(v));
}

const char* typeName(VkPhysicalDeviceType type)
{
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return "discrete GPU";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return "integrated GPU";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return "virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return "software (CPU)";
    default:
        return "other";
    }
}

/// A limit of the device, what it is and the least that every kernel and buffer can do with. What
/// depends on the scene and the image is checked when their buffers are made.
struct Limit {
    const char* name;
    uint64_t has, needed;
};

std::vector<Limit> limitsOf(const VkPhysicalDeviceLimits& l)
{
    constexpr uint32_t kStorage = shared::kMostStorageBuffers;
    constexpr uint64_t kLanes = 1u << 16;  // the smallest batch of paths
    return {
        {"maxComputeWorkGroupInvocations", l.maxComputeWorkGroupInvocations, shared::kGroupSize},
        {"maxComputeWorkGroupSize", l.maxComputeWorkGroupSize[0], shared::kGroupSize},
        {"maxComputeWorkGroupCount", l.maxComputeWorkGroupCount[0], 1u << 15},
        {"maxPushConstantsSize", l.maxPushConstantsSize, shared::kMostPushBytes},
        {"maxUniformBufferRange", l.maxUniformBufferRange, sizeof(shared::FrameData)},
        {"maxPerStageDescriptorStorageBuffers", l.maxPerStageDescriptorStorageBuffers, kStorage},
        {"maxDescriptorSetStorageBuffers", l.maxDescriptorSetStorageBuffers, kStorage},
        {"maxPerStageDescriptorSampledImages", l.maxPerStageDescriptorSampledImages,
         shared::kMostTexelBuffers},
        {"maxDescriptorSetSampledImages", l.maxDescriptorSetSampledImages,
         shared::kMostTexelBuffers},
        {"maxPerStageResources", l.maxPerStageResources, shared::kMostResources},
        {"maxTexelBufferElements", l.maxTexelBufferElements, kLanes * shared::kStateWords},
        {"maxStorageBufferRange", l.maxStorageBufferRange, kLanes * shared::kStateWords * 16}};
}

}  // namespace

std::optional<uint32_t> queueFamilyFor(VkPhysicalDevice physical, VkSurfaceKHR surface,
                                       VkQueueFamilyProperties* properties)
{
    const VkQueueFlags needed = surface == VK_NULL_HANDLE
                                    ? VK_QUEUE_COMPUTE_BIT
                                    : VK_QUEUE_COMPUTE_BIT | VK_QUEUE_GRAPHICS_BIT;
    uint32_t count = 0;
    vk.GetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vk.GetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    for (uint32_t i = 0; i < count; ++i) {
        if ((families[i].queueFlags & needed) != needed) continue;
        VkBool32 presents = VK_TRUE;
        if (surface != VK_NULL_HANDLE) {
            VK_CHECK(vk.GetPhysicalDeviceSurfaceSupportKHR(physical, i, surface, &presents));
        }
        if (presents == VK_FALSE) continue;
        if (properties != nullptr) *properties = families[i];
        return i;
    }
    return std::nullopt;
}

DeviceInfo describe(VkPhysicalDevice physical, VkSurfaceKHR surface)
{
    VkPhysicalDeviceDriverProperties driver{};
    driver.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
    VkPhysicalDeviceMaintenance3Properties allocation{};
    allocation.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES;
    allocation.pNext = &driver;
    VkPhysicalDeviceSubgroupProperties subgroup{};
    subgroup.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
    subgroup.pNext = &allocation;
    VkPhysicalDeviceProperties2 properties{};
    properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
    properties.pNext = &subgroup;
    vk.GetPhysicalDeviceProperties2(physical, &properties);
    const VkPhysicalDeviceProperties& p = properties.properties;

    DeviceInfo info;
    info.name = p.deviceName;
    info.driver = std::string(driver.driverName) + " " + driver.driverInfo;
    info.type = typeName(p.deviceType);
    info.api = version(p.apiVersion);
    info.maxStorageRange = p.limits.maxStorageBufferRange;
    info.maxTexelElements = p.limits.maxTexelBufferElements;
    info.maxAllocation = allocation.maxMemoryAllocationSize;
    VkPhysicalDeviceMemoryProperties memory;
    vk.GetPhysicalDeviceMemoryProperties(physical, &memory);
    for (uint32_t i = 0; i < memory.memoryHeapCount; ++i) {
        if ((memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0) {
            info.heapBytes = std::max<uint64_t>(info.heapBytes, memory.memoryHeaps[i].size);
        }
    }

    if (p.apiVersion < VK_API_VERSION_1_3) {
        info.missing.push_back("Vulkan 1.3 (it has " + info.api + ")");
        return info;
    }
    VkQueueFamilyProperties family{};
    if (!queueFamilyFor(physical, VK_NULL_HANDLE, &family))
        info.missing.emplace_back("a compute queue");
    info.timestamps = family.timestampValidBits > 0;
    if (surface != VK_NULL_HANDLE) {
        if (!hasSwapchains(physical)) info.missing.emplace_back("VK_KHR_swapchain");
        if (!queueFamilyFor(physical, surface, nullptr)) {
            info.missing.emplace_back("a queue that computes, draws and presents to this window");
        }
    }
    Features features;
    vk.GetPhysicalDeviceFeatures2(physical, &features.all);
    if (features.v12.scalarBlockLayout == VK_FALSE) info.missing.emplace_back("scalarBlockLayout");
    if (features.v13.maintenance4 == VK_FALSE) info.missing.emplace_back("maintenance4");
    const VkSubgroupFeatureFlags needed =
        VK_SUBGROUP_FEATURE_BALLOT_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT;
    if ((subgroup.supportedOperations & needed) != needed) {
        info.missing.emplace_back("subgroup ballot and arithmetic");
    }
    for (const Limit& limit : limitsOf(p.limits)) {
        if (limit.has >= limit.needed) continue;
        info.missing.push_back(std::string(limit.name) + " of " + std::to_string(limit.needed) +
                               " (it has " + std::to_string(limit.has) + ")");
    }
    return info;
}

VkInstance makeInstance(const DeviceOptions& options)
{
    VkApplicationInfo application{};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.pApplicationName = "rekindle";
    application.apiVersion = VK_API_VERSION_1_3;
    VkInstanceCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    create.pApplicationInfo = &application;
    const char* layer = "VK_LAYER_KHRONOS_validation";
    std::vector<const char*> extensions = options.instanceExtensions;
    const VkValidationFeatureEnableEXT enable =
        VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features{};
    features.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = &enable;
    if (options.validation) {
        create.pNext = &features;
        create.enabledLayerCount = 1;
        create.ppEnabledLayerNames = &layer;
        extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
        extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    }
    create.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    create.ppEnabledExtensionNames = extensions.data();
    VkInstance instance = VK_NULL_HANDLE;
    const VkResult result = vk.CreateInstance(&create, nullptr, &instance);
    if (result == VK_ERROR_LAYER_NOT_PRESENT) {
        throw core::Error(
            "the Vulkan validation layer is not installed — install vulkan-validationlayers",
            core::ExitCode::noDevice);
    }
    if (result == VK_ERROR_EXTENSION_NOT_PRESENT && !options.instanceExtensions.empty()) {
        throw core::Error("no Vulkan driver can show frames in a window — `rekindle render SCENE "
                          "-o FILE` needs none",
                          core::ExitCode::noDevice);
    }
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY) VK_CHECK(result);
    if (result != VK_SUCCESS) {
        throw core::Error(
            std::string("no Vulkan driver answers (") + resultName(result) +
                ") — install one (mesa-vulkan-drivers has a software device), or use --device cpu",
            core::ExitCode::noDevice);
    }
    return instance;
}

std::vector<VkPhysicalDevice> physicalDevices(VkInstance instance)
{
    uint32_t count = 0;
    VkResult result = vk.EnumeratePhysicalDevices(instance, &count, nullptr);
    std::vector<VkPhysicalDevice> devices(result >= 0 ? count : 0);
    if (result >= 0) result = vk.EnumeratePhysicalDevices(instance, &count, devices.data());
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY) VK_CHECK(result);
    if (result < 0) {
        throw core::Error(std::string("the Vulkan drivers tell no device (") + resultName(result) +
                              ") — repair their installation, or use --device cpu",
                          core::ExitCode::noDevice);
    }
    devices.resize(count);  // one may have gone in between
    return devices;
}

VkPhysicalDevice chooseDevice(const std::vector<VkPhysicalDevice>& devices, int index,
                              VkSurfaceKHR surface)
{
    if (index >= static_cast<int>(devices.size())) {
        throw core::Error("there is no Vulkan device " + std::to_string(index) +
                              "; `rekindle devices` lists " + std::to_string(devices.size()),
                          core::ExitCode::noDevice);
    }
    if (surface != VK_NULL_HANDLE && index >= 0 &&
        !describe(devices[static_cast<size_t>(index)], surface).missing.empty()) {
        index = -1;  // only preferred
    }
    VkPhysicalDevice best = VK_NULL_HANDLE;
    std::string reasons;
    for (size_t i = 0; i < devices.size(); ++i) {
        if (index >= 0 && i != static_cast<size_t>(index)) continue;
        const DeviceInfo info = describe(devices[i], surface);
        if (info.missing.empty()) {
            const bool software = info.type == std::string("software (CPU)");
            if (best == VK_NULL_HANDLE || !software) best = devices[i];
            if (!software) break;
            continue;
        }
        reasons += "\n  " + info.name + " lacks ";
        for (size_t m = 0; m < info.missing.size(); ++m)
            reasons += (m > 0 ? ", " : "") + info.missing[m];
    }
    if (devices.empty()) reasons = "\n  the drivers that are installed tell of none";
    if (best == VK_NULL_HANDLE && surface != VK_NULL_HANDLE) {
        throw core::Error("no Vulkan device can show frames in this window — `rekindle render "
                          "SCENE -o FILE` needs none" +
                              reasons,
                          core::ExitCode::noDevice);
    }
    if (best == VK_NULL_HANDLE) {
        throw core::Error("no suitable Vulkan device; --device cpu needs none" + reasons,
                          core::ExitCode::noDevice);
    }
    return best;
}

std::vector<DeviceInfo> listDevices()
{
    VkInstance instance = makeInstance({});
    std::vector<DeviceInfo> infos;
    try {
        for (VkPhysicalDevice physical : physicalDevices(instance))
            infos.push_back(describe(physical));
    } catch (...) {
        vk.DestroyInstance(instance, nullptr);
        throw;
    }
    vk.DestroyInstance(instance, nullptr);
    return infos;
}

}  // namespace gpu
