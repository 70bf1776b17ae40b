// A device from its creation to its loss. Waiting is never endless, and the first loss is the last
// that the driver hears of this device: every later call throws at once.
#include "app/gpu/base/device.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <mutex>

#include "app/gpu/base/device_choice.h"
#include "app/gpu/base/memory.h"
#include "core/base/memory.h"

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

std::mutex abandonedMutex;
std::vector<VkDevice> abandonedDevices;
std::atomic<bool> someAbandoned{false};

}  // namespace

void abandon(VkDevice device)
{
    const std::lock_guard lock(abandonedMutex);
    abandonedDevices.push_back(device);
    someAbandoned = true;
}

bool anyAbandoned()
{
    return someAbandoned;
}

bool isAbandoned(VkDevice device)
{
    if (!anyAbandoned()) return false;
    const std::lock_guard lock(abandonedMutex);
    return std::find(abandonedDevices.begin(), abandonedDevices.end(), device) !=
           abandonedDevices.end();
}

const char* resultName(VkResult result)
{
    switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
        return "VK_ERROR_OUT_OF_HOST_MEMORY";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        return "VK_ERROR_OUT_OF_DEVICE_MEMORY";
    case VK_ERROR_INITIALIZATION_FAILED:
        return "VK_ERROR_INITIALIZATION_FAILED";
    case VK_ERROR_DEVICE_LOST:
        return "VK_ERROR_DEVICE_LOST";
    case VK_ERROR_MEMORY_MAP_FAILED:
        return "VK_ERROR_MEMORY_MAP_FAILED";
    case VK_ERROR_LAYER_NOT_PRESENT:
        return "VK_ERROR_LAYER_NOT_PRESENT";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
        return "VK_ERROR_EXTENSION_NOT_PRESENT";
    case VK_ERROR_FEATURE_NOT_PRESENT:
        return "VK_ERROR_FEATURE_NOT_PRESENT";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
        return "VK_ERROR_INCOMPATIBLE_DRIVER";
    case VK_ERROR_TOO_MANY_OBJECTS:
        return "VK_ERROR_TOO_MANY_OBJECTS";
    case VK_ERROR_SURFACE_LOST_KHR:
        return "VK_ERROR_SURFACE_LOST_KHR";
    case VK_ERROR_OUT_OF_DATE_KHR:
        return "VK_ERROR_OUT_OF_DATE_KHR";
    case VK_SUBOPTIMAL_KHR:
        return "VK_SUBOPTIMAL_KHR";
    case VK_ERROR_NATIVE_WINDOW_IN_USE_KHR:
        return "VK_ERROR_NATIVE_WINDOW_IN_USE_KHR";
    case VK_ERROR_FULL_SCREEN_EXCLUSIVE_MODE_LOST_EXT:
        return "VK_ERROR_FULL_SCREEN_EXCLUSIVE_MODE_LOST_EXT";
    case VK_ERROR_FRAGMENTED_POOL:
        return "VK_ERROR_FRAGMENTED_POOL";
    case VK_ERROR_OUT_OF_POOL_MEMORY:
        return "VK_ERROR_OUT_OF_POOL_MEMORY";
    case VK_ERROR_INVALID_SHADER_NV:
        return "VK_ERROR_INVALID_SHADER_NV";
    case VK_ERROR_UNKNOWN:
        return "VK_ERROR_UNKNOWN";
    case VK_TIMEOUT:
        return "VK_TIMEOUT";
    default:
        return "an unnamed VkResult";
    }
}

uint64_t validationMessages()
{
    return messageCount;
}

Device::Device(const DeviceOptions& options)
    : waitStep_(options.waitStep), notice_(options.notice), cacheFolder_(options.cacheFolder)
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

        VkPhysicalDeviceProperties2 properties{};
        properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
        vk.GetPhysicalDeviceProperties2(physical_, &properties);
        properties_ = properties.properties;

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
        open(create);
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
        timestampBits_ = family.timestampValidBits;
        if (timestampBits_ > 0) {
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

void Device::open(const VkDeviceCreateInfo& create)
{
    const VkResult result = vk.CreateDevice(physical_, &create, nullptr, &device_);
    if (result == VK_SUCCESS) return;
    device_ = VK_NULL_HANDLE;
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY ||
        result == VK_ERROR_DEVICE_LOST) {
        checkVulkan(result, "vkCreateDevice");
    }
    throw core::Error(
        "the Vulkan device " + info_.name + " does not open (" + resultName(result) +
            ") — choose another one of those that `rekindle devices` lists, or --device cpu",
        core::ExitCode::noDevice);
}

Device::~Device()
{
    destroy();
}

void Device::destroy()
{
    const bool leave = device_ != VK_NULL_HANDLE && isAbandoned(device_);
    if (device_ != VK_NULL_HANDLE && !lost_) vk.DeviceWaitIdle(device_);
    staging_.reset();
    timestamps_ = {};
    fence_ = {};
    pool_ = {};
    if (device_ != VK_NULL_HANDLE && !leave) vk.DestroyDevice(device_, nullptr);
    if (surface_ != VK_NULL_HANDLE && !leave)
        vk.DestroySurfaceKHR(instance_, takeSurface(), nullptr);
    if (messenger_ != VK_NULL_HANDLE && !leave) {
        const auto destroyMessenger = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
            vk.GetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
        destroyMessenger(instance_, messenger_, nullptr);
    }
    if (instance_ != VK_NULL_HANDLE && !leave) vk.DestroyInstance(instance_, nullptr);
    device_ = VK_NULL_HANDLE;
    messenger_ = VK_NULL_HANDLE;
    instance_ = VK_NULL_HANDLE;
}

