// Descriptor plumbing: fixed numbers, no reflection, everything bound once per scene.
#include "app/gpu/base/pipeline.h"

#include <algorithm>

#include "app/gpu/base/pipeline_cache.h"

namespace gpu {

VkFormat texelFormat(uint32_t binding)
{
    switch (binding) {
    case shared::kBindTexels:
        return VK_FORMAT_R16G16B16A16_SFLOAT;
    case shared::kBindEnvironment:
        return VK_FORMAT_R32G32B32A32_SFLOAT;
    case shared::kBindEmitterCdf:
    case shared::kBindEnvironmentCdf:
        return VK_FORMAT_R32_SFLOAT;
    default:
        return VK_FORMAT_R32G32B32A32_UINT;
    }
}

namespace {

VkDescriptorType typeOf(uint32_t binding)
{
    if (binding < shared::kTexelBindings) return VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
    return binding == shared::kBindFrame ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER
                                         : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
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

namespace {

using CacheHandle = Handle<VkPipelineCache, &Api::DestroyPipelineCache>;

CacheKey keyOf(const Device& device, std::span<const uint32_t> spirv,
               const Specialization& specialization)
{
    const VkPhysicalDeviceProperties& p = device.properties();
    CacheKey key;
    std::copy(std::begin(p.pipelineCacheUUID), std::end(p.pipelineCacheUUID),
              key.cacheUuid.begin());
    key.vendor = p.vendorID;
    key.device = p.deviceID;
    key.driverVersion = p.driverVersion;
    key.kernel =
        hashBytes(std::as_bytes(std::span(&specialization, 1)), hashBytes(std::as_bytes(spirv)));
    return key;
}

/// The driver's cache with these bytes in it; none when the driver makes none.
CacheHandle driverCache(const Device& device, std::span<const std::byte> data)
{
    VkPipelineCacheCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
    create.initialDataSize = data.size();
    create.pInitialData = data.data();
    VkPipelineCache object = VK_NULL_HANDLE;
    if (vk.CreatePipelineCache(device.get(), &create, nullptr, &object) != VK_SUCCESS) return {};
    return {device.get(), object};
}

std::vector<std::byte> contents(const Device& device, const CacheHandle& cache)
{
    size_t bytes = 0;
    if (!cache || vk.GetPipelineCacheData(device.get(), cache.get(), &bytes, nullptr) != VK_SUCCESS)
        return {};
    std::vector<std::byte> data(bytes);
    if (vk.GetPipelineCacheData(device.get(), cache.get(), &bytes, data.data()) != VK_SUCCESS)
        return {};
    data.resize(bytes);
    // Mesa's software device keeps nothing but the header (it has a cache of its own): not worth a
    // file.
    if (bytes <= sizeof(VkPipelineCacheHeaderVersionOne)) return {};
    return data;
}

}  // namespace

Pipeline::Pipeline(const Device& device, const KernelLayout& layout,
                   std::span<const uint32_t> spirv, const Specialization& specialization)
{
    device.requireAlive();
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
    const VkSpecializationInfo constants{entries.size(), entries.data(), sizeof(specialization),
                                         &specialization};
    VkComputePipelineCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
    create.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    create.stage.module = moduleObject;
    create.stage.pName = "main";
    create.stage.pSpecializationInfo = &constants;
    create.layout = layout.get();

    const bool keeps = !device.cacheFolder().empty();
    const CacheKey key = keeps ? keyOf(device, spirv, specialization) : CacheKey();
    const std::vector<std::byte> kept =
        keeps ? readCache(device.cacheFolder(), key) : std::vector<std::byte>();
    const CacheHandle cache = keeps ? driverCache(device, kept) : CacheHandle();
    VkPipeline object = VK_NULL_HANDLE;
    VkResult result =
        vk.CreateComputePipelines(device.get(), cache.get(), 1, &create, nullptr, &object);
    if (result < 0 && !kept.empty()) {  // perhaps by what was kept
        result =
            vk.CreateComputePipelines(device.get(), VK_NULL_HANDLE, 1, &create, nullptr, &object);
    }
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY) {
        checkVulkan(result, "vkCreateComputePipelines");
    }
    if (result < 0) {
        throw core::Error("a kernel does not compile on " + device.info().name + " (" +
                              device.info().driver + "): " + resultName(result) +
                              " — another driver may do; --device cpu needs none",
                          core::ExitCode::noDevice);
    }
    pipeline_ = {device.get(), object};
    if (keeps && kept.empty()) writeCache(device.cacheFolder(), key, contents(device, cache));
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
    bind(binding, noTexels_[format == VK_FORMAT_R32G32B32A32_UINT ? 0
                            : format == VK_FORMAT_R32_SFLOAT      ? 2
                                                                  : 1]);
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
    vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout.get(), 0, 1, &set_, 0,
                             nullptr);
}

}  // namespace gpu
