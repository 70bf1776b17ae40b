// Instance and device creation. Needs Vulkan 1.3 with scalar block layout and subgroup ballot; nothing else is required.
#include "app/gpu/device.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

namespace gpu {

namespace {

std::atomic<uint64_t> messageCount{0};

VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                         VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data, void*)
{
    if (++messageCount <= 20) std::fprintf(stderr, "validation: %s\n", data->pMessage);
    return VK_FALSE;
}

/// The features asked for, chained as vkCreateDevice and vkGetPhysicalDeviceFeatures2 take them.
struct Features {
    VkPhysicalDeviceVulkan13Features v13{};
    VkPhysicalDeviceVulkan12Features v12{};
    VkPhysicalDeviceFeatures2 all{};

    Features()
    {
        v13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
        v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
        v12.pNext = &v13;
        all.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
        all.pNext = &v12;
    }
    Features(const Features&) = delete;
    Features& operator=(const Features&) = delete;
};

/// The first family that computes; with a `surface`, that also draws and can present to it.
std::optional<uint32_t> queueFamilyFor(VkPhysicalDevice physical, VkSurfaceKHR surface,
                                       VkQueueFamilyProperties* properties)
{
    const VkQueueFlags needed =
        surface == VK_NULL_HANDLE ? VK_QUEUE_COMPUTE_BIT : VK_QUEUE_COMPUTE_BIT | VK_QUEUE_GRAPHICS_BIT;
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

bool hasSwapchains(VkPhysicalDevice physical)
{
    uint32_t count = 0;
    VK_CHECK(vk.EnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr));
    std::vector<VkExtensionProperties> extensions(count);
    VK_CHECK(vk.EnumerateDeviceExtensionProperties(physical, nullptr, &count, extensions.data()));
    return std::any_of(extensions.begin(), extensions.end(), [](const VkExtensionProperties& extension) {
        return std::string_view(extension.extensionName) == VK_KHR_SWAPCHAIN_EXTENSION_NAME;
    });
}

std::string version(uint32_t v)
{
    return std::to_string(VK_API_VERSION_MAJOR(v)) + "." + std::to_string(VK_API_VERSION_MINOR(v)) + "." +
           std::to_string(VK_API_VERSION_PATCH(v));
}

const char* typeName(VkPhysicalDeviceType type)
{
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return "discrete GPU";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return "integrated GPU";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return "virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU: return "software (CPU)";
    default: return "other";
    }
}

DeviceInfo describe(VkPhysicalDevice physical, VkSurfaceKHR surface = VK_NULL_HANDLE)
{
    VkPhysicalDeviceDriverProperties driver{};
    driver.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
    VkPhysicalDeviceSubgroupProperties subgroup{};
    subgroup.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
    subgroup.pNext = &driver;
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
    if (!queueFamilyFor(physical, VK_NULL_HANDLE, nullptr)) info.missing.emplace_back("a compute queue");
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
    const VkSubgroupFeatureFlags needed = VK_SUBGROUP_FEATURE_BALLOT_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT;
    if ((subgroup.supportedOperations & needed) != needed) {
        info.missing.emplace_back("subgroup ballot and arithmetic");
    }
    if (p.limits.maxPerStageDescriptorStorageBuffers < 12) info.missing.emplace_back("12 storage buffers per stage");
    if (p.limits.maxPerStageDescriptorSampledImages < 16) info.missing.emplace_back("16 texel buffers per stage");
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
    const VkValidationFeatureEnableEXT enable = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
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
        throw core::Error("the Vulkan validation layer is not installed — install vulkan-validationlayers",
                          core::ExitCode::noDevice);
    }
    if (result == VK_ERROR_EXTENSION_NOT_PRESENT && !options.instanceExtensions.empty()) {
        throw core::Error("no Vulkan driver can show frames in a window — `rekindle render SCENE -o FILE` needs none",
                          core::ExitCode::noDevice);
    }
    if (result != VK_SUCCESS) {
        throw core::Error(std::string("no Vulkan driver answers (") + resultName(result) +
                              ") — install one (mesa-vulkan-drivers has a software device), or use --device cpu",
                          core::ExitCode::noDevice);
    }
    return instance;
}

std::vector<VkPhysicalDevice> physicalDevices(VkInstance instance)
{
    uint32_t count = 0;
    VK_CHECK(vk.EnumeratePhysicalDevices(instance, &count, nullptr));
    std::vector<VkPhysicalDevice> devices(count);
    VK_CHECK(vk.EnumeratePhysicalDevices(instance, &count, devices.data()));
    return devices;
}

