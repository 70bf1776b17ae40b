// The table of methods on Vulkan, beside the CPU's (core/methods/method.h); app/methods joins the
// two.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "app/gpu/base/device.h"
#include "core/methods/renderer.h"

namespace gpu {

struct Method {
    std::string_view id;
    // Throws core::Error (noDevice) when no device is suitable; null: `whyNot` says why there is
    // none
    std::unique_ptr<core::Renderer> (*make)(const DeviceOptions& options);
    const char* whyNot = nullptr;
};

// What each method brings, one file per method (the path tracer's has a header of its own).
std::unique_ptr<core::Renderer> makeAmbientOcclusion(const DeviceOptions& options);
std::unique_ptr<core::Renderer> makeSampleReuse(const DeviceOptions& options);
std::unique_ptr<core::Renderer> makeManyLights(const DeviceOptions& options);
std::unique_ptr<core::Renderer> makeGuidedPaths(const DeviceOptions& options);

/// One entry for each method of the CPU's table.
std::span<const Method> methods();

}  // namespace gpu
