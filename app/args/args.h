// The command line as plain structs. The library that reads it is seen in args*.cpp only.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "app/methods/methods.h"
#include "core/base/params.h"
#include "core/gltf/gltf.h"
#include "core/methods/any_params.h"
#include "shared/tonemap.h"

namespace app {

enum class Tone : uint32_t { linear, aces, agx, neutral };
static_assert(static_cast<uint32_t>(Tone::linear) == shared::kToneLinear &&
              static_cast<uint32_t>(Tone::aces) == shared::kToneAces &&
              static_cast<uint32_t>(Tone::agx) == shared::kToneAgx &&
              static_cast<uint32_t>(Tone::neutral) == shared::kToneNeutral);

/// What `loadWorld` needs to know.
struct SceneOptions {
    std::filesystem::path file;
    core::LoadOptions load{.environment = core::kAnyEnvironment};
    double at = 0;  // seconds of the scene's animation
    // Those of the pose that the world is laid out for: see core::World; without: `at`
    std::optional<double> laidOutAt{};
};

/// Frames `first` to `last`, both included.
struct FrameRange {
    uint32_t first = 0, last = 0;
};

struct AovChoice {
    bool depth = false, normal = false, albedo = false, ids = false;
    bool maps = false;  // the method's own
    bool firstHits() const { return depth || normal || albedo || ids; }
    bool any() const { return firstHits() || maps; }
};

struct RenderOptions {
    SceneOptions scene;
    std::filesystem::path output;  // holds %04d or alike when `frames` is set
    DeviceKind device = DeviceKind::vulkan;
    int deviceIndex = -1;  // -1: the program chooses
    bool validation = false;
    std::optional<glm::uvec2> size;
    uint32_t width = 640;  // when `size` is absent: height from the camera's aspect
    std::optional<uint64_t> spp;
    std::optional<double> timeSeconds;
    std::optional<double> budgetMs, budgetRays;  // of each frame; rays per pixel
    std::string camera;                          // name, index or file; empty: the scene's first
    std::filesystem::path path;
    std::optional<FrameRange> frames;  // of the path, or of the scene's animation
    double framesPerSecond = 24;
    core::AnyParams params;  // and with them the method
    std::filesystem::path stats, reference;
    std::optional<double> untilRmse, untilNoise;
    AovChoice aovs;
    double exposure = 0;  // stops
    Tone tone = Tone::agx;
    std::vector<std::string> noSkip;  // names of features
    bool noCache = false;             // neither read nor keep what is dear to make
    bool quiet = false;
};

struct CompareOptions {
    std::filesystem::path image, reference;
};

struct InfoOptions {
    SceneOptions scene;
    bool json = false;
};

struct DevicesOptions {
    bool json = false;
};

struct ThroughputOptions {
    SceneOptions scene;
    int deviceIndex = -1;
    uint32_t width = 640;
    core::AnyParams params;  // of the whole samples that are measured
    double seconds = 2;      // per measured figure
};

/// Flights through scenes with every strategy of sample reuse.
struct FlightBenchOptions {
    std::vector<SceneOptions> scenes;  // at least one
    std::filesystem::path output;      // a folder
    DeviceKind device = DeviceKind::cpu;
    int deviceIndex = -1;
    std::optional<glm::uvec2> size;
    uint32_t width = 0;  // when `size` is absent: height from the camera's aspect
    std::string camera;  // name, index or file; empty: the scene's first
    std::filesystem::path path;
    uint32_t frames = 0;         // of the longest flight
    std::vector<double> steps;   // degrees per frame, or frames of the path; ascending
    double framesPerSecond = 0;  // of the scene's animation during flights; 0: it stands still
    uint32_t seeds = 0;
    uint64_t referenceSpp = 0;
    std::optional<glm::uvec2> window;  // flights in the window's own loop, too, at that size
    double exposure = 0;               // stops of the pictures
    bool sweeps = true;                // of parameters, in the first scene
    std::vector<core::ReuseStrategy> strategies;  // ascending, Discard first
    core::AnyParams params;                       // of reuse, what all strategies have in common
    bool quick = false, quiet = false;
};

/// Many lights: every way to cluster them and to find their visibility, time against error.
struct ManyLightsBenchOptions {
    std::vector<SceneOptions> scenes;  // at least one
    std::filesystem::path output;      // a folder
    std::optional<glm::uvec2> size;
    uint32_t width = 0;              // when `size` is absent; of portraits this is the height
    std::string camera;              // name, index or file; empty: the scene's first
    core::ManyLightsParams params;   // what all methods have in common
    std::vector<uint32_t> clusters;  // to sweep over; ascending
    uint32_t mainClusters = 0;       // one of them: of everything else
    std::vector<float> errors;       // that lightcuts and IlluminationCut allow
    float mainError = 0;             // one of them: beside mainClusters
    std::optional<double> share;     // of the slices; absent: until `receivers` are lit
    uint32_t receivers = 0;
    uint32_t repetitions = 0;
    double exposure = 0;  // stops, of what 8-bit errors and pictures show
    bool sweeps = true;   // of fixed rates of rows, and of adaptive rows and rates
    bool pictures = true;
    std::vector<std::string> methods;  // names; empty: all
    bool quick = false, quiet = false;
};

/// The devices that a measurement is made on. `both`: the CPU, and Vulkan where there is a device.
enum class MeasuredDevices : uint32_t { both, cpu, vulkan };

/// What measurements of whole pictures on several devices have in common.
struct PictureBenchOptions {
    std::vector<SceneOptions> scenes;  // at least one
    std::filesystem::path output;      // a folder
    MeasuredDevices devices = MeasuredDevices::both;
    int deviceIndex = -1;
    std::optional<glm::uvec2> size;  // absent: by the camera
    std::string camera;              // name, index or file; empty: the scene's first
    std::vector<uint32_t> samples;   // per pixel; ascending
    bool quick = false, quiet = false;
};

/// Guided path tracing: error and time beside the plain path tracer's, with every switch.
struct GuidingBenchOptions : PictureBenchOptions {
    core::GuidedParams params;          // what all variants have in common
    std::vector<std::string> variants;  // names; empty: all, or in a quick run the main ones
    std::vector<uint32_t> sweep;  // samples per pixel of the main variants; ascending, with those
                                  // of all
    uint32_t seeds = 0;
    uint32_t referenceSpp = 0;
    bool window = false;  // arrivals in the window's own loop, too
    double exposure = 0;  // stops of the pictures
};

/// Ways to find light beside each other: error and time by pairs of seeds.
struct LightBenchOptions : PictureBenchOptions {
    core::PathParams params;              // what all strategies have in common
    std::vector<std::string> strategies;  // names; empty: the main ones
    uint32_t pairs = 0;                   // of seeds
};

/// The laboratory of sample reuse.
struct LabOptions {
    std::filesystem::path output;  // a folder
    uint64_t trials = 0;           // per cell of the table
    uint64_t seed = 1;
    bool quick = false, quiet = false;
};

/// The window, with or without its subcommand. Without a display it becomes FlyThroughOptions.
struct ViewOptions {
    SceneOptions scene;  // empty file: that of `replay`, or else the default scene
    DeviceKind device = DeviceKind::vulkan;
    int deviceIndex = -1;
    bool validation = false;
    core::AnyParams params;  // and with them the method
    // Any of them, or the method, on the command line: then the kept ones do not count.
    bool paramsGiven = false;
    std::string camera;
    std::filesystem::path path;    // a camera path to begin with
    std::filesystem::path replay;  // a saved picture
    std::filesystem::path script;
    std::optional<glm::uvec2> size;  // of the window; else the kept one
    float uiScale = 0;               // 0: the kept one, or that of the display
    bool noSettings = false;
    bool noCache = false;
};

/// What is shown where there is no window: a short fly-through in numbered pictures.
struct FlyThroughOptions {
    SceneOptions scene;
    DeviceKind device = DeviceKind::vulkan;  // the CPU when there is no suitable one
    int deviceIndex = -1;
    bool validation = false;
    bool noCache = false;
    core::AnyParams params;  // and with them the method
    std::string camera;
};

/// --help and --version: text for stdout.
struct Printed {
    std::string text;
};

using Command =
    std::variant<RenderOptions, CompareOptions, InfoOptions, DevicesOptions, ThroughputOptions,
                 FlightBenchOptions, ManyLightsBenchOptions, GuidingBenchOptions, LightBenchOptions,
                 LabOptions, ViewOptions, Printed>;

/// Reads the command line. Throws core::Error with ExitCode::commandLine and one clear line.
Command parseArguments(int argc, const char* const* argv);

/// Whether the name ends in `extension` (lower case, with its dot), in any case.
bool hasExtension(const std::filesystem::path& file, std::string_view extension);

}  // namespace app

namespace core {
template <> struct EnumNames<Instancing> {
    static constexpr std::array<std::string_view, 3> names{"auto", "flat", "kept"};
};
}  // namespace core

namespace core {
template <> struct EnumNames<app::Tone> {
    static constexpr std::array<std::string_view, 4> names{"linear", "aces", "agx", "neutral"};
};
}  // namespace core

namespace core {
template <> struct EnumNames<app::MeasuredDevices> {
    static constexpr std::array<std::string_view, 3> names{"both", "cpu", "vulkan"};
};
}  // namespace core
