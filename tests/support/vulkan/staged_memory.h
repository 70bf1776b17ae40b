// A device with other types of memory than it has. Without further words its own memory cannot be
// mapped by the host, as on graphics cards without a resizable BAR, and buffers go through staging
// copies; with kAllMapped there is one type for everything, as on Mesa's software device.
#pragma once

#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/vulkan/vulkan_faults.h"

namespace tests {

class StagedMemory {
public:
    static constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    static constexpr VkMemoryPropertyFlags kMapped =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    static constexpr VkMemoryPropertyFlags kCached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;

    /// The one type of a device whose memory is the host's.
    static constexpr VkMemoryPropertyFlags kAllMapped = kLocal | kMapped | kCached;

    /// The types that the device is to have, by their properties; all are in truth the driver's
    /// first mappable type.
    explicit StagedMemory(VulkanFaults& faults,
                          std::vector<VkMemoryPropertyFlags> types = {kLocal, kMapped})
        : types_(std::move(types))
    {
        using gpu::Api;
        faults.replace<&Api::GetPhysicalDeviceMemoryProperties>(
            [this](auto driver, VkPhysicalDevice physical, VkPhysicalDeviceMemoryProperties* out) {
                driver(physical, out);
                for (uint32_t i = out->memoryTypeCount; i-- > 0;) {
                    if ((out->memoryTypes[i].propertyFlags & kMapped) == kMapped) real_ = i;
                }
                const uint32_t heap = out->memoryTypes[real_].heapIndex;
                out->memoryTypeCount = static_cast<uint32_t>(types_.size());
                for (size_t i = 0; i < types_.size(); ++i) out->memoryTypes[i] = {types_[i], heap};
            });
        faults.replace<&Api::GetBufferMemoryRequirements>(
            [this](auto driver, VkDevice device, VkBuffer buffer, VkMemoryRequirements* needs) {
                driver(device, buffer, needs);
                needs->memoryTypeBits = (1u << types_.size()) - 1;
            });
        faults.replace<&Api::AllocateMemory>([this](auto driver, VkDevice device,
                                                    const VkMemoryAllocateInfo* info,
                                                    auto* allocator, VkDeviceMemory* out) {
            if (exhausted.contains(info->memoryTypeIndex)) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
            allocated.push_back(info->memoryTypeIndex);
            VkMemoryAllocateInfo changed = *info;
            changed.memoryTypeIndex = real_;
            const VkResult result = driver(device, &changed, allocator, out);
            hidden_.erase(*out);
            if ((types_.at(info->memoryTypeIndex) & kMapped) == 0) hidden_.insert(*out);
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

    /// Types of which there is nothing left, and those of all allocations so far.
    std::set<uint32_t> exhausted;
    std::vector<uint32_t> allocated;

private:
    std::vector<VkMemoryPropertyFlags> types_;
    uint32_t real_ = 0;
    std::set<VkDeviceMemory> hidden_;
};

}  // namespace tests
