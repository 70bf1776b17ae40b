// What measurements of many lights have shown: what JSON, tables, claims and pages are made of.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "app/bench/spread.h"
#include "core/methods/many_lights_params.h"

namespace app::many_lights {

using app::kUnknown, app::Spread, app::spreadOf;

/// One repetition. Seconds are those of all cores, rays are counted, and both are those of the
/// whole frame: what was measured over the share of the receivers that were lit.
struct Sample {
    double seconds = 0;      // from the cut to the shaded slices
    double wallSeconds = 0;  // as measured, by the clock on the wall
    double cut = 0, order = 0, tracing = 0, matching = 0, shading = 0;  // parts of `seconds`
    double threadSeconds = 0;  // as measured, summed over threads
    /// Microseconds of a thread that completion takes for a column, its rays left out: of columns
    /// with a row that matters.
    double columnOverhead = kUnknown;
    double rays = 0;                              // between receivers and clusters
    double visibility = 0, authorVisibility = 0;  // shares of the entries that were traced
    double rmse8 = 0, rmse = 0, relMse = 0;       // against all lights
    double toFull8 = kUnknown;  // against full sampling of as many clusters in the same slices

    double visibilitySeconds() const { return tracing + matching; }
};

/// One method at one setting.
struct Row {
    std::string method;
    uint32_t clusters = 0;
    double rowRate = kUnknown;  // where the measurement fixes it
    core::ManyLightsParams params;
    bool packets = true;
    std::vector<Sample> samples;  // by repetition
};

/// How often shadow rays are answered, per second and thread.
struct RayRates {
    double packets = 0, single = 0;  // by full sampling of some slices
    double raw = 0;                  // the same rays in packets that lie ready
    double ratio = kUnknown;         // of packets to raw: median of the turns
};

/// A picture's part, and how it differs from that of all lights.
struct Shot {
    std::string name;
    double rmse8 = 0;
    std::filesystem::path file, difference;  // from the folder of the page; the latter may be empty
};

struct SceneResult {
    std::string name;            // short, different for every scene
    std::filesystem::path file;  // as it was named
    size_t triangles = 0;
    glm::uvec2 size{0};
    size_t lights = 0, receivers = 0, litReceivers = 0, pixels = 0;  // pixels: that errors are of
    size_t slices = 0, litSlices = 0;                                // of the common slice size
    double clampDistance = 0;
    double lightSeconds = 0, treeSeconds = 0, receiverSeconds = 0;
    double referenceSeconds = 0, clipped = 0;  // share of the reference's values above 8 bits
    bool referenceKept = false;
    RayRates rates;
    std::vector<Row> rows;
    glm::uvec2 shotCorner{0}, shotSize{0};
    std::vector<Shot> shots;
};

struct Results {
    std::string version, commit, machine;
    core::ManyLightsParams params;  // what all methods have in common
    std::vector<uint32_t> clusters;
    uint32_t mainClusters = 0, repetitions = 0;
    unsigned cores = 0;
    double exposure = 0;
    bool quick = false, interrupted = false;
    double seconds = 0;
    std::vector<SceneResult> scenes;
};

/// The row of that setting; null when there is none with a sample. `rate`: NaN where the method has
/// a rate of its own.
const Row* findRow(const SceneResult& scene, const std::string& method, uint32_t clusters,
                   double rate = kUnknown);

/// Full sampling, in packets, of as many clusters in slices of the same size as `row`; null when
/// that was not measured.
const Row* fullInSameSlices(const SceneResult& scene, const Row& row);

/// A number of each repetition.
template <class Number> Spread spreadOf(const Row& row, Number&& number)
{
    std::vector<double> values;
    for (const Sample& s : row.samples) values.push_back(number(s));
    return spreadOf(std::move(values));
}

/// The middle repetition by time, its parts stretched so that they are those of the median. Of a
/// row with samples.
Sample middleSample(const Row& row);

/// The ratio of the same number of two rows, repetition by repetition: what slows the machine for a
/// while slows both.
template <class Number> Spread ratioOf(const Row& row, const Row& other, Number&& number)
{
    std::vector<double> values;
    for (size_t i = 0; i < std::min(row.samples.size(), other.samples.size()); ++i)
        values.push_back(number(row.samples[i]) / number(other.samples[i]));
    return spreadOf(std::move(values));
}

inline double secondsOf(const Sample& s)
{
    return s.seconds;
}
inline double visibilitySecondsOf(const Sample& s)
{
    return s.visibilitySeconds();
}
inline double rmse8Of(const Sample& s)
{
    return s.rmse8;
}
inline double columnOverheadOf(const Sample& s)
{
    return s.columnOverhead;
}

}  // namespace app::many_lights
