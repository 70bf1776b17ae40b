// A device whose own memory the host cannot map, as graphics cards without a resizable BAR have it:
// Mesa's software device under a mask. Buffers then go through staging copies.
#pragma once

#include <set>

#include <gtest/gtest.h>

#include "tests/support/vulkan_faults.h"

namespace tests {

class StagedMemory {
public:
    /// Type 0 is the device's and not mappable, type 1 the host's; both are in truth the driver's
    /// first mappable type.
    explicit StagedMemory(VulkanFaults& faults)
    {
        using gpu::Api;
        faults.replace<&Api::GetPhysicalDeviceMemoryProperties>(
            [this](auto driver, VkPhysicalDevice physical, VkPhysicalDeviceMemoryProperties* out) {
                driver(physical, out);
                const VkMemoryPropertyFlags mapped =
                    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
                for (uint32_t i = out->memoryTypeCount; i-- > 0;) {
                    if ((out->memoryTypes[i].propertyFlags & mapped) == mapped) real_ = i;
                }
                const uint32_t heap = out->memoryTypes[real_].heapIndex;
                out->memoryTypeCount = 2;
                out->memoryTypes[0] = {VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, heap};
                out->memoryTypes[1] = {mapped, heap};
            });
        faults.replace<&Api::GetBufferMemoryRequirements>(
            [](auto driver, VkDevice device, VkBuffer buffer, VkMemoryRequirements* needs) {
                driver(device, buffer, needs);
                needs->memoryTypeBits = 3;
            });
        faults.replace<&Api::AllocateMemory>([this](auto driver, VkDevice device,
                                                    const VkMemoryAllocateInfo* info,
                                                    auto* allocator, VkDeviceMemory* out) {
            VkMemoryAllocateInfo changed = *info;
            changed.memoryTypeIndex = real_;
            const VkResult result = driver(device, &changed, allocator, out);
            hidden_.erase(*out);
            if (info->memoryTypeIndex == 0) hidden_.insert(*out);
            return result;
        });
        faults.replace<&Api::MapMemory>([this](auto driver, VkDevice device, VkDeviceMemory memory,
                                               VkDeviceSize offset, VkDeviceSize size,
                                               VkMemoryMapFlags flags, void** out) {
            if (hidden_.contains(memory)) {
                ADD_FAILURE() << "memory that cannot be mapped was";
                return VK_ERROR_MEMORY_MAP_FAILED;
            }
            return driver(device, memory, offset, size, flags, out);
        });
    }
    StagedMemory(const StagedMemory&) = delete;
    StagedMemory& operator=(const StagedMemory&) = delete;

private:
    uint32_t real_ = 0;
    std::set<VkDeviceMemory> hidden_;
};

}  // namespace tests
