// What a kernel wants to be given, read from its SPIR-V: the buffers of its descriptor sets and the
// size of its push constants. The host takes layouts from here, so that the two cannot disagree.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "app/gpu/base/api.h"

namespace gpu {

/// A buffer that a kernel declares.
struct KernelBinding {
    uint32_t set = 0, binding = 0;
    VkDescriptorType type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    bool uintTexels = false;  // of texel buffers: whole numbers, not floats

    friend bool operator==(const KernelBinding&, const KernelBinding&) = default;
};

struct KernelInterface {
    std::vector<KernelBinding> bindings;  // in ascending order of set and binding
    uint32_t pushBytes = 0;               // 0: no push constants

    /// Those of one set.
    std::vector<KernelBinding> ofSet(uint32_t set) const;
};

/// `spirv` is a compiled kernel of this project: it uses storage buffers, uniform buffers and
/// uniform texel buffers, and nothing else. Throws core::Error when it is anything else.
KernelInterface readKernelInterface(std::span<const uint32_t> spirv);

}  // namespace gpu
