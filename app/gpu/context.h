// What renderers on one device borrow: the device, and the layouts that all their kernels share.
#pragma once

#include "app/gpu/base/kernel.h"

namespace gpu {

struct Context {
    /// Throws core::Error (noDevice) when no device is suitable.
    explicit Context(const DeviceOptions& options) : device(options), layouts(device) {}

    Device device;
    SharedLayouts layouts;
};

}  // namespace gpu
