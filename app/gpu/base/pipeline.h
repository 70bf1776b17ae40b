// A compute pipeline: a kernel compiled for certain constants, with what the driver kept of it in
// earlier runs (pipeline_cache.h).
#pragma once

#include <span>
#include <utility>

#include "app/gpu/base/device.h"

namespace gpu {

/// Values of specialization constants `first`, `first` + 1, ... of a kernel.
struct ConstantValues {
    uint32_t first = 0;
    std::span<const uint32_t> values;
};

class Pipeline {
public:
    Pipeline() = default;
    /// On any thread, while the device is there. Throws core::Error (noDevice) when the driver does
    /// not compile it.
    Pipeline(const Device& device, VkPipelineLayout layout, std::span<const uint32_t> spirv,
             const ConstantValues& constants);
    VkPipeline get() const { return pipeline_.get(); }

    /// True once, for the first work that it is recorded in.
    bool isFirstUse() const { return !std::exchange(used_, true); }

private:
    mutable bool used_ = false;
    Handle<VkPipeline, &Api::DestroyPipeline> pipeline_;
};

}  // namespace gpu
