// Compute pipelines over the one descriptor set of shared/bindings.h.
#pragma once

#include <array>
#include <map>
#include <span>

#include "app/gpu/base/memory.h"
#include "shared/bindings.h"

namespace gpu {

/// The layout that all kernels share: texel buffers, one uniform buffer, storage buffers, push
/// constants.
class KernelLayout {
public:
    explicit KernelLayout(const Device& device);
    VkPipelineLayout get() const { return layout_.get(); }
    VkDescriptorSetLayout set() const { return set_.get(); }

private:
    Handle<VkDescriptorSetLayout, &Api::DestroyDescriptorSetLayout> set_;
    Handle<VkPipelineLayout, &Api::DestroyPipelineLayout> layout_;
};

/// What a kernel is specialised on; the constants' numbers are those of lang.h and bindings.h.
struct Specialization {
    uint32_t features = 0xffffffffu;
    uint32_t sampler = 0;
    friend auto operator<=>(const Specialization&, const Specialization&) = default;
};

class Pipeline {
public:
    Pipeline() = default;
    Pipeline(const Device& device, const KernelLayout& layout, std::span<const uint32_t> spirv,
             const Specialization& specialization);
    VkPipeline get() const { return pipeline_.get(); }

private:
    Handle<VkPipeline, &Api::DestroyPipeline> pipeline_;
};

/// One descriptor set; every binding starts out at a small buffer of zeros, so that absent data
/// costs nothing.
class Bindings {
public:
    Bindings(Device& device, const KernelLayout& layout);
    void bind(uint32_t binding, const Buffer& buffer);
    void unbind(uint32_t binding);
    void use(VkCommandBuffer commands, const KernelLayout& layout) const;

private:
    VkDevice device_;
    Buffer nothing_;
    std::array<Buffer, 3> noTexels_;
    Handle<VkDescriptorPool, &Api::DestroyDescriptorPool> pool_;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
};

/// The texel format of a binding below shared::kTexelBindings.
VkFormat texelFormat(uint32_t binding);

}  // namespace gpu
