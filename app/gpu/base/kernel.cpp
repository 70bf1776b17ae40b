// The pipeline layout of a kernel: the shared sets as every kernel has them, its own as it declares
// it.
#include "app/gpu/base/kernel.h"

#include <algorithm>
#include <chrono>

#include "core/base/memory.h"

namespace gpu {

KernelBase::KernelBase(Device& device, std::span<const uint32_t> spirv,
                       const SharedLayouts* layouts, size_t pushBytes)
    : device_(device), spirv_(spirv), pushBytes_(static_cast<uint32_t>(pushBytes)),
      own_(device, readKernelInterface(spirv).ofSet(shared::kSetKernel))
{
    const KernelInterface wants = readKernelInterface(spirv);
    usesScene_ = !wants.ofSet(shared::kSetScene).empty();
    usesFrame_ = !wants.ofSet(shared::kSetFrame).empty();
    CHECK(wants.pushBytes == pushBytes_);
    CHECK(layouts != nullptr || (!usesScene_ && !usesFrame_));

    const SetLayout nothing(device, {});  // where a set is not used; a layout need not outlive this
    const std::array<VkDescriptorSetLayout, shared::kSetCount> sets{
        usesScene_ ? layouts->scene.get() : nothing.get(),
        usesFrame_ ? layouts->frame.get() : nothing.get(), own_.get()};
    const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, pushBytes_};
    VkPipelineLayoutCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    create.setLayoutCount = sets.size();
    create.pSetLayouts = sets.data();
    create.pushConstantRangeCount = 1;
    create.pPushConstantRanges = &push;
    VkPipelineLayout object;
    VK_CHECK(vk.CreatePipelineLayout(device.get(), &create, nullptr, &object));
    layout_ = {device.get(), object};
}

bool KernelBase::isCompiled(std::span<const uint32_t> constants) const
{
    const std::vector<uint32_t> key(constants.begin(), constants.end());
    if (beside_.valid() && besideKey_ == key)
        return beside_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    return pipelines_.contains(key);
}

const Pipeline& KernelBase::pipeline(uint32_t first, std::span<const uint32_t> constants)
{
    const std::vector<uint32_t> key(constants.begin(), constants.end());
    const auto found = pipelines_.find(key);
    if (found != pipelines_.end()) return found->second;
    device_.requireAlive();
    Pipeline made = beside_.valid() && besideKey_ == key
                        ? beside_.get()
                        : Pipeline(device_, layout_.get(), spirv_, {first, constants});
    return pipelines_.emplace(key, std::move(made)).first->second;
}

/// One at a time: of what is under way for other constants, the end is waited for and forgotten.
void KernelBase::compileBeside(uint32_t first, std::span<const uint32_t> constants)
{
    std::vector<uint32_t> key(constants.begin(), constants.end());
    if (pipelines_.contains(key) || (beside_.valid() && besideKey_ == key)) return;
    device_.requireAlive();
    besideKey_ = key;
    beside_ = std::async(std::launch::async, [&device = device_, layout = layout_.get(),
                                              spirv = spirv_, first, key = std::move(key)] {
        Pipeline made(device, layout, spirv, {first, key});
        // Before the other half of compiling, which comes with the first dispatch (Device::submit).
        if (device.isSoftware()) core::giveBackMemory();
        return made;
    });
}

void KernelBase::requireGroups(uint32_t groupsX, uint32_t groupsY) const
{
    const auto& most = device_.limits().maxComputeWorkGroupCount;
    CHECK(groupsX <= most[0] && groupsY <= most[1]);
}

void KernelBase::prepare(VkCommandBuffer commands, const Pipeline& pipeline, const KernelSets& sets,
                         const void* push) const
{
    if (pipeline.isFirstUse()) device_.expectCompiling();
    vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
    const auto bind = [&](uint32_t number, const DescriptorSet* set) {
        CHECK(set != nullptr);
        const VkDescriptorSet object = set->get();
        vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), number, 1,
                                 &object, 0, nullptr);
    };
    if (usesScene_) bind(shared::kSetScene, sets.scene);
    if (usesFrame_) bind(shared::kSetFrame, sets.frame);
    bind(shared::kSetKernel, sets.own);
    vk.CmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0, pushBytes_, push);
}

}  // namespace gpu
