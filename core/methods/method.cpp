#include "core/methods/method.h"

#include <array>
#include <string>

#include "core/base/check.h"

namespace core {

std::span<const MethodInfo> methods()
{
    static const std::array<MethodInfo, std::variant_size_v<MethodParams>> kMethods{
        MethodInfo{.help = "unidirectional path tracing with next-event estimation and MIS",
                   .traits = {},
                   .defaults = PathParams{},
                   .make = makePathTracer,
                   .presets = pathPresets()},
        MethodInfo{.help = "ambient occlusion: the open share of the sky above each point",
                   .traits = {.radiance = false},
                   .defaults = AoParams{},
                   .make = makeAmbientOcclusion,
                   .presets = aoPresets()},
        MethodInfo{.help = "path tracing that keeps its samples when the camera moves",
                   .traits = {.keepsOnMove = true},
                   .defaults = ReuseParams{},
                   .make = makeSampleReuse,
                   .presets = reusePresets(),
                   .maps = reuseMaps()},
        MethodInfo{.help = "virtual lights, clustered for slices of the picture",
                   .traits = {.sharesLight = true},
                   .defaults = ManyLightsParams{},
                   .make = makeManyLights,
                   .whileMoving = quickerManyLights,
                   .presets = manyLightsPresets(),
                   .maps = manyLightsMaps()},
        MethodInfo{.help = "path tracing that learns where light comes from",
                   .traits = {.keepsOnMove = true},
                   .defaults = GuidedParams{},
                   .make = makeGuidedPathTracer,
                   .presets = guidedPresets(),
                   .maps = guideMaps()},
    };
    return kMethods;
}

const MethodInfo* findMethod(std::string_view id)
{
    for (const MethodInfo& method : methods())
        if (id == method.id()) return &method;
    return nullptr;
}

std::string methodNames()
{
    std::string names;
    for (const MethodInfo& method : methods())
        names += (names.empty() ? "" : ", ") + std::string(method.id());
    return names;
}

const MethodInfo& methodNamed(std::string_view id)
{
    if (const MethodInfo* method = findMethod(id)) return *method;
    throw Error("--method: '" + std::string(id) + "' is not one of " + methodNames(),
                ExitCode::commandLine);
}

std::unique_ptr<Renderer> makeRenderer(std::string_view id)
{
    const MethodInfo& method = methodNamed(id);
    if (method.make != nullptr) return method.make();
    throw Error("method '" + std::string(id) + "' does not run on the CPU: " + method.whyNot,
                ExitCode::commandLine);
}

}  // namespace core
