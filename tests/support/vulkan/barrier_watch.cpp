// Reading SPIR-V, listing commands, and the rules of dependencies. See barrier_watch.h.
#include "tests/support/vulkan/barrier_watch.h"

#include <algorithm>

namespace tests {

namespace {

using gpu::Api;

constexpr VkPipelineStageFlags kComputeStage = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
constexpr VkPipelineStageFlags kTransferStage = VK_PIPELINE_STAGE_TRANSFER_BIT;
constexpr VkPipelineStageFlags kIndirectStage = VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT;

/// A stage as source stands for itself and what is logically earlier in its pipeline.
VkPipelineStageFlags asSource(VkPipelineStageFlags stages)
{
    if ((stages & (VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT)) != 0)
        return ~0u;
    return (stages & kComputeStage) != 0 ? stages | kIndirectStage : stages;
}

/// As destination: for itself and what is logically later.
VkPipelineStageFlags asDestination(VkPipelineStageFlags stages)
{
    if ((stages & (VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT)) != 0)
        return ~0u;
    return (stages & kIndirectStage) != 0 ? stages | kComputeStage : stages;
}

/// VK_ACCESS_MEMORY_* stand for every access of their kind.
VkAccessFlags allOf(VkAccessFlags access)
{
    if ((access & VK_ACCESS_MEMORY_WRITE_BIT) != 0)
        access |= VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    if ((access & VK_ACCESS_MEMORY_READ_BIT) != 0) {
        access |= VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                  VK_ACCESS_UNIFORM_READ_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT;
    }
    return access;
}

/// A use that later ones must be ordered after, and what barriers have done about it so far.
struct Past {
    BufferUse use;
    size_t command;
    VkPipelineStageFlags ordered = 0;  // stages of later commands that wait for it
    bool available = false;
    std::vector<std::pair<VkPipelineStageFlags, VkAccessFlags>> visible;
};

void apply(const WatchedCommand& barrier, Past& past)
{
    const VkPipelineStageFlags from = asSource(barrier.from);
    if ((from & (past.use.stage | past.ordered)) == 0) return;
    past.ordered |= asDestination(barrier.to);
    if ((from & past.use.stage) != 0 && (allOf(barrier.fromAccess) & past.use.access) != 0)
        past.available = true;
    if (past.available) past.visible.emplace_back(barrier.to, allOf(barrier.toAccess));
}

bool isOrdered(const Past& past, const BufferUse& use)
{
    if (!past.use.writes()) return !use.writes() || (past.ordered & use.stage) != 0;
    return std::any_of(past.visible.begin(), past.visible.end(), [&use](const auto& to) {
        return (to.first & use.stage) != 0 && (to.second & use.access) != 0;
    });
}

std::string describe(const WatchedCommand& command, const BufferUse& use)
{
    return command.name + (use.writes() ? " (writes)" : " (reads)");
}

// SPIR-V, of which this much is needed.
enum : uint32_t {
    kOpEntryPoint = 15,
    kOpVariable = 59,
    kOpLoad = 61,
    kOpStore = 62,
    kOpAccessChain = 65,
    kOpInBoundsAccessChain = 66,
    kOpDecorate = 71,
    kOpCopyObject = 83,
    kOpImageWrite = 99,
    kOpAtomicLoad = 227,
    kOpAtomicStore = 228,
    kOpAtomicExchange = 229,
    kOpAtomicXor = 242,
    kDecorationBinding = 33,
    kDecorationSet = 34
};

}  // namespace

std::map<SetBinding, VkAccessFlags> kernelAccess(std::span<const uint32_t> spirv)
{
    // Of ids: set, binding number, storage class, variable
    std::map<uint32_t, uint32_t> set, binding, storage, root;
    std::map<uint32_t, VkAccessFlags> access;  // of variables
    const auto note = [&](uint32_t pointer, VkAccessFlags flags) {
        const auto variable = root.find(pointer);
        if (variable != root.end()) access[variable->second] |= flags;
    };
    const auto read = [&](uint32_t pointer) {
        const auto variable = root.find(pointer);
        if (variable == root.end()) return;
        note(pointer, storage[variable->second] == 2 ? VK_ACCESS_UNIFORM_READ_BIT
                                                     : VK_ACCESS_SHADER_READ_BIT);
    };
    for (size_t at = 5; at < spirv.size();) {
        const uint32_t code = spirv[at] & 0xffffu, length = spirv[at] >> 16u;
        const auto word = [&](uint32_t i) { return spirv[at + i]; };
        if (code == kOpDecorate && word(2) == kDecorationBinding) binding[word(1)] = word(3);
        if (code == kOpDecorate && word(2) == kDecorationSet) set[word(1)] = word(3);
        if (code == kOpVariable) {
            storage[word(2)] = word(3);
            root[word(2)] = word(2);
        }
        if (code == kOpAccessChain || code == kOpInBoundsAccessChain || code == kOpCopyObject) {
            if (root.contains(word(3))) root[word(2)] = root[word(3)];
        }
        if (code == kOpLoad) {
            read(word(3));
            if (root.contains(word(3)))
                root[word(2)] = root[word(3)];  // an image that was loaded may be written
        }
        if (code == kOpStore || code == kOpImageWrite || code == kOpAtomicStore)
            note(word(1), VK_ACCESS_SHADER_WRITE_BIT);
        if (code == kOpAtomicLoad) read(word(3));
        if (code >= kOpAtomicExchange && code <= kOpAtomicXor) {
            note(word(3), VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT);
        }
        at += length;
    }
    std::map<SetBinding, VkAccessFlags> result;
    for (const auto& [variable, flags] : access) {
        if (binding.contains(variable)) result[{set[variable], binding[variable]}] |= flags;
    }
    return result;
}

std::vector<std::string> missingBarriers(const std::vector<WatchedCommand>& commands,
                                         size_t leftOut)
{
    std::map<uint64_t, std::vector<Past>> pasts;
    std::vector<std::string> missing;
    for (size_t i = 0; i < commands.size(); ++i) {
        const WatchedCommand& command = commands[i];
        if (command.isBarrier()) {
            if (i == leftOut) continue;
            for (auto& [buffer, list] : pasts) {
                for (Past& past : list) apply(command, past);
            }
            continue;
        }
        for (const BufferUse& use : command.uses) {
            std::vector<Past>& list = pasts[use.buffer];
            for (const Past& past : list) {
                if (past.command == i || isOrdered(past, use)) continue;
                missing.push_back("command " + std::to_string(i) + ", " + describe(command, use) +
                                  ", after command " + std::to_string(past.command) + ", " +
                                  describe(commands[past.command], past.use));
            }
        }
        for (const BufferUse& use : command.uses) {
            std::vector<Past>& list = pasts[use.buffer];
            // What is ordered after a write is ordered after everything before that write.
            if (use.writes())
                std::erase_if(list, [i](const Past& past) { return past.command != i; });
            list.push_back({use, i, 0, false, {}});
        }
    }
    return missing;
}

BarrierWatch::BarrierWatch(VulkanFaults& faults)
{
    watchObjects(faults);
    watchCommands(faults);
    watchCopies(faults);
}

void BarrierWatch::watchObjects(VulkanFaults& faults)
{
    faults.replace<&Api::CreateShaderModule>([this](auto driver, VkDevice device,
                                                    const VkShaderModuleCreateInfo* info,
                                                    auto* allocator, VkShaderModule* out) {
        const VkResult result = driver(device, info, allocator, out);
        if (result == VK_SUCCESS) modules_[*out] = kernelAccess({info->pCode, info->codeSize / 4});
        return result;
    });
    faults.replace<&Api::CreateComputePipelines>(
        [this](auto driver, VkDevice device, VkPipelineCache cache, uint32_t count,
               const VkComputePipelineCreateInfo* infos, auto* allocator, VkPipeline* out) {
            const VkResult result = driver(device, cache, count, infos, allocator, out);
            for (uint32_t i = 0; i < count && result == VK_SUCCESS; ++i)
                pipelines_[out[i]] = modules_[infos[i].stage.module];
            return result;
        });
    faults.replace<&Api::CreateBuffer>([this](auto driver, VkDevice device,
                                              const VkBufferCreateInfo* info, auto* allocator,
                                              VkBuffer* out) {
        const VkResult result = driver(device, info, allocator, out);
        if (result == VK_SUCCESS) serials_[*out] = ++buffersMade_;
        return result;
    });
    faults.replace<&Api::CreateBufferView>([this](auto driver, VkDevice device,
                                                  const VkBufferViewCreateInfo* info,
                                                  auto* allocator, VkBufferView* out) {
        const VkResult result = driver(device, info, allocator, out);
        if (result == VK_SUCCESS) views_[*out] = info->buffer;
        return result;
    });
    faults.replace<&Api::UpdateDescriptorSets>(
        [this](auto driver, VkDevice device, uint32_t count, const VkWriteDescriptorSet* writes,
               uint32_t copies, const VkCopyDescriptorSet* copied) {
            driver(device, count, writes, copies, copied);
            for (uint32_t i = 0; i < count; ++i) {
                const VkWriteDescriptorSet& w = writes[i];
                const bool texels = w.descriptorType == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
                const bool buffer = w.descriptorType == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER ||
                                    w.descriptorType == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
                if (texels) sets_[w.dstSet][w.dstBinding] = views_[w.pTexelBufferView[0]];
                if (buffer) sets_[w.dstSet][w.dstBinding] = w.pBufferInfo[0].buffer;
            }
        });
}

uint64_t BarrierWatch::serial(VkBuffer buffer) const
{
    const auto entry = serials_.find(buffer);
    return entry != serials_.end() ? entry->second : 0;
}

std::vector<BufferUse> BarrierWatch::dispatchUses(VkCommandBuffer commands) const
{
    std::vector<BufferUse> uses;
    const auto pipeline = boundPipeline_.find(commands);
    const auto sets = boundSets_.find(commands);
    if (pipeline == boundPipeline_.end() || sets == boundSets_.end()) return uses;
    for (const auto& [place, access] : pipelines_.at(pipeline->second)) {
        const auto& [number, binding] = place;
        const auto set = sets->second.find(number);
        if (set == sets->second.end()) continue;
        const auto bound = sets_.find(set->second);
        if (bound == sets_.end() || !bound->second.contains(binding)) continue;
        for (const VkAccessFlags bit :
             {VK_ACCESS_SHADER_READ_BIT, VK_ACCESS_UNIFORM_READ_BIT, VK_ACCESS_SHADER_WRITE_BIT}) {
            if ((access & bit) != 0)
                uses.push_back({serial(bound->second.at(binding)), kComputeStage, bit});
        }
    }
    return uses;
}

void BarrierWatch::watchCommands(VulkanFaults& faults)
{
    faults.replace<&Api::BeginCommandBuffer>(
        [this](auto driver, VkCommandBuffer c, const VkCommandBufferBeginInfo* info) {
            recorded_[c].clear();
            boundPipeline_.erase(c);
            boundSets_.erase(c);
            return driver(c, info);
        });
    faults.replace<&Api::CmdBindPipeline>(
        [this](auto driver, VkCommandBuffer c, VkPipelineBindPoint point, VkPipeline p) {
            if (point == VK_PIPELINE_BIND_POINT_COMPUTE) boundPipeline_[c] = p;
            driver(c, point, p);
        });
    faults.replace<&Api::CmdBindDescriptorSets>(
        [this](auto driver, VkCommandBuffer c, VkPipelineBindPoint point, VkPipelineLayout layout,
               uint32_t first, uint32_t count, const VkDescriptorSet* sets, uint32_t offsets,
               const uint32_t* offset) {
            for (uint32_t i = 0; i < count && point == VK_PIPELINE_BIND_POINT_COMPUTE; ++i)
                boundSets_[c][first + i] = sets[i];
            driver(c, point, layout, first, count, sets, offsets, offset);
        });
    faults.replace<&Api::CmdDispatch>(
        [this](auto driver, VkCommandBuffer c, uint32_t x, uint32_t y, uint32_t z) {
            add(c, {"dispatch", dispatchUses(c)});
            driver(c, x, y, z);
        });
    faults.replace<&Api::CmdDispatchIndirect>(
        [this](auto driver, VkCommandBuffer c, VkBuffer buffer, VkDeviceSize offset) {
            WatchedCommand command{"indirect dispatch", dispatchUses(c)};
            command.uses.push_back(
                {serial(buffer), kIndirectStage, VK_ACCESS_INDIRECT_COMMAND_READ_BIT});
            add(c, std::move(command));
            driver(c, buffer, offset);
        });
    faults.replace<&Api::CmdPipelineBarrier>(
        [this](auto driver, VkCommandBuffer c, VkPipelineStageFlags from, VkPipelineStageFlags to,
               VkDependencyFlags flags, uint32_t count, const VkMemoryBarrier* memory,
               uint32_t buffers, const VkBufferMemoryBarrier* buffer, uint32_t images,
               const VkImageMemoryBarrier* image) {
            WatchedCommand command{"barrier", {}, from, to, 0, 0};
            if (count > 0) command.fromAccess = memory[0].srcAccessMask;
            if (count > 0) command.toAccess = memory[0].dstAccessMask;
            add(c, std::move(command));
            driver(c, from, to, flags, count, memory, buffers, buffer, images, image);
        });
    faults.replace<&Api::QueueSubmit>([this](auto driver, VkQueue queue, uint32_t count,
                                             const VkSubmitInfo* submits, VkFence fence) {
        for (uint32_t i = 0; i < count; ++i) {
            for (uint32_t k = 0; k < submits[i].commandBufferCount; ++k) {
                const auto& list = recorded_[submits[i].pCommandBuffers[k]];
                submitted_.insert(submitted_.end(), list.begin(), list.end());
            }
        }
        return driver(queue, count, submits, fence);
    });
}

void BarrierWatch::watchCopies(VulkanFaults& faults)
{
    faults.replace<&Api::CmdFillBuffer>([this](auto driver, VkCommandBuffer c, VkBuffer buffer,
                                               VkDeviceSize offset, VkDeviceSize size,
                                               uint32_t data) {
        add(c, {"fill", {{serial(buffer), kTransferStage, VK_ACCESS_TRANSFER_WRITE_BIT}}});
        driver(c, buffer, offset, size, data);
    });
    faults.replace<&Api::CmdUpdateBuffer>([this](auto driver, VkCommandBuffer c, VkBuffer buffer,
                                                 VkDeviceSize offset, VkDeviceSize size,
                                                 const void* data) {
        add(c, {"update", {{serial(buffer), kTransferStage, VK_ACCESS_TRANSFER_WRITE_BIT}}});
        driver(c, buffer, offset, size, data);
    });
    faults.replace<&Api::CmdCopyBuffer>([this](auto driver, VkCommandBuffer c, VkBuffer from,
                                               VkBuffer to, uint32_t count,
                                               const VkBufferCopy* regions) {
        add(c, {"copy",
                {{serial(from), kTransferStage, VK_ACCESS_TRANSFER_READ_BIT},
                 {serial(to), kTransferStage, VK_ACCESS_TRANSFER_WRITE_BIT}}});
        driver(c, from, to, count, regions);
    });
    faults.replace<&Api::CmdCopyBufferToImage>([this](auto driver, VkCommandBuffer c, VkBuffer from,
                                                      VkImage to, VkImageLayout layout,
                                                      uint32_t count,
                                                      const VkBufferImageCopy* regions) {
        add(c, {"copy to an image", {{serial(from), kTransferStage, VK_ACCESS_TRANSFER_READ_BIT}}});
        driver(c, from, to, layout, count, regions);
    });
    faults.replace<&Api::CmdCopyImageToBuffer>(
        [this](auto driver, VkCommandBuffer c, VkImage from, VkImageLayout layout, VkBuffer to,
               uint32_t count, const VkBufferImageCopy* regions) {
            add(c, {"copy from an image",
                    {{serial(to), kTransferStage, VK_ACCESS_TRANSFER_WRITE_BIT}}});
            driver(c, from, layout, to, count, regions);
        });
}

}  // namespace tests
