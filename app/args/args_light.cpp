// The command line of the measurement of light. See args.h.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/args/args_options.h"

namespace app {

namespace {

/// What may be left out, and what --quick makes smaller.
struct Given {
    SceneOptions loading;  // of every scene, but for the file
    std::vector<std::filesystem::path> files;
    std::vector<uint32_t> samples;
    std::optional<uint32_t> pairs;
};

constexpr uint32_t kPairs = 3, kQuickPairs = 2;
constexpr uint32_t kSamples[] = {16, 64}, kQuickSamples[] = {8};

std::vector<uint32_t> readSamples(const std::string& text)
{
    return readNumbers<uint32_t>("--samples", text, {1, 100000}, "a whole number from 1 to 100000");
}

void addAmountOptions(CLI::App& app, LightBenchOptions& o, Given& given)
{
    const std::string group = "Measurement";
    app.add_flag("--quick", o.quick,
                 "for a look: power and tree only, two pairs of seeds, 8 samples per pixel; "
                 "seconds for a small scene")
        ->group(group);
    addRead(app, group, "--strategies", "LIST", o.strategies, splitList,
            "strategies to measure beside power: tree, guided (default; quick: tree), bsdf, light");
    addRead(app, group, "--samples", "LIST", given.samples, readSamples,
            "samples per pixel of each picture (default 16,64; quick: 8)");
    addValue(app, group, "--pairs", given.pairs,
             "pairs of pictures of each kind, default " + std::to_string(kPairs) +
                 "; quick: " + std::to_string(kQuickPairs),
             {1, 1000});
    addRead(app, group, "--size", "WxH", o.size, readSize,
            "width and height in pixels (default: 256x256 where the camera's picture is square, "
            "else as many pixels as 192x108)");
    addValue(app, group, "--camera", o.camera,
             "name or index of a camera of the scene, or a JSON file (default: the first)");
}

LightBenchOptions finished(LightBenchOptions o, const Given& given)
{
    o.scenes = measuredScenes("bench light", given.loading, given.files, o.output);
    if (o.deviceIndex >= 0 && o.devices == MeasuredDevices::cpu)
        badCommandLine("--device-index is for --device vulkan");
    o.samples = given.samples;
    if (o.samples.empty() && o.quick)
        o.samples.assign(std::begin(kQuickSamples), std::end(kQuickSamples));
    if (o.samples.empty()) o.samples.assign(std::begin(kSamples), std::end(kSamples));
    o.pairs = given.pairs.value_or(o.quick ? kQuickPairs : kPairs);
    return o;
}

}  // namespace

Subcommand lightCommandLine(CLI::App& bench)
{
    const auto o = std::make_shared<LightBenchOptions>();
    const auto given = std::make_shared<Given>();
    CLI::App& app = *bench.add_subcommand(
        "light",
        "ways to find light beside each other: emitters chosen by power, or by the tree for the "
        "place, guided paths, surfaces or emitters alone; error and processor time by pairs of "
        "seeds, without a reference; writes a page to read, CSV and JSON");
    addSceneFiles(app, given->files);
    const std::string output = "Output";
    addValue(app, output, "-o,--output", o->output,
             "folder for light.html, light.json and light.csv; made when it does not exist")
        ->type_name("DIR");
    app.add_flag("-q,--quiet", o->quiet, "no progress on stderr")->group(output);
    addAmountOptions(app, *o, *given);
    const std::string device = "Device";
    addValue(app, device, "--device", o->devices,
             "the CPU, Vulkan compute, or both where there is a Vulkan device");
    addValue(app, device, "--device-index", o->deviceIndex,
             "Vulkan device as rekindle devices lists it; -1 chooses", {-1, 1024});
    addLoadingOptions(app, given->loading);
    const auto parameters = addParametersOf(app, core::PathParams::kMethod, {"strategy"});
    app.footer("Example: rekindle bench light room.glb -o light --quick\n"
               "         rekindle bench light room.glb hall.glb -o light --strategies tree,bsdf");
    return {&app, "rekindle bench light SCENE... -o DIR [options]",
            [o, given, parameters]() -> Command {
                o->params = parameters->params().as<core::PathParams>();
                return finished(*o, *given);
            }};
}

}  // namespace app
