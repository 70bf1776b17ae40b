// Descriptor plumbing: fixed numbers, no reflection, everything bound once per scene.
#include "app/gpu/pipeline.h"

namespace gpu {

VkFormat texelFormat(uint32_t binding)
{
    switch (binding) {
    case shared::kBindTexels: return VK_FORMAT_R16G16B16A16_SFLOAT;
    case shared::kBindEnvironment: return VK_FORMAT_R32G32B32A32_SFLOAT;
    case shared::kBindEmitterCdf:
    case shared::kBindEnvironmentCdf: return VK_FORMAT_R32_SFLOAT;
    default: return VK_FORMAT_R32G32B32A32_UINT;
    }
}

namespace {

VkDescriptorType typeOf(uint32_t binding)
{
    if (binding < shared::kTexelBindings) return VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
    return binding == shared::kBindFrame ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

}  // namespace

KernelLayout::KernelLayout(const Device& device)
{
    std::array<VkDescriptorSetLayoutBinding, shared::kBindingCount> bindings{};
    for (uint32_t i = 0; i < shared::kBindingCount; ++i) {
        bindings[i].binding = i;
        bindings[i].descriptorType = typeOf(i);
        bindings[i].descriptorCount = 1;
        bindings[i].stageFlags = VK_SHADER_STAGE_COMPUTE_BIT;
    }
    VkDescriptorSetLayoutCreateInfo set{};
    set.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    set.bindingCount = bindings.size();
    set.pBindings = bindings.data();
    VkDescriptorSetLayout setObject;
    VK_CHECK(vk.CreateDescriptorSetLayout(device.get(), &set, nullptr, &setObject));
    set_ = {device.get(), setObject};

    const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, 128};
    VkPipelineLayoutCreateInfo layout{};
    layout.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &setObject;
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &push;
    VkPipelineLayout layoutObject;
    VK_CHECK(vk.CreatePipelineLayout(device.get(), &layout, nullptr, &layoutObject));
    layout_ = {device.get(), layoutObject};
}

Pipeline::Pipeline(const Device& device, const KernelLayout& layout, std::span<const uint32_t> spirv,
                   const Specialization& specialization)
{
    VkShaderModuleCreateInfo module{};
    module.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
    module.codeSize = spirv.size_bytes();
    module.pCode = spirv.data();
    VkShaderModule moduleObject;
    VK_CHECK(vk.CreateShaderModule(device.get(), &module, nullptr, &moduleObject));
    const Handle<VkShaderModule, &Api::DestroyShaderModule> owner(device.get(), moduleObject);

    const std::array<VkSpecializationMapEntry, 2> entries{
        VkSpecializationMapEntry{0, offsetof(Specialization, features), 4},
        VkSpecializationMapEntry{shared::kSpecializeSampler, offsetof(Specialization, sampler), 4}};
    const VkSpecializationInfo constants{entries.size(), entries.data(), sizeof(specialization), &specialization};
    VkComputePipelineCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
    create.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    create.stage.module = moduleObject;
    create.stage.pName = "main";
    create.stage.pSpecializationInfo = &constants;
    create.layout = layout.get();
    VkPipeline object;
    VK_CHECK(vk.CreateComputePipelines(device.get(), VK_NULL_HANDLE, 1, &create, nullptr, &object));
    pipeline_ = {device.get(), object};
}

Bindings::Bindings(Device& device, const KernelLayout& layout)
    : device_(device.get()), nothing_(device, "placeholder", 256),
      noTexels_{Buffer(device, "placeholder", 16, VK_FORMAT_R32G32B32A32_UINT),
                Buffer(device, "placeholder", 16, VK_FORMAT_R16G16B16A16_SFLOAT),
                Buffer(device, "placeholder", 16, VK_FORMAT_R32_SFLOAT)}
{
    const std::array<VkDescriptorPoolSize, 3> sizes{
        VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, shared::kTexelBindings},
        VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1},
        VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, shared::kBindingCount}};
    VkDescriptorPoolCreateInfo pool{};
    pool.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
    pool.maxSets = 1;
    pool.poolSizeCount = sizes.size();
    pool.pPoolSizes = sizes.data();
    VkDescriptorPool poolObject;
    VK_CHECK(vk.CreateDescriptorPool(device_, &pool, nullptr, &poolObject));
    pool_ = {device_, poolObject};
    VkDescriptorSetLayout setLayout = layout.set();
    VkDescriptorSetAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
    allocate.descriptorPool = poolObject;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &setLayout;
    VK_CHECK(vk.AllocateDescriptorSets(device_, &allocate, &set_));
    for (uint32_t i = 0; i < shared::kBindingCount; ++i) unbind(i);
}

void Bindings::unbind(uint32_t binding)
{
    if (binding >= shared::kTexelBindings) {
        bind(binding, nothing_);
        return;
    }
    const VkFormat format = texelFormat(binding);
    bind(binding, noTexels_[format == VK_FORMAT_R32G32B32A32_UINT ? 0 : format == VK_FORMAT_R32_SFLOAT ? 2 : 1]);
}

void Bindings::bind(uint32_t binding, const Buffer& buffer)
{
    const VkBufferView view = buffer.view();
    const VkDescriptorBufferInfo range{buffer.get(), 0, buffer.bytes()};
    VkWriteDescriptorSet write{};
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = set_;
    write.dstBinding = binding;
    write.descriptorCount = 1;
    write.descriptorType = typeOf(binding);
    write.pBufferInfo = &range;
    write.pTexelBufferView = &view;
    vk.UpdateDescriptorSets(device_, 1, &write, 0, nullptr);
}

void Bindings::use(VkCommandBuffer commands, const KernelLayout& layout) const
{
    vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout.get(), 0, 1, &set_, 0, nullptr);
}

}  // namespace gpu
