// The table of methods: every way to render, what it can do and who makes its renderer on the CPU.
// The Vulkan renderers have a table of their own (app/gpu/methods/methods.h); app/methods joins the
// two. docs/methods.md shows how a method is added.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/methods/renderer.h"

namespace core {

/// What a method does, for those who drive it without knowing it.
struct Traits {
    bool radiance = true;       // estimates radiance: what holds of light holds of its pictures
    bool keepsOnMove = false;   // begins a moved view with samples that it has
    bool streams = true;        // samples add up without end; else a picture is complete after one
    bool sharesLight = false;   // among the pixels of a sample, whose errors then go together
    bool deterministic = true;  // equal bits for equal parameters, whatever threads and pauses
};

/// A named set of parameters that comes with a method.
struct MethodPreset {
    const char* name;
    AnyParams params;
    const char* help;  // what it is good for, one line
};

/// A map that a method's renderers make (Renderer::maps).
struct MapInfo {
    const char* name;
    const char* help;  // what it means, one line
    float high = 0;    // value at the upper end of the colours; 0: the largest there is
};

struct MethodInfo {
    const char* help;
    Traits traits;
    AnyParams defaults;
    std::unique_ptr<Renderer> (*make)();  // on the CPU; null: `whyNot` says why there is none
    const char* whyNot = nullptr;
    AnyParams (*whileMoving)(const AnyParams&) = nullptr;  // quicker ones, of the same light
    std::span<const MethodPreset> presets{};
    std::span<const MapInfo> maps{};

    std::string_view id() const { return defaults.id(); }
};

/// All methods, in the order of MethodParams; the first is what a user gets who asks for none.
std::span<const MethodInfo> methods();

/// The method of that name; null when there is none.
const MethodInfo* findMethod(std::string_view id);

/// "path, ...": what there is to choose from.
std::string methodNames();

/// The same as findMethod; throws core::Error (command line) naming the methods there are.
const MethodInfo& methodNamed(std::string_view id);

/// A new CPU renderer of that method; throws core::Error (command line) when there is none of that
/// name, or none on the CPU.
std::unique_ptr<Renderer> makeRenderer(std::string_view id);

// What each method brings, one file per method.
std::unique_ptr<Renderer> makePathTracer();
std::span<const MethodPreset> pathPresets();
std::unique_ptr<Renderer> makeAmbientOcclusion();
std::span<const MethodPreset> aoPresets();
std::unique_ptr<Renderer> makeSampleReuse();
std::span<const MethodPreset> reusePresets();
std::span<const MapInfo> reuseMaps();
std::unique_ptr<Renderer> makeManyLights();
std::span<const MethodPreset> manyLightsPresets();
AnyParams quickerManyLights(const AnyParams& params);
std::span<const MapInfo> manyLightsMaps();
std::unique_ptr<Renderer> makeGuidedPathTracer();
std::span<const MethodPreset> guidedPresets();
std::span<const MapInfo> guideMaps();

}  // namespace core
