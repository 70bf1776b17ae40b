// Layouts are made of a list of bindings; each set has a pool of its own, as there are few.
#include "app/gpu/base/descriptors.h"

#include <algorithm>

#include "shared/bindings.h"

namespace gpu {

namespace {

constexpr uint64_t kNothingBytes = 256;  // as long as any uniform block
static_assert(sizeof(shared::FrameData) <= kNothingBytes);

std::vector<KernelBinding> sceneBindings()
{
    std::vector<KernelBinding> bindings;
    for (uint32_t i = 0; i < shared::kSceneBindings; ++i) {
        bindings.push_back({shared::kSetScene, i, VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER,
                            sceneTexelFormat(i) == VK_FORMAT_R32G32B32A32_UINT});
    }
    return bindings;
}

std::vector<KernelBinding> frameBindings()
{
    return {{shared::kSetFrame, shared::kBindFrame, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, false},
            {shared::kSetFrame, shared::kBindCounters, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, false}};
}

}  // namespace

VkFormat sceneTexelFormat(uint32_t binding)
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

SetLayout::SetLayout(const Device& device, std::vector<KernelBinding> bindings)
    : bindings_(std::move(bindings))
{
    std::vector<VkDescriptorSetLayoutBinding> list;
    for (const KernelBinding& b : bindings_)
        list.push_back({b.binding, b.type, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    VkDescriptorSetLayoutCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    create.bindingCount = static_cast<uint32_t>(list.size());
    create.pBindings = list.data();
    VkDescriptorSetLayout object;
    VK_CHECK(vk.CreateDescriptorSetLayout(device.get(), &create, nullptr, &object));
    layout_ = {device.get(), object};
}

SharedLayouts::SharedLayouts(const Device& device)
    : scene(device, sceneBindings()), frame(device, frameBindings())
{}

DescriptorSet::DescriptorSet(Device& device, const SetLayout& layout)
    : device_(device.get()), bindings_(layout.bindings())
{
    std::vector<VkDescriptorPoolSize> sizes;
    for (const KernelBinding& b : bindings_) {
        sizes.push_back({b.type, 1});
        const bool texels = b.type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
        Buffer& none = !texels ? nothing_ : b.uintTexels ? noUints_ : noFloats_;
        if (none.bytes() > 0) continue;
        const VkFormat format = !texels        ? VK_FORMAT_UNDEFINED
                                : b.uintTexels ? VK_FORMAT_R32G32B32A32_UINT
                                               : VK_FORMAT_R32G32B32A32_SFLOAT;
        none = Buffer(device, "placeholder", texels ? 16 : kNothingBytes, format);
    }
    VkDescriptorPoolCreateInfo pool{};
    pool.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
    pool.maxSets = 1;
    pool.poolSizeCount = static_cast<uint32_t>(sizes.size());
    pool.pPoolSizes = sizes.data();
    VkDescriptorPool poolObject;
    VK_CHECK(vk.CreateDescriptorPool(device_, &pool, nullptr, &poolObject));
    pool_ = {device_, poolObject};
    VkDescriptorSetLayout setLayout = layout.get();
    VkDescriptorSetAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
    allocate.descriptorPool = poolObject;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &setLayout;
    VK_CHECK(vk.AllocateDescriptorSets(device_, &allocate, &set_));
    for (const KernelBinding& b : bindings_) unbind(b.binding);
}

bool DescriptorSet::knows(uint32_t binding) const
{
    return std::ranges::find(bindings_, binding, &KernelBinding::binding) != bindings_.end();
}

const KernelBinding& DescriptorSet::find(uint32_t binding) const
{
    const auto found = std::ranges::find(bindings_, binding, &KernelBinding::binding);
    CHECK(found != bindings_.end());
    return *found;
}

void DescriptorSet::unbind(uint32_t binding)
{
    const KernelBinding& b = find(binding);
    bind(binding, b.type != VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER ? nothing_
                  : b.uintTexels                                    ? noUints_
                                                                    : noFloats_);
}

void DescriptorSet::bind(uint32_t binding, const Buffer& buffer)
{
    const VkBufferView view = buffer.view();
    const VkDescriptorBufferInfo range{buffer.get(), 0, buffer.bytes()};
    VkWriteDescriptorSet write{};
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = set_;
    write.dstBinding = binding;
    write.descriptorCount = 1;
    write.descriptorType = find(binding).type;
    write.pBufferInfo = &range;
    write.pTexelBufferView = &view;
    vk.UpdateDescriptorSets(device_, 1, &write, 0, nullptr);
}

}  // namespace gpu
