// A Vulkan 1.3 device for compute and, if asked, for a window: instance, queue, limits, submission, counted messages.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/gpu/handle.h"

namespace gpu {

struct DeviceOptions {
    int index = -1;  // as listed by `devices`; -1: the first suitable one, real GPUs before software
    bool validation = false;

    // For a device that shows frames in a window; without `surface` nothing of a window is asked for.
    std::vector<const char*> instanceExtensions;
    /// Makes the surface of the window. The device can present to it; it belongs to the device until takeSurface().
    std::function<VkSurfaceKHR(VkInstance)> surface;
};

struct DeviceInfo {
    std::string name, driver, type, api;
    std::vector<std::string> missing;  // what Rekindle needs and this device lacks; empty: suitable
    uint64_t heapBytes = 0;            // largest device-local heap
    uint64_t maxStorageRange = 0;
    uint32_t maxTexelElements = 0;
};

/// Every Vulkan device of this machine. Throws core::Error (noDevice) when there is no Vulkan at all.
std::vector<DeviceInfo> listDevices();

/// Messages (warnings and errors) that the validation layer has printed in this process.
uint64_t validationMessages();

class Device {
public:
    /// Throws core::Error (noDevice) naming what each device lacks. With a surface the device at `index` is only
    /// preferred: one that cannot present to it gives way to another.
    explicit Device(const DeviceOptions& options);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    VkDevice get() const { return device_; }
    VkPhysicalDevice physical() const { return physical_; }
    VkInstance instance() const { return instance_; }
    VkQueue queue() const { return queue_; }
    uint32_t queueFamily() const { return queueFamily_; }
    const VkPhysicalDeviceLimits& limits() const { return limits_; }
    const DeviceInfo& info() const { return info_; }
    bool isSoftware() const { return software_; }
    uint32_t subgroupSize() const { return subgroupSize_; }

    /// The surface of DeviceOptions, for the caller to destroy; null when there is none or it has been taken.
    VkSurfaceKHR takeSurface() { return std::exchange(surface_, VK_NULL_HANDLE); }

    /// Records with `record`, submits and waits until done. Waits in steps and gives up on a device that
    /// does not answer for a minute. Returns the seconds that the device was busy (timestamps, or wall time without them).
    double submit(const std::function<void(VkCommandBuffer)>& record);

    /// Bytes of device memory that are allocated now, and the most there have been.
    uint64_t allocatedBytes = 0, peakBytes = 0;

private:
    void destroy();

    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    uint32_t queueFamily_ = 0;
    VkSurfaceKHR surface_ = VK_NULL_HANDLE;
    VkPhysicalDeviceLimits limits_{};
    DeviceInfo info_;
    bool software_ = false;
    uint32_t subgroupSize_ = 0;
    Handle<VkCommandPool, &Api::DestroyCommandPool> pool_;
    Handle<VkFence, &Api::DestroyFence> fence_;
    Handle<VkQueryPool, &Api::DestroyQueryPool> timestamps_;
    VkCommandBuffer commands_ = VK_NULL_HANDLE;
};

/// Makes writes of compute and transfer before it visible to compute, transfer and indirect reads after it.
void barrier(VkCommandBuffer commands);

}  // namespace gpu
