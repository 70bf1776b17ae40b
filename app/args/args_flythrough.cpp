// The command line of the measurement of flights. See args.h.
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/args/args_options.h"

namespace app {

namespace {

/// What may be left out, and what --quick makes smaller.
struct FlythroughArguments {
    SceneOptions loading;  // of every scene, but for the file
    std::vector<std::filesystem::path> files;
    std::optional<uint32_t> width, frames, seeds;
    std::optional<uint64_t> referenceSpp;
    std::vector<double> steps;
    bool noSweeps = false;
};

struct FlythroughAmounts {
    uint32_t width, frames, seeds;
    uint64_t referenceSpp;
    std::vector<double> degrees;
};

const FlythroughAmounts kUsualFlights{192, 30, 3, 2048, {0.25, 1, 4, 16}};
const FlythroughAmounts kQuickFlights{96, 16, 2, 1024, {1, 8}};

std::vector<double> readSteps(const std::string& text)
{
    return readNumbers<double>("--steps", text, {1e-3, 90}, "a number from .001 to 90");
}

/// Those named, without repetition; Discard, which all are compared with, is always one of them.
std::vector<core::ReuseStrategy> readStrategies(const std::string& text)
{
    std::vector<core::ReuseStrategy> chosen{core::ReuseStrategy::discard};
    for (const std::string& item : splitList(text)) {
        core::ReuseStrategy strategy{};
        const std::string problem = readValue(item, {}, strategy);
        if (!problem.empty())
            throw CLI::ValidationError("--strategies", "'" + item + "' is not " + problem);
        if (std::ranges::find(chosen, strategy) == chosen.end()) chosen.push_back(strategy);
    }
    std::ranges::sort(chosen);
    return chosen;
}

/// All, but for a quick look: `full` takes longer than all others together.
std::vector<core::ReuseStrategy> usualStrategies(bool quick)
{
    std::vector<core::ReuseStrategy> all;
    for (size_t i = 0; i < core::enumNames<core::ReuseStrategy>().size(); ++i)
        all.push_back(static_cast<core::ReuseStrategy>(i));
    if (quick) std::erase(all, core::ReuseStrategy::full);
    return all;
}

void addFlightOptions(CLI::App& app, FlightBenchOptions& o, FlythroughArguments& given)
{
    const std::string group = "Flights";
    addRead(app, group, "--steps", "LIST", given.steps, readSteps,
            "how far the camera goes from frame to frame: degrees around what it looks at, or with "
            "--path frames of the path (default 0.25,1,4,16; quick: 1,8; with --path: 1)");
    addValue(app, group, "--frames", given.frames,
             "frames of the longest flight, default " + std::to_string(kUsualFlights.frames) +
                 "; quick: " + std::to_string(kQuickFlights.frames),
             {2, 1000});
    addValue(app, group, "--path", o.path,
             "camera path, a JSON file; flights end where it ends (default: a circle that ends at "
             "the scene's camera)");
    addValue(app, group, "--fps", o.framesPerSecond,
             "the scene's animation runs while the camera flies, so many frames per second: the "
             "longest flight begins at --at, and all end at the same instant (default 0: it stands "
             "still)",
             {0, 100000});
    addValue(app, group, "--camera", o.camera,
             "where flights end: name or index of a camera of the scene, or a JSON file");
    addRead(app, group, "--strategies", "LIST", o.strategies, readStrategies,
            "strategies to measure (default: all of --method reuse; quick: all but full, the "
            "ceiling, which takes longer than the others together)");
}

void addAmountOptions(CLI::App& app, FlightBenchOptions& o, FlythroughArguments& given)
{
    const std::string group = "Measurement";
    app.add_flag("--quick", o.quick, "for a look: smaller, shorter, fewer; about two minutes")
        ->group(group);
    app.add_flag("--no-sweeps", given.noSweeps,
                 "leave out the flights with one parameter changed, which the first scene has")
        ->group(group);
    addRead(
        app, group, "--window", "WxH", o.window,
        [](const std::string& text) { return readSizeOf("--window", text); },
        "fly in the window's own loop, too, in a window of that size (640x360): by the clock, "
        "for 33 and 100 ms from picture to picture, with pictures as small as that takes; two "
        "to four minutes for each scene");
    addValue(app, group, "--seeds", given.seeds,
             "flights of each kind, default " + std::to_string(kUsualFlights.seeds) +
                 "; quick: " + std::to_string(kQuickFlights.seeds),
             {2, 1000});
    addValue(app, group, "--reference-spp", given.referenceSpp,
             "samples per pixel of the references, default " +
                 std::to_string(kUsualFlights.referenceSpp) +
                 "; quick: " + std::to_string(kQuickFlights.referenceSpp),
             {2, 1e9});
    addRead(app, group, "--size", "WxH", o.size, readSize, "width and height in pixels");
    addValue(app, group, "--width", given.width,
             "width in pixels when --size is absent; the camera decides the height; default " +
                 std::to_string(kUsualFlights.width) +
                 "; quick: " + std::to_string(kQuickFlights.width),
             {16, 8192});
}

FlightBenchOptions finished(FlightBenchOptions o, const FlythroughArguments& given)
{
    o.scenes = measuredScenes("bench flythrough", given.loading, given.files, o.output);
    if (o.window && o.framesPerSecond > 0)
        badCommandLine("--window flies by the clock through a scene that stands still: leave out "
                       "--fps");
    if (o.deviceIndex >= 0 && o.device == DeviceKind::cpu)
        badCommandLine("--device-index is for --device vulkan");
    const FlythroughAmounts& usual = o.quick ? kQuickFlights : kUsualFlights;
    o.sweeps = !given.noSweeps;
    o.width = given.width.value_or(usual.width);
    o.frames = given.frames.value_or(usual.frames);
    o.seeds = given.seeds.value_or(usual.seeds);
    o.referenceSpp = given.referenceSpp.value_or(usual.referenceSpp);
    if (o.strategies.empty()) o.strategies = usualStrategies(o.quick);
    o.steps = !given.steps.empty() ? given.steps
              : o.path.empty()     ? usual.degrees
                                   : std::vector<double>{1};
    requireRuns(o.params, o.device);
    return o;
}

}  // namespace

Subcommand flythroughCommandLine(CLI::App& bench)
{
    const auto o = std::make_shared<FlightBenchOptions>();
    const auto given = std::make_shared<FlythroughArguments>();
    CLI::App& app = *bench.add_subcommand(
        "flythrough",
        "what is gained and lost by samples that stay when the camera moves: flights through "
        "scenes with every strategy of --method reuse against references, at equal rays and at "
        "equal time; writes a page to read, CSV and JSON");
    addSceneFiles(app, given->files);
    const std::string output = "Output";
    addValue(app, output, "-o,--output", o->output,
             "folder for index.html, flythrough.json, pictures and references; made when it does "
             "not exist, and its references are used again when they still fit")
        ->type_name("DIR");
    addValue(app, output, "--exposure", o->exposure, "stops that brighten the pictures", {-40, 40});
    app.add_flag("-q,--quiet", o->quiet, "no progress on stderr")->group(output);
    addFlightOptions(app, *o, *given);
    addAmountOptions(app, *o, *given);
    const std::string device = "Device";
    addValue(app, device, "--device", o->device,
             "the Embree reference on all cores, or Vulkan compute");
    addValue(app, device, "--device-index", o->deviceIndex,
             "Vulkan device as rekindle devices lists it; -1 chooses", {-1, 1024});
    addLoadingOptions(app, given->loading);
    const auto parameters = addParametersOf(app, core::ReuseParams::kMethod, {"reuse"});
    app.footer(
        "Example: rekindle bench flythrough room.glb -o flythrough --quick\n"
        "         rekindle bench flythrough box.gltf room.glb -o flythrough --device vulkan");
    return {&app, "rekindle bench flythrough SCENE... -o DIR [options]",
            [o, given, parameters]() -> Command {
                o->params = parameters->params();
                return finished(*o, *given);
            }};
}

}  // namespace app
