#include "app/methods/methods.h"

#include "app/gpu/methods/methods.h"
#include "core/base/check.h"

namespace app {

static const gpu::Method* findGpuMethod(std::string_view id)
{
    for (const gpu::Method& method : gpu::methods())
        if (method.id == id) return &method;
    return nullptr;
}

std::string whyNot(std::string_view id, DeviceKind device)
{
    const core::MethodInfo* method = core::findMethod(id);
    if (method == nullptr) return "there is no such method";
    if (device == DeviceKind::cpu) return method->make != nullptr ? "" : method->whyNot;
    const gpu::Method* gpu = findGpuMethod(id);
    if (gpu == nullptr) return "it has not been written for Vulkan";
    return gpu->make != nullptr ? "" : gpu->whyNot;
}

std::unique_ptr<core::Renderer> makeRenderer(std::string_view id, const Target& target)
{
    const core::MethodInfo& method = core::methodNamed(id);
    const std::string why = whyNot(id, target.device);
    if (!why.empty()) {
        const DeviceKind other =
            target.device == DeviceKind::cpu ? DeviceKind::vulkan : DeviceKind::cpu;
        throw core::Error("method " + std::string(id) + " does not run on --device " +
                              std::string(core::enumName(target.device)) + ": " + why +
                              (whyNot(id, other).empty()
                                   ? " — use --device " + std::string(core::enumName(other))
                                   : ""),
                          core::ExitCode::commandLine);
    }
    if (target.device == DeviceKind::cpu) return method.make();
    return findGpuMethod(id)->make({.index = target.deviceIndex,
                                    .validation = target.validation,
                                    .cacheFolder = target.cacheFolder});
}

}  // namespace app
