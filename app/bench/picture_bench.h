// What measurements of whole pictures have in common: what they tell of themselves, how a scene is
// named and viewed, and what the means of pictures say about a bias.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "app/bench/bench_devices.h"
#include "app/bench/picture_error.h"
#include "app/bench/spread.h"
#include "core/scene/world.h"

namespace app {

/// The run of a measurement.
struct PictureRun {
    std::string version, commit, machine;
    unsigned cores = 0;
    std::vector<BenchDevice> devices;
    std::vector<uint32_t> samples;  // per pixel; ascending
    bool quick = false, interrupted = false;
    double seconds = 0;
};

/// Of this program on this machine, as it was asked for; the devices are to be filled in.
PictureRun pictureRun(const PictureBenchOptions& options);

/// The device of that name, which there is.
const BenchDevice& deviceNamed(const PictureRun& run, const std::string& name);

/// The members of a JSON file that begin it: schema, command, program, machine, devices, extent.
nlohmann::ordered_json runJson(const PictureRun& run, const char* command);

/// "rekindle 1.0 (abc) · some processor, 2 cores · some GPU · 3 pairs · depth 8 · 20 s", for a
/// page; `extent` is what stands between devices and seconds.
std::string runFacts(const PictureRun& run, const std::string& extent);

/// A scene of a measurement.
struct PictureScene {
    std::string name;            // short, different for every scene
    std::filesystem::path file;  // as it was named
    size_t triangles = 0;
    glm::uvec2 size{0};
};

/// `taken`: the names of the scenes before.
PictureScene pictureScene(const PictureBenchOptions& options, size_t index,
                          const core::World& world, const core::Camera& camera,
                          const std::vector<std::string>& taken);

/// Two samples per pixel, so that kernels are compiled and pools filled before times are taken.
/// What the device is goes to `device`. False: stopped.
bool warmUp(core::Renderer& renderer, const core::View& view, const BenchTools& tools,
            BenchDevice& device);

/// The mean of pictures beside that of other pictures with the same seeds.
struct PictureMean {
    double mean = kUnknown;
    Measured difference{kUnknown, kUnknown};  // to the others' mean
};

/// How many standard errors lie between the means.
double biasScore(const PictureMean& mean);

/// The difference as a share of the others' mean.
double relativeBias(const PictureMean& mean);

}  // namespace app
