// Move-only owners of Vulkan objects, and the one check through which every Vulkan call goes.
#pragma once

#include <string>
#include <utility>

#include "app/gpu/base/api.h"
#include "core/base/check.h"

namespace gpu {

/// "VK_ERROR_DEVICE_LOST" and the like.
const char* resultName(VkResult result);

/// Leaves a device to itself whose work may run for ever: from now on nothing of it is destroyed,
/// because the work may still use it.
void abandon(VkDevice device);
bool isAbandoned(VkDevice device);
bool anyAbandoned();

/// Throws core::Error with the text of the call; lost devices and exhausted memory get their own
/// exit code.
inline void checkVulkan(VkResult result, const char* call)
{
    if (result >= 0) return;
    const bool lost = result == VK_ERROR_DEVICE_LOST || result == VK_ERROR_OUT_OF_DEVICE_MEMORY ||
                      result == VK_ERROR_OUT_OF_HOST_MEMORY;
    throw core::Error(std::string("Vulkan: ") + call + " gave " + resultName(result),
                      lost ? core::ExitCode::deviceLost : core::ExitCode::failure);
}
#define VK_CHECK(call) ::gpu::checkVulkan((call), #call)

/// Owns one device-level object; Destroy is the entry of the table that takes (device, object,
/// allocator).
template <class T, auto Destroy> class Handle {
public:
    Handle() = default;
    Handle(VkDevice device, T object) : device_(device), object_(object) {}
    Handle(Handle&& other) noexcept
        : device_(other.device_), object_(std::exchange(other.object_, VK_NULL_HANDLE))
    {}
    Handle& operator=(Handle&& other) noexcept
    {
        std::swap(device_, other.device_);
        std::swap(object_, other.object_);
        return *this;
    }
    ~Handle()
    {
        if (object_ != VK_NULL_HANDLE && !isAbandoned(device_))
            (vk.*Destroy)(device_, object_, nullptr);
    }
    T get() const { return object_; }
    explicit operator bool() const { return object_ != VK_NULL_HANDLE; }

private:
    VkDevice device_ = VK_NULL_HANDLE;
    T object_ = VK_NULL_HANDLE;
};

}  // namespace gpu
