// What a render measured, as JSON (schema 1) and as the metadata of its EXR.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "app/args/args.h"
#include "core/image/film.h"
#include "core/image/image.h"
#include "core/methods/renderer.h"
#include "core/scene/world.h"

namespace app {

struct FrameReport {
    uint32_t index = 0;
    double seconds = 0;  // in the renderer
    uint64_t rays = 0, paths = 0, spp = 0;
    bool follows = false;                               // see PictureFacts
    std::vector<core::StatsDetail> details;             // of the method
    std::vector<std::pair<std::string, double>> means;  // of the method's maps, by name
};

/// Everything that stats and metadata are made of.
struct RenderReport {
    const RenderOptions* options = nullptr;
    std::shared_ptr<const core::World> world;
    double time = 0;  // seconds of the scene's animation
    core::Camera camera;
    glm::uvec2 size{};
    core::RenderStats renderer;
    core::FilmCounters counters;
    std::vector<FrameReport> frames;
    double deviceSeconds = 0;  // opening the device
    double loadSeconds = 0, totalSeconds = 0;
    // Of all frames: from the world to the first sample, building and compiling included; the
    // hierarchies; the way back from the device
    double prepareSeconds = 0, buildSeconds = 0, readbackSeconds = 0;
    // or "time", "target", "interrupted", "budget", "device lost"
    const char* ended = "spp";
    std::optional<double> rmse, noise;
    std::optional<double> referenceNoise;  // RMSE of the reference's own noise, where it is known
    uint64_t overBudget = 0;  // frames that took a tenth more than their budget, or worse
    uint64_t warnings = 0;    // about the scene, in all poses that were taken
    uint64_t validationMessages = 0;

    double renderSeconds() const;
    uint64_t rays() const;
    uint64_t paths() const;
};

/// Whether the noise that is told of samples taken with these parameters is an upper bound: those
/// of a Sobol sequence are spread more evenly than their own spread tells.
bool noiseIsBound(const core::AnyParams& params);

/// Means of the maps of a method's own as they stand, by name; nothing where it has none.
std::vector<std::pair<std::string, double>> mapMeans(core::Renderer& renderer,
                                                     std::string_view method);

/// Schema 1: keys may be added, none renamed. Ends in a newline.
std::string statsJson(const RenderReport& report);

/// A scene as a picture shows it.
struct ShownScene {
    std::filesystem::path file;  // as it was named
    std::shared_ptr<const core::World> world;
    double time = 0;          // of `world`: seconds of the scene's animation
    std::string environment;  // as it was asked for: see core::LoadOptions
};

/// What the metadata of a picture says, for commands and viewer alike.
struct PictureFacts {
    ShownScene scene;
    core::Camera camera;
    glm::uvec2 size{};
    core::AnyParams params;
    uint64_t samples = 0;
    double seconds = 0;  // in the renderer
    std::string device, driver;
    std::string ended;  // as RenderReport says it
    // Began with what the views before had left (Traits::keepsOnMove), which no metadata tell: what
    // they say renders the same light again, but not the same bits
    bool follows = false;
};

/// Strings that say how to render the image again. The scene's `world` is set.
core::Metadata imageMetadata(const PictureFacts& facts);

/// Those of the report's newest frame.
core::Metadata imageMetadata(const RenderReport& report);

/// JSON with one line for each member of the outermost object.
std::string jsonLines(const nlohmann::ordered_json& json);

/// CSV of an array of flat objects that have the same members: their names first, then a line for
/// each.
std::string csvLines(const nlohmann::ordered_json& rows);

/// Most memory that this process has held, in MiB.
double peakHostMb();

}  // namespace app
