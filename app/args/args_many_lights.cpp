// The command line of the measurement of many lights. See args.h.
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/args/args_options.h"

namespace app {

namespace {

/// What may be left out, and what --quick makes smaller.
struct ManyLightsArguments {
    SceneOptions loading;  // of every scene, but for the file
    std::vector<std::filesystem::path> files;
    std::vector<uint32_t> clusters;
    std::vector<float> errors;
    std::optional<uint32_t> width, lights, repetitions;
    bool noSweeps = false, noPictures = false;
};

struct ManyLightsAmounts {
    uint32_t width, lights, receivers, repetitions;
    std::vector<uint32_t> clusters;
    std::vector<float> errors;
};

/// The thesis's density of receivers, its lights and its errors; slices that hold so many receivers
/// stand for the frame.
const ManyLightsAmounts kUsualManyLights{1280,
                                         100000,
                                         16000,
                                         3,
                                         {250, 500, 1000, 2000, 4000, 8000},
                                         {0.005f, 0.01f, 0.02f, 0.05f, 0.1f}};
const ManyLightsAmounts kQuickManyLights{640, 20000, 8000, 3, {250, 1000}, {0.02f, 0.1f}};

std::vector<uint32_t> readClusters(const std::string& text)
{
    return readNumbers<uint32_t>("--clusters", text, {1, 200000},
                                 "a whole number from 1 to 200000");
}

std::vector<float> readErrors(const std::string& text)
{
    return readNumbers<float>("--errors", text, {1e-4, 1}, "a number from 0.0001 to 1");
}

/// The thesis's lights, clamp and receivers, which all methods have in common.
core::ManyLightsParams commonParams()
{
    core::ManyLightsParams p;
    p.receivers = 4;
    p.clamp = 1;
    p.lost = core::LostLight::dropped;
    p.jitter = core::PixelJitter::never;
    return p;
}

/// The number of clusters nearest to the thesis's 1000.
uint32_t mainOf(const std::vector<uint32_t>& clusters)
{
    return *std::ranges::min_element(
        clusters, {}, [](uint32_t c) { return std::max(c, 1000u) - std::min(c, 1000u); });
}

/// The error nearest to the thesis's .02, by their ratio.
float mainErrorOf(const std::vector<float>& errors)
{
    return *std::ranges::min_element(
        errors, {}, [](float e) { return std::max(e, 0.02f) / std::min(e, 0.02f); });
}

void addFrameOptions(CLI::App& app, ManyLightsBenchOptions& o, ManyLightsArguments& given)
{
    const std::string group = "Frame";
    addRead(app, group, "--size", "WxH", o.size, readSize, "width and height in pixels");
    addValue(app, group, "--width", given.width,
             "width in pixels when --size is absent, of portraits the height; the camera decides "
             "the other; default " +
                 std::to_string(kUsualManyLights.width) +
                 "; quick: " + std::to_string(kQuickManyLights.width),
             {16, 8192});
    addValue(app, group, "--camera", o.camera,
             "name or index of a camera of the scene, or a JSON file (default: the first)");
    addValue(app, group, "--lights", given.lights,
             "virtual lights, about; default " + std::to_string(kUsualManyLights.lights) +
                 "; quick: " + std::to_string(kQuickManyLights.lights),
             {1, 4e6});
    addValue(app, group, "--receivers", o.params.receivers,
             "points of each pixel that are lit, rounded up to a square", {1, 64});
    addValue(app, group, "--clamp", o.params.clamp,
             "below which distance lights do not become brighter: 1 is the thesis's, 0 never",
             {0, 4});
    addValue(app, group, "--slice-size", o.params.sliceSize,
             "points from which a slice is split in two, unless a method has a size of its own",
             {64, 8192});
    addValue(app, group, "--max-depth", o.params.maxDepth, "scattering events per path", {0, 4096});
    addValue(app, group, "--seed", o.params.seed, "of lights, slices that are lit and repetitions");
}

void addAmountOptions(CLI::App& app, ManyLightsBenchOptions& o, ManyLightsArguments& given)
{
    const std::string group = "Measurement";
    app.add_flag("--quick", o.quick,
                 "for a look: a smaller picture, fewer lights and settings; about two minutes")
        ->group(group);
    addRead(app, group, "--clusters", "LIST", given.clusters, readClusters,
            "clusters of a slice (default 250,500,1000,2000,4000,8000; quick: 250,1000); what is "
            "measured at one number only is at that nearest to 1000");
    addRead(app, group, "--errors", "LIST", given.errors, readErrors,
            "relative errors that lightcuts and illumination-cut allow (default "
            ".005,.01,.02,.05,.1; quick: .02,.1); that nearest to .02 stands beside the others");
    addRead(
        app, group, "--share", "X", o.share,
        [](const std::string& text) {
            double share = 0;
            if (const std::string problem = readValue(text, {1e-6, 1}, share); !problem.empty())
                throw CLI::ValidationError("--share", "'" + text + "' is not " + problem);
            return share;
        },
        "share of the slices, drawn at random, that stand for the frame; 1 is the whole of it "
        "(default: until " +
            std::to_string(kUsualManyLights.receivers) +
            " points are lit; quick: " + std::to_string(kQuickManyLights.receivers) + ")");
    addValue(app, group, "--repetitions", given.repetitions,
             "turns of all methods, each with a light tree of its own; default " +
                 std::to_string(kUsualManyLights.repetitions) +
                 "; quick: " + std::to_string(kQuickManyLights.repetitions),
             {1, 100});
    addRead(app, group, "--methods", "LIST", o.methods, splitList,
            "methods to measure beside full (default: all)");
    app.add_flag("--no-sweeps", given.noSweeps,
                 "leave out fixed rates of rows, and rows and rates that are not adaptive")
        ->group(group);
    app.add_flag("--no-pictures", given.noPictures, "leave out the pictures of a part of the frame")
        ->group(group);
}

ManyLightsBenchOptions finished(ManyLightsBenchOptions o, const ManyLightsArguments& given)
{
    o.scenes = measuredScenes("bench manylights", given.loading, given.files, o.output);
    const ManyLightsAmounts& usual = o.quick ? kQuickManyLights : kUsualManyLights;
    o.width = given.width.value_or(usual.width);
    o.params.lights = given.lights.value_or(usual.lights);
    o.repetitions = given.repetitions.value_or(usual.repetitions);
    o.receivers = usual.receivers;
    o.clusters = given.clusters.empty() ? usual.clusters : given.clusters;
    o.mainClusters = mainOf(o.clusters);
    o.errors = given.errors.empty() ? usual.errors : given.errors;
    o.mainError = mainErrorOf(o.errors);
    o.sweeps = !given.noSweeps;
    o.pictures = !given.noPictures;
    return o;
}

}  // namespace

Subcommand manyLightsCommandLine(CLI::App& bench)
{
    const auto o = std::make_shared<ManyLightsBenchOptions>();
    const auto given = std::make_shared<ManyLightsArguments>();
    o->params = commonParams();
    CLI::App& app = *bench.add_subcommand(
        "manylights",
        "what it costs to light a picture by many virtual lights, and what is lost: full sampling "
        "of clusters and every way to complete their visibility, time against error, beside the "
        "numbers of the thesis; writes a page to read and JSON");
    addSceneFiles(app, given->files);
    const std::string output = "Output";
    addValue(app, output, "-o,--output", o->output,
             "folder for index.html, manylights.json, pictures and references; made when it does "
             "not exist, and its references are used again when they still fit")
        ->type_name("DIR");
    addValue(app, output, "--exposure", o->exposure,
             "stops that brighten the pictures, those in which 8-bit errors are measured, too",
             {-40, 40});
    app.add_flag("-q,--quiet", o->quiet, "no progress on stderr")->group(output);
    addFrameOptions(app, *o, *given);
    addAmountOptions(app, *o, *given);
    addLoadingOptions(app, given->loading);
    app.footer("Example: rekindle bench manylights room.glb -o manylights --quick\n"
               "         rekindle bench manylights room.glb hall.glb -o manylights --share .01");
    return {&app, "rekindle bench manylights SCENE... -o DIR [options]",
            [o, given]() -> Command { return finished(*o, *given); }};
}

}  // namespace app
