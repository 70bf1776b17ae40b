// The command line of the measurement of path guiding. See args.h.
#include <algorithm>
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
    std::optional<uint32_t> seeds, referenceSpp;
    bool sweep = false;
};

constexpr uint32_t kSeeds = 3, kQuickSeeds = 2;
constexpr uint32_t kSamples[] = {16, 64};
/// Of the paper whose experiments are mirrored.
constexpr uint32_t kSweep[] = {31, 63, 127, 255, 511, 1023};
/// A reference has so many times the samples of the largest picture, and no less than that.
constexpr uint32_t kReferenceFactor = 8, kLeastReference = 1024, kQuickReference = 256;

std::vector<uint32_t> readSamples(const std::string& text)
{
    return readNumbers<uint32_t>("--samples", text, {1, 100000}, "a whole number from 1 to 100000");
}

void addAmountOptions(CLI::App& app, GuidingBenchOptions& o, Given& given)
{
    const std::string group = "Measurement";
    app.add_flag("--quick", o.quick,
                 "for a look: path and guided only, fewer seeds, a noisier reference; about two "
                 "minutes for a small scene")
        ->group(group);
    addRead(app, group, "--variants", "LIST", o.variants, splitList,
            "variants to measure beside path, by their names on the page, as guided,no-gate, or "
            "families: switches (default; quick: guided alone), papers, training, combinations, "
            "depths");
    addRead(app, group, "--samples", "LIST", given.samples, readSamples,
            "samples per pixel of each variant (default 16,64)");
    app.add_flag("--sweep", given.sweep,
                 "path, guided and the family training also with 31, 63, 127, 255, 511 and 1023 "
                 "samples per pixel")
        ->group(group);
    addValue(app, group, "--seeds", given.seeds,
             "pictures of each kind, default " + std::to_string(kSeeds) +
                 "; quick: " + std::to_string(kQuickSeeds),
             {1, 1000});
    addValue(app, group, "--reference-spp", given.referenceSpp,
             "samples per pixel of the references, default " + std::to_string(kReferenceFactor) +
                 " times those of the pictures and at least " + std::to_string(kLeastReference) +
                 "; quick: " + std::to_string(kQuickReference),
             {2, 1e8});
    addRead(app, group, "--size", "WxH", o.size, readSize,
            "width and height in pixels (default: 256x256 where the camera's picture is square, "
            "else as many pixels as 192x108)");
    addValue(app, group, "--camera", o.camera,
             "name or index of a camera of the scene, or a JSON file (default: the first)");
}

GuidingBenchOptions finished(GuidingBenchOptions o, const Given& given)
{
    o.scenes = measuredScenes("bench guiding", given.loading, given.files, o.output);
    if (o.deviceIndex >= 0 && o.devices == MeasuredDevices::cpu)
        badCommandLine("--device-index is for --device vulkan");
    o.samples = given.samples;
    if (o.samples.empty()) o.samples.assign(std::begin(kSamples), std::end(kSamples));
    o.sweep = o.samples;
    if (given.sweep) o.sweep.insert(o.sweep.end(), std::begin(kSweep), std::end(kSweep));
    std::ranges::sort(o.sweep);
    const auto repeated = std::ranges::unique(o.sweep);
    o.sweep.erase(repeated.begin(), repeated.end());
    o.seeds = given.seeds.value_or(o.quick ? kQuickSeeds : kSeeds);
    o.referenceSpp = given.referenceSpp.value_or(
        std::max(o.quick ? kQuickReference : kLeastReference, kReferenceFactor * o.sweep.back()));
    return o;
}

}  // namespace

Subcommand guidingCommandLine(CLI::App& bench)
{
    const auto o = std::make_shared<GuidingBenchOptions>();
    const auto given = std::make_shared<Given>();
    CLI::App& app = *bench.add_subcommand(
        "guiding",
        "what path guiding gains and costs: error and time of --method guided, as it is and with "
        "each of its switches, beside those of --method path; writes a page to read, CSV and JSON");
    addSceneFiles(app, given->files);
    const std::string output = "Output";
    addValue(app, output, "-o,--output", o->output,
             "folder for guiding.html, guiding.json, guiding.csv, pictures and references; made "
             "when it does not exist, and its references are used again when they still fit")
        ->type_name("DIR");
    addValue(app, output, "--exposure", o->exposure, "stops that brighten the pictures", {-40, 40});
    app.add_flag("-q,--quiet", o->quiet, "no progress on stderr")->group(output);
    addAmountOptions(app, *o, *given);
    const std::string device = "Device";
    addValue(app, device, "--device", o->devices,
             "the CPU, Vulkan compute, or both where there is a Vulkan device");
    addValue(app, device, "--device-index", o->deviceIndex,
             "Vulkan device as rekindle devices lists it; -1 chooses", {-1, 1024});
    addLoadingOptions(app, given->loading);
    const auto parameters = addParametersOf(app, core::GuidedParams::kMethod, {});
    app.footer("Example: rekindle bench guiding room.glb -o guiding --quick\n"
               "         rekindle bench guiding room.glb hall.glb -o guiding --device cpu");
    return {&app, "rekindle bench guiding SCENE... -o DIR [options]",
            [o, given, parameters]() -> Command {
                o->params = parameters->params().as<core::GuidedParams>();
                return finished(*o, *given);
            }};
}

}  // namespace app
