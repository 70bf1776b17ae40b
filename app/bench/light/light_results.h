// What ways to find light have shown beside each other: what JSON, CSV, tables and the page are
// made of.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/bench/picture_bench.h"
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
struct Row : PictureMean {  // beside that of `power`
    std::string strategy, device;
    uint32_t spp = 0;
    double buildSeconds = 0;      // of the renderer, before all pictures
    std::vector<Sample> samples;  // by pair
};

struct SceneResult : PictureScene {
    size_t emitters = 0;
    bool hasTree = false;        // lamps enough for one
    bool choosesByTree = false;  // unless told otherwise: it pays
    double loadSeconds = 0;
    std::vector<Row> rows;
};

struct Results : PictureRun {
    core::PathParams params;  // what all strategies have in common
    uint32_t pairs = 0;
    std::vector<SceneResult> scenes;
};

/// The row of that setting; null when there is none.
const Row* findRow(const SceneResult& scene, const std::string& strategy, const std::string& device,
                   uint32_t spp);

/// That of `power` on the same device with as many samples.
const Row* plainOf(const SceneResult& scene, const Row& row);

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

}  // namespace app::light
