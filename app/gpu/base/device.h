// A Vulkan 1.3 device for compute and, if asked, for a window: instance, queue, limits, submission,
// counted messages.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/gpu/base/handle.h"

namespace gpu {

class Staging;

struct DeviceOptions {
    // As listed by `devices`; -1: the first suitable one, real GPUs before software
    int index = -1;
    bool validation = false;

    // For a device that shows frames in a window; without `surface` nothing of a window is asked
    // for.
    std::vector<const char*> instanceExtensions{};
    /// Makes the surface of the window. The device can present to it; it belongs to the device
    /// until takeSurface().
    std::function<VkSurfaceKHR(VkInstance)> surface{};

    // Where what is dear to make is kept for the next run (compiled kernels, hierarchies of
    // scenes); empty: nowhere
    std::filesystem::path cacheFolder{};
    // Seconds; a notice after 3 of them, lost after 10 (software devices: 30, or 300 where the
    // process gets less than half of a processor)
    double waitStep = 2;
    std::function<void(const std::string&)> notice{};  // takes "GPU busy ..."; empty: stderr does
};

struct DeviceInfo {
    std::string name, driver, type, api;
    std::vector<std::string> missing;  // what Rekindle needs and this device lacks; empty: suitable
    uint64_t heapBytes = 0;            // largest device-local heap
    uint64_t maxStorageRange = 0;
    uint32_t maxTexelElements = 0;
    uint64_t maxAllocation = 0;  // bytes of one piece of memory
    bool timestamps = false;     // else times are the host's
};

/// Every Vulkan device of this machine. Throws core::Error (noDevice) when there is no Vulkan at
/// all.
std::vector<DeviceInfo> listDevices();

/// Messages (warnings and errors) that the validation layer has printed in this process.
uint64_t validationMessages();

class Device {
public:
    /// Throws core::Error (noDevice) naming what each device lacks. With a surface the device at
    /// `index` is only preferred: one that cannot present to it gives way to another.
    explicit Device(const DeviceOptions& options);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    VkDevice get() const { return device_; }
    VkPhysicalDevice physical() const { return physical_; }
    VkInstance instance() const { return instance_; }
    VkQueue queue() const { return queue_; }
    uint32_t queueFamily() const { return queueFamily_; }
    const VkPhysicalDeviceProperties& properties() const { return properties_; }
    const VkPhysicalDeviceLimits& limits() const { return properties_.limits; }
    const DeviceInfo& info() const { return info_; }
    bool isSoftware() const { return software_; }

    /// The surface of DeviceOptions, for the caller to destroy; null when there is none or it has
    /// been taken.
    VkSurfaceKHR takeSurface() { return std::exchange(surface_, VK_NULL_HANDLE); }

    /// Records with `record`, submits and waits until done. Returns the seconds that the device was
    /// busy by its own clock, or by the host's where info().timestamps is false. `work` says what
    /// this is, for the message when it fails. Throws core::Error (deviceLost) when the device is
    /// lost or does not answer in time; from then on every call throws at once, without the driver.
    double submit(const std::function<void(VkCommandBuffer)>& record, std::string_view work = {});

    /// The next work holds a kernel that has not run before. A software device compiles it then,
    /// and what its compiler has freed goes back to the system: a third of the program's memory.
    void expectCompiling() { compiles_ = software_; }

    /// Waits for a fence of `work` that is submitted elsewhere, in the same steps and with the same
    /// end.
    void wait(VkFence fence, std::string_view work = {});

    /// checkVulkan for calls on this device: remembers its loss.
    void check(VkResult result, const char* call);

    bool lost() const { return lost_; }
    /// Throws core::Error (deviceLost) when the device is lost.
    void requireAlive() const;

    const std::filesystem::path& cacheFolder() const { return cacheFolder_; }

    /// Host memory of at least `bytes` for one copy to or from this device. It is kept for the next
    /// copy, whose content replaces this one's. Devices whose memory is mapped and cached never
    /// make it.
    Staging& staging(uint64_t bytes);

    /// Bytes of device memory that are allocated now, and the most there have been.
    uint64_t allocatedBytes = 0, peakBytes = 0;
    /// Bytes that Buffer::write has taken to the device so far.
    uint64_t writtenBytes = 0;

private:
    void open(const VkDeviceCreateInfo& create);
    void destroy();
    void record(const std::function<void(VkCommandBuffer)>& commands);
    void noticeThatItTakesLong(double seconds) const;
    [[noreturn]] void lose(const std::string& how);

    double waitStep_;
    std::function<void(const std::string&)> notice_;
    std::filesystem::path cacheFolder_;
    bool lost_ = false;
    bool compiles_ = false;  // with the next work
    std::string work_;       // what was submitted last

    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    uint32_t queueFamily_ = 0;
    VkSurfaceKHR surface_ = VK_NULL_HANDLE;
    VkPhysicalDeviceProperties properties_{};
    DeviceInfo info_;
    bool software_ = false;
    uint32_t timestampBits_ = 0;
    Handle<VkCommandPool, &Api::DestroyCommandPool> pool_;
    Handle<VkFence, &Api::DestroyFence> fence_;
    Handle<VkQueryPool, &Api::DestroyQueryPool> timestamps_;
    VkCommandBuffer commands_ = VK_NULL_HANDLE;
    std::unique_ptr<Staging> staging_;
};

/// Makes writes of compute and transfer before it visible to compute, transfer and indirect reads
/// after it.
void barrier(VkCommandBuffer commands);

}  // namespace gpu
