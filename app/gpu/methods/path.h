// The path tracer on Vulkan compute, behind core::Renderer.
#pragma once

#include <memory>

#include "app/gpu/context.h"
#include "core/methods/renderer.h"

namespace gpu {

/// Any number of renderers may share a context, from one thread.
std::unique_ptr<core::Renderer> makePathRendererOn(std::shared_ptr<Context> context);

/// With a device of its own. Throws core::Error (noDevice) when no device is suitable.
std::unique_ptr<core::Renderer> makePathRenderer(const DeviceOptions& options);

}  // namespace gpu
