// What flights have shown: what JSON, tables and pages are made of.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "app/bench/picture_error.h"
#include "app/bench/spread.h"
#include "core/methods/any_params.h"

namespace app::flight {

using app::kUnknown;

/// A strategy after `frame` frames, `step` between two.
struct Row {
    std::string strategy;
    uint32_t samples = 1;  // n: passes of each frame, of pathsOf(n) paths per pixel
    double step = 0;       // 0: the first view of a flight
    double distance = 0;   // of one step, metres
    uint32_t frame = 1;
    double rays = 0;     // of the last frame
    double seconds = 0;  // of the last frame; median of the seeds
    PictureErrors errors{};
    // Over those of Discard with one path per pixel and frame.
    Measured ratio{}, trimmedRatio{};  // of relMSE, of that without fireflies
    double mseRatio = 0;
    // The same over those of Discard in as much time.
    double timeRatio = 0, trimmedTimeRatio = 0;
};

/// A parameter at one value, after the longest flight with steps of `step`.
struct SweepPoint {
    std::string parameter;
    double value = 0, step = 0;
    bool standard = false;  // the value that all other flights have
    double seconds = 0;
    PictureErrors errors;
    Measured ratio, trimmedRatio;
};

/// A strategy in the window's own loop: what was on show at the end of its flights.
struct WindowRow {
    std::string strategy;
    double paths = 1;           // new ones per pixel and picture
    double target = 0;          // seconds from picture to picture that were wanted
    double pictureSeconds = 0;  // that it took
    double scale = 1;           // of the sides to the window's, in which light was sampled
    double fineScale = 1;       // and surfaces
    double share = 1;           // of the time its threads wanted to run, that they ran: the clock
                                // of all other times is slowed by it
    PictureErrors errors{};
    Measured shown{};     // mean square error of the colours on show
    Measured underWay{};  // and of those when the camera arrived, made for a place before
    // The same of pictures whose light has as few pixels, but no noise
    Measured bySize{};
    // over those of Discard at the same target; of bySize over what Discard has on show
    Measured ratio{}, trimmedRatio{}, shownRatio{}, underWayRatio{}, bySizeRatio{};
};

/// A picture of the last frame, and the part of it that is shown larger.
struct Shot {
    std::string name;      // "reference", or the strategy
    uint32_t samples = 1;  // n
    double seconds = 0, relMse = 0;
    std::filesystem::path file, part;  // from the folder of the page
};

struct SceneResult {
    std::string name;            // short, different for every scene
    std::filesystem::path file;  // as it was named
    size_t triangles = 0;
    glm::uvec2 size{0};
    std::string way, unit;  // words: where the camera went, of a step
    double radiance = 0;    // mean of the reference
    double referenceRelMse = 0;
    double referenceSeconds = 0;
    bool referenceKept = false;
    std::vector<Row> rows;
    std::vector<Row> atRest;  // Discard with n of 1, 2, 4
    double shownStep = 0;     // of the shots
    std::vector<Shot> shots;
    double windowSpeed = 0, windowSeconds = 0;  // steps per second, of a flight
    double windowRadiance = 0;                  // mean of what the window shows at rest
    std::vector<WindowRow> window;              // in the window's own loop; Discard first
};

struct Results {
    std::string version, commit, device, driver, clock;
    std::vector<std::string> strategies;
    std::vector<std::pair<std::string, std::string>> leftOut;  // name, why
    core::AnyParams params;
    double rays = 1;  // of them: new paths per pixel and frame; below one, where history is good
    std::vector<double> steps;
    std::vector<uint32_t> frames;  // after which a flight is looked at
    uint32_t seeds = 0;
    uint64_t referenceSpp = 0;
    double framesPerSecond = 0;  // of the scene's animation; 0: it stands still
    glm::uvec2 windowSize{0};    // of the pictures in the window's own loop; 0: not measured
    bool quick = false, interrupted = false;
    double seconds = 0;
    std::vector<SceneResult> scenes;
    std::string sweptScene, sweptStrategy;
    std::vector<SweepPoint> sweeps;

    uint32_t longest() const { return frames.empty() ? 0 : frames.back(); }

    /// Paths per pixel and frame of Discard in so many passes. It has no history: its first pass
    /// takes at least one, and each that follows takes one.
    double pathsOf(uint32_t passes) const { return std::max(rays, 1.0) + passes - 1; }
};

/// The row of a strategy; null when there is none.
inline const Row* rowOf(const SceneResult& scene, const std::string& strategy, double step,
                        uint32_t frame)
{
    for (const Row& row : scene.rows)
        if (row.strategy == strategy && row.step == step && row.frame == frame) return &row;
    return nullptr;
}

}  // namespace app::flight
