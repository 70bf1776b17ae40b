// Instances, what their devices have and lack, and the choice among them.
#pragma once

#include <optional>
#include <vector>

#include "app/gpu/base/device.h"

namespace gpu {

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
                                       VkQueueFamilyProperties* properties);

/// Throws core::Error (noDevice) when there is no driver, or not what the options ask for.
VkInstance makeInstance(const DeviceOptions& options);

std::vector<VkPhysicalDevice> physicalDevices(VkInstance instance);

/// What a device is, and what it lacks of what Rekindle uses (with a `surface`: also of what
/// showing frames takes).
DeviceInfo describe(VkPhysicalDevice physical, VkSurfaceKHR surface = VK_NULL_HANDLE);

/// The device asked for, or the best suitable one. Throws core::Error (noDevice) with what each of
/// them lacks.
VkPhysicalDevice chooseDevice(const std::vector<VkPhysicalDevice>& devices, int index,
                              VkSurfaceKHR surface);

}  // namespace gpu