/// The device asked for, or the best suitable one. Throws with what each of them lacks.
VkPhysicalDevice chooseDevice(const std::vector<VkPhysicalDevice>& devices, int index, VkSurfaceKHR surface)
{
    if (index >= static_cast<int>(devices.size())) {
        throw core::Error("there is no Vulkan device " + std::to_string(index) + "; `rekindle devices` lists " +
                              std::to_string(devices.size()),
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
        reasons += "\n  " + info.name + " lacks";
        for (const std::string& what : info.missing) reasons += " " + what + ";";
    }
    if (best == VK_NULL_HANDLE && surface != VK_NULL_HANDLE) {
        throw core::Error("no Vulkan device can show frames in this window — `rekindle render SCENE -o FILE` needs none" +
                              reasons,
                          core::ExitCode::noDevice);
    }
    if (best == VK_NULL_HANDLE) {
        throw core::Error("no suitable Vulkan device; --device cpu needs none" + reasons, core::ExitCode::noDevice);
    }
    return best;
}

}  // namespace

const char* resultName(VkResult result)
{
    switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY: return "VK_ERROR_OUT_OF_HOST_MEMORY";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY: return "VK_ERROR_OUT_OF_DEVICE_MEMORY";
    case VK_ERROR_INITIALIZATION_FAILED: return "VK_ERROR_INITIALIZATION_FAILED";
    case VK_ERROR_DEVICE_LOST: return "VK_ERROR_DEVICE_LOST";
    case VK_ERROR_MEMORY_MAP_FAILED: return "VK_ERROR_MEMORY_MAP_FAILED";
    case VK_ERROR_LAYER_NOT_PRESENT: return "VK_ERROR_LAYER_NOT_PRESENT";
    case VK_ERROR_EXTENSION_NOT_PRESENT: return "VK_ERROR_EXTENSION_NOT_PRESENT";
    case VK_ERROR_FEATURE_NOT_PRESENT: return "VK_ERROR_FEATURE_NOT_PRESENT";
    case VK_ERROR_INCOMPATIBLE_DRIVER: return "VK_ERROR_INCOMPATIBLE_DRIVER";
    case VK_ERROR_TOO_MANY_OBJECTS: return "VK_ERROR_TOO_MANY_OBJECTS";
    case VK_ERROR_SURFACE_LOST_KHR: return "VK_ERROR_SURFACE_LOST_KHR";
    case VK_ERROR_OUT_OF_DATE_KHR: return "VK_ERROR_OUT_OF_DATE_KHR";
    case VK_SUBOPTIMAL_KHR: return "VK_SUBOPTIMAL_KHR";
    case VK_ERROR_NATIVE_WINDOW_IN_USE_KHR: return "VK_ERROR_NATIVE_WINDOW_IN_USE_KHR";
    case VK_ERROR_FULL_SCREEN_EXCLUSIVE_MODE_LOST_EXT: return "VK_ERROR_FULL_SCREEN_EXCLUSIVE_MODE_LOST_EXT";
    case VK_TIMEOUT: return "VK_TIMEOUT";
    default: return "an unnamed VkResult";
    }
}

std::vector<DeviceInfo> listDevices()
{
    VkInstance instance = makeInstance({});
    std::vector<DeviceInfo> infos;
    for (VkPhysicalDevice physical : physicalDevices(instance)) infos.push_back(describe(physical));
    vk.DestroyInstance(instance, nullptr);
    return infos;
}

uint64_t validationMessages()
{
    return messageCount;
}

