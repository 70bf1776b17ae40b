// Watches what commands do to buffers and says where a barrier is missing: the validation layer of
// bookworm does not see two dispatches that write the same buffer, nor anything between submissions
// unless it is told to. What a dispatch reads and writes is taken from its SPIR-V (every access in
// the text, reached or not) and from what is bound; the rules are those of the specification for
// execution and memory dependencies on one queue. Images, and what the host does to mapped memory,
// are not watched.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/vulkan/vulkan_faults.h"

namespace tests {

/// One use of one buffer by one command.
struct BufferUse {
    uint64_t buffer = 0;  // counted from 1 in the order of making: handles are used again
    VkPipelineStageFlags stage = 0;
    VkAccessFlags access = 0;  // one bit
    bool writes() const
    {
        return (access & (VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT)) != 0;
    }
};

struct WatchedCommand {
    std::string name;
    std::vector<BufferUse> uses;  // empty for barriers
    VkPipelineStageFlags from = 0, to = 0;
    VkAccessFlags fromAccess = 0, toAccess = 0;
    bool isBarrier() const { return from != 0; }
};

/// The pairs of commands between which a dependency is missing, in words. The barrier `leftOut`
/// counts as absent.
std::vector<std::string> missingBarriers(const std::vector<WatchedCommand>& commands,
                                         size_t leftOut = SIZE_MAX);

/// A descriptor's set and its binding number in it.
using SetBinding = std::pair<uint32_t, uint32_t>;

/// The VkAccessFlags of a kernel's text to each of its storage, uniform and texel buffers.
std::map<SetBinding, VkAccessFlags> kernelAccess(std::span<const uint32_t> spirv);

/// Makes the list of all commands that are submitted while it lives. Works for devices that are
/// made while it lives.
class BarrierWatch {
public:
    explicit BarrierWatch(VulkanFaults& faults);

    /// In the order of submission.
    const std::vector<WatchedCommand>& commands() const { return submitted_; }

private:
    void watchObjects(VulkanFaults& faults);
    void watchCommands(VulkanFaults& faults);
    void watchCopies(VulkanFaults& faults);
    std::vector<BufferUse> dispatchUses(VkCommandBuffer commands) const;
    void add(VkCommandBuffer commands, WatchedCommand command)
    {
        recorded_[commands].push_back(std::move(command));
    }

    uint64_t serial(VkBuffer buffer) const;

    std::map<VkBuffer, uint64_t> serials_;
    uint64_t buffersMade_ = 0;
    std::map<VkShaderModule, std::map<SetBinding, VkAccessFlags>> modules_;
    std::map<VkPipeline, std::map<SetBinding, VkAccessFlags>> pipelines_;
    std::map<VkBufferView, VkBuffer> views_;
    std::map<VkDescriptorSet, std::map<uint32_t, VkBuffer>> sets_;
    std::map<VkCommandBuffer, VkPipeline> boundPipeline_;
    std::map<VkCommandBuffer, std::map<uint32_t, VkDescriptorSet>> boundSets_;
    std::map<VkCommandBuffer, std::vector<WatchedCommand>> recorded_;
    std::vector<WatchedCommand> submitted_;
};

}  // namespace tests
