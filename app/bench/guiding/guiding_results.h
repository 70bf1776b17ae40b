// What guided path tracing has shown beside the plain path tracer: what JSON, CSV, tables, goals
// and the page are made of.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/bench/picture_bench.h"
#include "core/methods/guided_params.h"

namespace app::guiding {

/// One picture. Of `path`, what a guide has is not known.
struct Sample {
    double cpuSeconds = 0;     // of this process's own code, all threads together
    double renderSeconds = 0;  // by the renderer's clock
    double rays = 0;
    double relMse = 0;
    double guidedShare = kUnknown, leaves = kUnknown, bytes = kUnknown, guideSeconds = kUnknown;
};

/// A variant on a device after so many samples per pixel.
struct Row : PictureMean {  // beside that of `path`
    std::string variant, device;
    uint32_t spp = 0;
    std::vector<Sample> samples;          // by seed
    Measured relMse{kUnknown, kUnknown};  // over the seeds
};

/// What goals say of arrivals is about so many degrees.
inline constexpr double kArrivalDegrees = 25;

/// The scene's view right after the camera was elsewhere: one sample per pixel, by a guide that has
/// learnt from one sample of each of `before` views there, and without one.
struct Arrival {
    std::string device;
    // Between there and here, seen from what the middle of the picture shows: kArrivalDegrees, or a
    // half, a quarter... where something stands in the way
    double degrees = 0;
    uint32_t before = 0;
    std::vector<double> plain, guided;  // relMSE by seed
    // In the window's own loop, where the camera orbits from there to here: `before` samples of one
    // view there, and those of the views between.
    bool window = false;

    /// "cpu", "cpu, in the window".
    std::string place() const { return window ? device + ", in the window" : device; }
};

/// A picture that the page shows.
struct Shot {
    std::string name;
    double relMse = kUnknown, seconds = kUnknown;
    std::filesystem::path file;  // from the folder of the page
};

struct SceneResult : PictureScene {
    uint32_t referenceSpp = 0;
    double referenceRelMse = 0, referenceSeconds = 0;  // its noise; what it took
    bool referenceKept = false;
    std::vector<Row> rows;
    std::vector<Arrival> arrivals;  // by device
    uint32_t shownSpp = 0;
    std::string shownDevice;
    std::vector<Shot> shots;
};

struct Results : PictureRun {
    core::GuidedParams params;  // what all variants have in common
    uint32_t seeds = 0;
    std::vector<uint32_t> sweep;
    std::vector<SceneResult> scenes;
};

/// The row of that setting; null when there is none.
const Row* findRow(const SceneResult& scene, const std::string& variant, const std::string& device,
                   uint32_t spp);

/// Plain path tracing on the same device with as many samples.
const Row* plainOf(const SceneResult& scene, const Row& row);

/// Mean over the seeds.
template <class Number> double meanOf(const Row& row, Number&& number)
{
    double sum = 0;
    for (const Sample& s : row.samples) sum += number(s);
    return sum / static_cast<double>(row.samples.size());
}

/// How many times less error than `plain` at as many samples.
Ratio varianceRatio(const Row& plain, const Row& row);

Ratio varianceRatio(const Arrival& arrival);

/// "first sample after 25 degrees, cpu: 7.8 (6.1–9) times less variance".
std::string arrivalText(const Arrival& arrival);

/// How many times less error times seconds: what is gained in equal time.
Ratio efficiency(const BenchDevice& device, const Row& plain, const Row& row);

}  // namespace app::guiding
