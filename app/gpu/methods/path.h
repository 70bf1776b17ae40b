// The path tracer on Vulkan compute, behind core::Renderer.
#pragma once

#include <memory>

#include "app/gpu/base/device.h"
#include "core/methods/renderer.h"

namespace gpu {

/// Throws core::Error (noDevice) when no device is suitable.
std::unique_ptr<core::Renderer> makePathRenderer(const DeviceOptions& options);

}  // namespace gpu