Device::Device(const DeviceOptions& options)
{
    instance_ = makeInstance(options);
    try {
        if (options.validation) {
            VkDebugUtilsMessengerCreateInfoEXT create{};
            create.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
            create.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                                     VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
            create.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                                 VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
            create.pfnUserCallback = onMessage;
            const auto make = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
                vk.GetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
            VK_CHECK(make(instance_, &create, nullptr, &messenger_));
        }
        if (options.surface) surface_ = options.surface(instance_);
        physical_ = chooseDevice(physicalDevices(instance_), options.index, surface_);
        info_ = describe(physical_);
        software_ = info_.type == "software (CPU)";

        VkPhysicalDeviceSubgroupProperties subgroup{};
        subgroup.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
        VkPhysicalDeviceProperties2 properties{};
        properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
        properties.pNext = &subgroup;
        vk.GetPhysicalDeviceProperties2(physical_, &properties);
        limits_ = properties.properties.limits;
        subgroupSize_ = subgroup.subgroupSize;

        VkQueueFamilyProperties family{};
        queueFamily_ = queueFamilyFor(physical_, surface_, &family).value();
        const float priority = 1.0f;
        VkDeviceQueueCreateInfo queue{};
        queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
        queue.queueFamilyIndex = queueFamily_;
        queue.queueCount = 1;
        queue.pQueuePriorities = &priority;
        Features features;
        features.v12.scalarBlockLayout = VK_TRUE;
        features.v13.maintenance4 = VK_TRUE;  // SPIR-V 1.6 states the group size by LocalSizeId
        VkDeviceCreateInfo create{};
        create.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
        create.pNext = &features.all;
        create.queueCreateInfoCount = 1;
        create.pQueueCreateInfos = &queue;
        const char* swapchain = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
        if (surface_ != VK_NULL_HANDLE) {
            create.enabledExtensionCount = 1;
            create.ppEnabledExtensionNames = &swapchain;
        }
        VK_CHECK(vk.CreateDevice(physical_, &create, nullptr, &device_));
        vk.GetDeviceQueue(device_, queueFamily_, 0, &queue_);

        VkCommandPoolCreateInfo pool{};
        pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
        pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
        pool.queueFamilyIndex = queueFamily_;
        VkCommandPool poolObject;
        VK_CHECK(vk.CreateCommandPool(device_, &pool, nullptr, &poolObject));
        pool_ = {device_, poolObject};
        VkCommandBufferAllocateInfo allocate{};
        allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
        allocate.commandPool = pool_.get();
        allocate.commandBufferCount = 1;
        VK_CHECK(vk.AllocateCommandBuffers(device_, &allocate, &commands_));
        VkFenceCreateInfo fence{};
        fence.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
        VkFence fenceObject;
        VK_CHECK(vk.CreateFence(device_, &fence, nullptr, &fenceObject));
        fence_ = {device_, fenceObject};
        if (family.timestampValidBits > 0) {
            VkQueryPoolCreateInfo query{};
            query.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
            query.queryType = VK_QUERY_TYPE_TIMESTAMP;
            query.queryCount = 2;
            VkQueryPool queryObject;
            VK_CHECK(vk.CreateQueryPool(device_, &query, nullptr, &queryObject));
            timestamps_ = {device_, queryObject};
        }
    } catch (...) {
        destroy();
        throw;
    }
}

Device::~Device()
{
    destroy();
}

void Device::destroy()
{
    if (device_ != VK_NULL_HANDLE) vk.DeviceWaitIdle(device_);
    timestamps_ = {};
    fence_ = {};
    pool_ = {};
    if (device_ != VK_NULL_HANDLE) vk.DestroyDevice(device_, nullptr);
    if (surface_ != VK_NULL_HANDLE) vk.DestroySurfaceKHR(instance_, takeSurface(), nullptr);
    if (messenger_ != VK_NULL_HANDLE) {
        const auto destroyMessenger = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
            vk.GetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
        destroyMessenger(instance_, messenger_, nullptr);
    }
    if (instance_ != VK_NULL_HANDLE) vk.DestroyInstance(instance_, nullptr);
    device_ = VK_NULL_HANDLE;
    messenger_ = VK_NULL_HANDLE;
    instance_ = VK_NULL_HANDLE;
}

double Device::submit(const std::function<void(VkCommandBuffer)>& record)
{
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    VK_CHECK(vk.BeginCommandBuffer(commands_, &begin));
    if (timestamps_) {
        vk.CmdResetQueryPool(commands_, timestamps_.get(), 0, 2);
        vk.CmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, timestamps_.get(), 0);
    }
    record(commands_);
    if (timestamps_) {
        vk.CmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, timestamps_.get(), 1);
    }
    VK_CHECK(vk.EndCommandBuffer(commands_));
    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands_;
    const auto start = std::chrono::steady_clock::now();
    VK_CHECK(vk.QueueSubmit(queue_, 1, &submit, fence_.get()));

    const VkFence fence = fence_.get();
    VkResult result = VK_TIMEOUT;
    for (int step = 0; step < 30 && result == VK_TIMEOUT; ++step) {
        if (step == 3) std::fprintf(stderr, "the device has been busy for 6 s ...\n");
        result = vk.WaitForFences(device_, 1, &fence, VK_TRUE, 2'000'000'000);
    }
    if (result == VK_TIMEOUT) {
        throw core::Error("the device has not answered for a minute — treated as lost", core::ExitCode::deviceLost);
    }
    VK_CHECK(result);
    VK_CHECK(vk.ResetFences(device_, 1, &fence));
    if (timestamps_) {
        std::array<uint64_t, 2> ticks{};
        VK_CHECK(vk.GetQueryPoolResults(device_, timestamps_.get(), 0, 2, sizeof(ticks), ticks.data(),
                                       sizeof(uint64_t), VK_QUERY_RESULT_64_BIT));
        return static_cast<double>(ticks[1] - ticks[0]) * static_cast<double>(limits_.timestampPeriod) * 1e-9;
    }
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void barrier(VkCommandBuffer commands)
{
    VkMemoryBarrier memory{};
    memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    memory.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    memory.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                           VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT |
                           VK_ACCESS_HOST_READ_BIT;
    const VkPipelineStageFlags work = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
    vk.CmdPipelineBarrier(commands, work,
                         work | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &memory, 0,
                         nullptr, 0, nullptr);
}

}  // namespace gpu