Staging& Device::staging(uint64_t bytes)
{
    if (staging_ == nullptr || staging_->bytes() < bytes) {
        staging_.reset();  // before the new one: both at once may not fit
        staging_ = std::make_unique<Staging>(*this, std::bit_ceil(bytes));  // few sizes in all
    }
    return *staging_;
}

void Device::requireAlive() const
{
    if (lost_)
        throw core::Error("the Vulkan device was lost before — a new one is needed",
                          core::ExitCode::deviceLost);
}

void Device::lose(const std::string& how)
{
    lost_ = true;
    throw core::Error(
        "the Vulkan device " + info_.name + " is lost: " + how +
            (work_.empty() ? "" : " during " + work_) +
            " — render again with smaller pieces or on another device; --device cpu needs none",
        core::ExitCode::deviceLost);
}

void Device::check(VkResult result, const char* call)
{
    if (result == VK_ERROR_DEVICE_LOST && !lost_)
        lose(std::string(call) + " gave VK_ERROR_DEVICE_LOST");
    checkVulkan(result, call);
}

/// Processor time of this process, in seconds.
static double processorSeconds()
{
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

void Device::wait(VkFence fence, std::string_view work)
{
    requireAlive();
    if (!work.empty()) work_ = work;
    constexpr int kNoticeStep = 3;
    // Steps; a software device shares its processors with everything else, and where others have
    // nearly all of them it is slow, not lost.
    const int patience = software_ ? 30 : 10;
    const int most = software_ ? 10 * patience : patience;
    const double begin = processorSeconds();
    int step = 1;
    for (;; ++step) {
        const VkResult result =
            vk.WaitForFences(device_, 1, &fence, VK_TRUE, static_cast<uint64_t>(waitStep_ * 1e9));
        if (result < 0 && result != VK_ERROR_DEVICE_LOST) {
            abandon(device_);  // whether the work has ended is not known
            lose(std::string("vkWaitForFences gave ") + resultName(result));
        }
        if (result != VK_TIMEOUT) {
            check(result, "vkWaitForFences");
            return;
        }
        if (step == kNoticeStep) noticeThatItTakesLong(step * waitStep_);
        const bool starved = processorSeconds() - begin < 0.5 * step * waitStep_;
        if (step >= most || (step >= patience && !starved)) break;
    }
    abandon(device_);
    lose("it has not answered for " + std::to_string(std::lround(step * waitStep_)) + " s");
}

void Device::noticeThatItTakesLong(double seconds) const
{
    const std::string text = "GPU busy: " + (work_.empty() ? "its work" : work_) +
                             " has been running for " + std::to_string(std::lround(seconds)) + " s";
    if (notice_) {
        notice_(text);
    } else {
        std::fprintf(stderr, "rekindle: %s\n", text.c_str());
    }
}

void Device::record(const std::function<void(VkCommandBuffer)>& commands)
{
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vk.BeginCommandBuffer(commands_, &begin), "vkBeginCommandBuffer");
    try {
        if (timestamps_) {
            vk.CmdResetQueryPool(commands_, timestamps_.get(), 0, 2);
            vk.CmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, timestamps_.get(),
                                 0);
        }
        commands(commands_);
        if (timestamps_) {
            vk.CmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, timestamps_.get(),
                                 1);
        }
    } catch (...) {
        vk.ResetCommandBuffer(commands_, 0);  // one that is being recorded cannot be begun again
        throw;
    }
    check(vk.EndCommandBuffer(commands_), "vkEndCommandBuffer");
}

double Device::submit(const std::function<void(VkCommandBuffer)>& commands, std::string_view work)
{
    requireAlive();
    work_ = work;
    record(commands);
    // Before and not after use: were it to fail there, the next submission would find a fence that
    // is set.
    const VkFence fence = fence_.get();
    check(vk.ResetFences(device_, 1, &fence), "vkResetFences");
    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands_;
    const auto start = std::chrono::steady_clock::now();
    check(vk.QueueSubmit(queue_, 1, &submit, fence), "vkQueueSubmit");
    wait(fence);
    if (std::exchange(compiles_, false)) core::giveBackMemory();
    if (timestamps_) {
        std::array<uint64_t, 2> ticks{};
        check(vk.GetQueryPoolResults(device_, timestamps_.get(), 0, 2, sizeof(ticks), ticks.data(),
                                     sizeof(uint64_t), VK_QUERY_RESULT_64_BIT),
              "vkGetQueryPoolResults");
        const uint64_t valid =
            timestampBits_ >= 64 ? ~uint64_t(0) : (uint64_t(1) << timestampBits_) - 1;
        return static_cast<double>((ticks[1] - ticks[0]) & valid) *
               static_cast<double>(limits().timestampPeriod) * 1e-9;
    }
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void barrier(VkCommandBuffer commands)
{
    VkMemoryBarrier memory{};
    memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    memory.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    memory.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT |
                           VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT |
                           VK_ACCESS_INDIRECT_COMMAND_READ_BIT | VK_ACCESS_UNIFORM_READ_BIT |
                           VK_ACCESS_HOST_READ_BIT;
    const VkPipelineStageFlags work =
        VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
    vk.CmdPipelineBarrier(commands, work,
                          work | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_HOST_BIT,
                          0, 1, &memory, 0, nullptr, 0, nullptr);
}

}  // namespace gpu
