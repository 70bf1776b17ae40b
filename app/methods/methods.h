// What renders on what: the methods of both tables (core/methods/method.h,
// app/gpu/methods/methods.h) by name and device.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/params.h"
#include "core/methods/method.h"

namespace app {

enum class DeviceKind : uint32_t { vulkan, cpu };

/// Where a renderer is to work.
struct Target {
    DeviceKind device = DeviceKind::vulkan;
    int deviceIndex = -1;  // of the Vulkan devices; -1: the program chooses
    bool validation = false;
    std::filesystem::path cacheFolder{};  // of gpu::DeviceOptions; empty: nothing is kept
};

/// Why a method does not run on such a device, in words for a person; empty when it does.
std::string whyNot(std::string_view method, DeviceKind device);

/// A new renderer. Throws core::Error: command line when there is no such method, or not there
/// (with the device that has it), noDevice when no device is suitable.
std::unique_ptr<core::Renderer> makeRenderer(std::string_view method, const Target& target);

}  // namespace app

namespace core {
template <> struct EnumNames<app::DeviceKind> {
    static constexpr std::array<std::string_view, 2> names{"vulkan", "cpu"};
};
}  // namespace core
