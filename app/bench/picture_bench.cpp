// See picture_bench.h.
#include "app/bench/picture_bench.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "app/base/program_version.h"
#include "app/bench/bench_clock.h"
#include "app/bench/bench_scenes.h"
#include "app/report/page.h"
#include "app/report/text.h"
#include "app/version/system.h"
#include "core/base/check.h"

namespace app {

using Json = nlohmann::ordered_json;

PictureRun pictureRun(const PictureBenchOptions& options)
{
    PictureRun run;
    run.version = kVersion;
    run.commit = kCommit;
    run.machine = systemInfo().processor;
    run.cores = cores();
    run.samples = options.samples;
    run.quick = options.quick;
    return run;
}

const BenchDevice& deviceNamed(const PictureRun& run, const std::string& name)
{
    const auto found = std::ranges::find(run.devices, name, &BenchDevice::name);
    CHECK(found != run.devices.end());
    return *found;
}

Json runJson(const PictureRun& run, const char* command)
{
    Json devices = Json::array();
    for (const BenchDevice& d : run.devices)
        devices.push_back({{"device", d.name},
                           {"words", d.words},
                           {"clock", d.onHost ? "cpu seconds" : "device time"}});
    return {{"schema", 1},
            {"command", command},
            {"version", run.version},
            {"commit", run.commit},
            {"machine", run.machine},
            {"cores", run.cores},
            {"devices", devices},
            {"quick", run.quick},
            {"interrupted", run.interrupted},
            {"seconds", run.seconds},
            {"samples", run.samples}};
}

std::string runFacts(const PictureRun& run, const std::string& extent)
{
    std::string text = report::programText(run.version, run.commit) + " · " + run.machine + ", " +
                       report::counted(run.cores, "core");
    for (const BenchDevice& d : run.devices)
        if (d.name != "cpu") text += " · " + d.words;
    text += " · " + extent;
    if (run.seconds > 0) text += " · " + report::shortNumber(run.seconds) + " s";
    return text;
}

PictureScene pictureScene(const PictureBenchOptions& options, size_t index,
                          const core::World& world, const core::Camera& camera,
                          const std::vector<std::string>& taken)
{
    const std::filesystem::path& file = options.scenes[index].file;
    return {sceneName(file, taken), file, core::shownTriangles(world),
            options.size ? *options.size : usualSize(camera)};
}

bool warmUp(core::Renderer& renderer, const core::View& view, const BenchTools& tools,
            BenchDevice& device)
{
    renderer.setView(view, core::Start::anew);
    renderer.advance({.samples = 2}, tools.stop);
    if (tools.stop.stop_requested()) return false;
    const core::RenderStats stats = renderer.stats();
    device.words = stats.device + (stats.driver.empty() ? "" : ", " + stats.driver);
    return true;
}

double biasScore(const PictureMean& mean)
{
    return mean.difference.value / mean.difference.error;
}

double relativeBias(const PictureMean& mean)
{
    return mean.difference.value / (mean.mean - mean.difference.value);
}

}  // namespace app
