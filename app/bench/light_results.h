// What ways to find light have shown beside each other: what JSON, CSV, tables and the page are
// made of.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "app/bench/bench_devices.h"
#include "app/bench/picture_error.h"
#include "app/bench/spread.h"
#include "core/methods/path_params.h"

namespace app::light {

/// One pair of pictures; times and rays are those of one picture, the mean of both.
struct Sample {
    double cpuSeconds = 0;     // of this process's own code, all threads together
    double renderSeconds = 0;  // by the renderer's clock
    double rays = 0;
    double relMse = 0, trimmed = 0;  // of one picture
};

/// A strategy on a device after so many samples per pixel.
struct Row {
    std::string strategy, device;
    uint32_t spp = 0;
    double buildSeconds = 0;                  // of the renderer, before all pictures
    std::vector<Sample> samples;              // by pair
    Measured difference{kUnknown, kUnknown};  // of the pictures' mean to that of `power`
    double mean = kUnknown;                   // of the pictures
};

struct SceneResult {
    std::string name;            // short, different for every scene
    std::filesystem::path file;  // as it was named
    size_t triangles = 0, emitters = 0;
    bool hasTree = false;        // lamps enough for one
    bool choosesByTree = false;  // unless told otherwise: it pays
    glm::uvec2 size{0};
    double loadSeconds = 0;
    std::vector<Row> rows;
};

struct Results {
    std::string version, commit, machine;
    unsigned cores = 0;
    std::vector<BenchDevice> devices;
    core::PathParams params;  // what all strategies have in common
    uint32_t pairs = 0;
    std::vector<uint32_t> samples;
    bool quick = false, interrupted = false;
    double seconds = 0;
    std::vector<SceneResult> scenes;
};

/// The row of that setting; null when there is none.
const Row* findRow(const SceneResult& scene, const std::string& strategy, const std::string& device,
                   uint32_t spp);

/// That of `power` on the same device with as many samples.
const Row* plainOf(const SceneResult& scene, const Row& row);

const BenchDevice& deviceOf(const Results& results, const Row& row);

/// Mean of one number over the pairs.
double meanOf(const Row& row, double Sample::*number);

/// Mean seconds of a picture by the clock that fits the device.
double meanSeconds(const BenchDevice& device, const Row& row);

/// How many times less error (Sample::relMse or Sample::trimmed) than `plain` at equal samples.
Ratio errorRatio(const Row& plain, const Row& row, double Sample::*error);

/// How many times as long.
Ratio timeRatio(const BenchDevice& device, const Row& plain, const Row& row);

/// How many times less error times seconds: what is gained in equal time.
Ratio efficiency(const BenchDevice& device, const Row& plain, const Row& row,
                 double Sample::*error);

/// How many standard errors the mean of the pictures lies from that of `power`.
double biasScore(const Row& row);

/// The share by which it does.
double relativeBias(const Row& row);

}  // namespace app::light
