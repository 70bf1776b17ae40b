// What renderers on one device borrow: the device, and the layouts that all their kernels share.
#pragma once

#include "app/gpu/base/batch_pace.h"
#include "app/gpu/base/kernel.h"
#include "core/methods/renderer.h"

namespace gpu {

struct Context {
    /// Throws core::Error (noDevice) when no device is suitable.
    explicit Context(const DeviceOptions& options) : device(options), layouts(device) {}

    /// Names of device and driver, and the device's memory.
    core::RenderStats stats() const
    {
        core::RenderStats stats;
        stats.device = device.info().name;
        stats.driver = device.info().driver;
        stats.peakDeviceBytes = device.peakBytes;
        return stats;
    }

    /// The pace on this device: one of software is shared by threads, as the system divides them,
    /// and pieces that nothing stops may be long there, the first one, too.
    core::Pace paceFor(const core::Pace& wanted) const
    {
        if (!wanted.whole || !device.isSoftware()) return {wanted.dispatchSeconds};
        return {BatchPace::kLongest, true};
    }

    Device device;
    SharedLayouts layouts;
};

}  // namespace gpu
