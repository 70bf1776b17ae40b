// Descriptor sets and their layouts: which buffers a kernel sees under which number.
#pragma once

#include <vector>

#include "app/gpu/base/kernel_interface.h"
#include "app/gpu/base/memory.h"

namespace gpu {

/// The layout of one set. Layouts of equal bindings are interchangeable, however many are made.
class SetLayout {
public:
    /// `bindings` may be empty, and their set numbers do not matter.
    SetLayout(const Device& device, std::vector<KernelBinding> bindings);

    VkDescriptorSetLayout get() const { return layout_.get(); }
    const std::vector<KernelBinding>& bindings() const { return bindings_; }

private:
    std::vector<KernelBinding> bindings_;
    Handle<VkDescriptorSetLayout, &Api::DestroyDescriptorSetLayout> layout_;
};

/// What every kernel of a renderer sees alike: the sets of the scene and of the frame
/// (shared/bindings.h).
struct SharedLayouts {
    explicit SharedLayouts(const Device& device);
    SetLayout scene, frame;
};

/// The texel format of a binding of the scene's set.
VkFormat sceneTexelFormat(uint32_t binding);

/// One descriptor set. Every binding starts out at a small placeholder, so that absent data, which
/// no kernel reads, costs nothing.
class DescriptorSet {
public:
    DescriptorSet(Device& device, const SetLayout& layout);

    bool knows(uint32_t binding) const;
    /// No command that uses the set may be running.
    void bind(uint32_t binding, const Buffer& buffer);
    /// Points the binding at the placeholder again.
    void unbind(uint32_t binding);

    VkDescriptorSet get() const { return set_; }

private:
    const KernelBinding& find(uint32_t binding) const;

    VkDevice device_;
    std::vector<KernelBinding> bindings_;
    Buffer nothing_, noUints_, noFloats_;  // storage and uniforms; texels of either kind
    Handle<VkDescriptorPool, &Api::DestroyDescriptorPool> pool_;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace gpu
