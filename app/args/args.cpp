// Commands and their options. See args.h; how one option comes to be stands in args_options.h.
#include "app/args/args.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <utility>

#include "app/args/args_options.h"
#include "app/base/files.h"
#include "app/version/version.h"
#include "core/base/check.h"

namespace app {

namespace {

void require(bool present, const std::string& command, const std::string& what)
{
    if (!present)
        badCommandLine(command + ": " + what + " is missing — see rekindle " + command + " --help");
}

/// "3-12" or "7" to a range of frames.
FrameRange readFrames(const std::string& text)
{
    constexpr core::Range kFrames{0, 9999999};
    const size_t dash = text.find('-');
    FrameRange frames;
    const std::string last = dash == std::string::npos ? text : text.substr(dash + 1);
    if (!readValue(text.substr(0, dash), kFrames, frames.first).empty() ||
        !readValue(last, kFrames, frames.last).empty() || frames.last < frames.first)
        throw CLI::ValidationError("--frames", "'" + text + "' is not FIRST-LAST, as in 0-23");
    return frames;
}

AovChoice readAovs(const std::string& text)
{
    const std::vector<std::string> known{"depth", "normal", "albedo", "ids", "maps"};
    AovChoice choice;
    const std::vector<std::string> items = splitList(text);
    for (const std::string& item : items) {
        if (item == "depth")
            choice.depth = true;
        else if (item == "normal")
            choice.normal = true;
        else if (item == "albedo")
            choice.albedo = true;
        else if (item == "ids")
            choice.ids = true;
        else if (item == "maps")
            choice.maps = true;
        else
            throw CLI::ValidationError(
                "--aov", "'" + item + "' is not one of depth, normal, albedo, ids, maps" +
                             suggestion(item, known));
    }
    if (items.empty()) throw CLI::ValidationError("--aov", "the list is empty");
    return choice;
}

/// A frame has one budget, and nothing beside it says when it is done.
void checkBudget(const RenderOptions& o)
{
    if (!o.budgetMs && !o.budgetRays) return;
    const std::string name = o.budgetMs ? "--budget-ms" : "--budget-rays";
    if (o.budgetMs && o.budgetRays)
        badCommandLine("--budget-ms and --budget-rays: give one of them");
    if (o.spp || o.timeSeconds)
        badCommandLine(name + " says how many samples a frame gets: it does not go with " +
                       (o.spp ? "--spp" : "--time"));
    if (!o.frames) badCommandLine(name + " is for the frames of a flight: give --frames A-B");
}

/// Options that make no sense together, or alone.
void checkRender(const RenderOptions& o)
{
    require(!o.scene.file.empty(), "render", "the scene");
    require(!o.output.empty(), "render", "-o FILE.{exr,png}");
    const bool exr = hasExtension(o.output, ".exr");
    if (!exr && !hasExtension(o.output, ".png"))
        badCommandLine("-o " + o.output.string() + ": the name must end in .exr or .png");
    if (!exr && o.aovs.any()) badCommandLine("--aov needs an EXR file: a PNG has no layers");
    if (o.aovs.maps && core::methodNamed(o.params.id()).maps.empty())
        badCommandLine("--aov maps: --method " + std::string(o.params.id()) + " has none");
    if (!o.frames && isNumbered(o.output))
        badCommandLine("-o " + o.output.string() +
                       ": has a place for the number of a frame — give --frames A-B, or a name "
                       "without it");
    if (!o.path.empty() && !o.frames)
        badCommandLine("--path needs --frames FIRST-LAST: which frames of it to render");
    if (o.validation && o.device == DeviceKind::cpu)
        badCommandLine("--validation is for --device vulkan");
    if (o.deviceIndex >= 0 && o.device == DeviceKind::cpu)
        badCommandLine("--device-index is for --device vulkan");
    if (o.frames && !o.reference.empty())
        badCommandLine("--reference is one picture: it does not go with --frames");
    checkBudget(o);
    if (o.untilRmse && o.reference.empty())
        badCommandLine("--until-rmse needs --reference REF.exr to compare with");
}

Subcommand renderCommandLine(CLI::App& root)
{
    auto o = std::make_shared<RenderOptions>();
    CLI::App& app = *root.add_subcommand("render", "render a scene to an EXR or PNG file");
    const std::string picture = "Picture", stop = "When to stop", view = "View",
                      system = "Device and output";
    addSceneOptions(app, o->scene);
    addValue(app, picture, "-o,--output", o->output,
             "EXR (linear radiance, variance, everything needed to render it again) or PNG; "
             "%04d becomes the number of the frame");
    addRead(app, picture, "--size", "WxH", o->size, readSize, "width and height in pixels");
    addValue(app, picture, "--width", o->width,
             "width in pixels when --size is absent; the camera decides the height", {1, 65536});
    addRead(app, picture, "--aov", "LIST", o->aovs, readAovs,
            "more layers of the EXR, from depth,normal,albedo,ids and maps (the method's own)");
    addValue(app, picture, "--exposure", o->exposure, "stops that brighten a PNG", {-40, 40});
    addValue(app, picture, "--tone", o->tone, "tone curve of a PNG");
    addValue(app, stop, "--spp", o->spp,
             "samples per pixel (default 64 unless another limit is given)", {1, 2147483647});
    addValue(app, stop, "--time", o->timeSeconds,
             "seconds for each picture, from the scene in memory: building and compiling count, "
             "loading and "
             "writing do not; at least one sample is taken",
             {1e-3, 1e9});
    addValue(app, stop, "--budget-ms", o->budgetMs,
             "milliseconds for each of --frames: as many whole samples as fit, at least one; a new "
             "camera and moving what has moved count, reading, writing and the first frame's "
             "compiling do not",
             {1e-3, 1e9});
    addValue(app, stop, "--budget-rays", o->budgetRays,
             "rays per pixel for each of --frames, those to lights included: as many whole samples "
             "as fit, at least one; a method with --rays (reuse) takes fewer paths than pixels "
             "where one for each would be too many",
             {0.1, 1e9});
    addValue(app, stop, "--reference", o->reference,
             "EXR to measure the error against; its own noise counts as error");
    addValue(app, stop, "--until-rmse", o->untilRmse,
             "stop when the RMSE against --reference is this small; exit code 6 when another limit "
             "comes first",
             {1e-30, 1e30});
    addValue(app, stop, "--until-noise", o->untilNoise,
             "stop when the noise is this small: the RMSE that the spread of the samples leads to "
             "expect, after eight at least (with --sampler sobol an upper bound: the picture has "
             "at most this noise); exit code 6 when another limit comes first",
             {1e-30, 1e30});
    addValue(app, view, "--camera", o->camera,
             "name or index of a camera of the scene, or a JSON file (default: the first)");
    addValue(app, view, "--path", o->path, "camera path, a JSON file");
    addRead(app, view, "--frames", "A-B", o->frames, readFrames,
            "frames to render: of --path, or else of the scene's animation");
    addValue(app, view, "--fps", o->framesPerSecond,
             "frames per second of the scene's animation; not with "
             "--path, along which the scene stands as it is at --at",
             {0.001, 100000});
    const auto method = addMethod(app);
    addValue(app, system, "--device", o->device,
             "Vulkan compute, or the Embree reference on all cores");
    addValue(app, system, "--device-index", o->deviceIndex,
             "Vulkan device as rekindle devices lists it; -1 chooses", {-1, 1024});
    app.add_flag("--validation", o->validation,
                 "run with the Vulkan validation layer and count its messages")
        ->group(system);
    addNoCache(app, system, o->noCache);
    addRead(app, system, "--no-skip", "LIST", o->noSkip, splitList,
            "features to compile in although the scene does not need them (see rekindle info)");
    addValue(app, system, "--stats", o->stats, "write measurements as JSON");
    app.add_flag("-q,--quiet", o->quiet, "no progress on stderr")->group(system);
    app.footer(
        "Example: rekindle render room.glb -o room.exr --spp 64 --size 1280x720 --stats room.json");
    const CLI::Option* const fps = app.get_option("--fps");
    return {&app, "rekindle render SCENE -o FILE.{exr,png} [options]",
            [o, method, fps]() -> Command {
                o->params = method->params();
                requireRuns(o->params, o->device);
                checkRender(*o);
                if (fps->count() > 0 && !o->frames)
                    badCommandLine("--fps is for the frames of the scene's animation: give "
                                   "--frames A-B");
                if (fps->count() > 0 && !o->path.empty())
                    badCommandLine("--fps is for the scene's animation: along a --path the scene "
                                   "stands as it is at --at — leave --fps out");
                return *o;
            }};
}

Subcommand compareCommandLine(CLI::App& root)
{
    auto o = std::make_shared<CompareOptions>();
    CLI::App& app =
        *root.add_subcommand("compare", "measure the difference of two images, as JSON");
    addValue(app, "Arguments", "IMAGE", o->image, "EXR to judge");
    addValue(app, "Arguments", "REFERENCE", o->reference, "EXR that counts as the truth");
    app.footer("Example: rekindle compare room.exr reference.exr");
    return {&app, "rekindle compare IMAGE REFERENCE", [o]() -> Command {
                require(!o->image.empty(), "compare", "the image");
                require(!o->reference.empty(), "compare", "the reference");
                return *o;
            }};
}

Subcommand infoCommandLine(CLI::App& root)
{
    auto o = std::make_shared<InfoOptions>();
    CLI::App& app = *root.add_subcommand("info", "what a scene holds, needs and gets wrong");
    addSceneOptions(app, o->scene);
    app.add_flag("--json", o->json, "as JSON instead of text")->group("Output");
    app.footer("Example: rekindle info room.glb");
    return {&app, "rekindle info SCENE [options]", [o]() -> Command {
                require(!o->scene.file.empty(), "info", "the scene");
                return *o;
            }};
}

Subcommand devicesCommandLine(CLI::App& root)
{
    auto o = std::make_shared<DevicesOptions>();
    CLI::App& app = *root.add_subcommand("devices", "Vulkan devices and what each lacks");
    app.add_flag("--json", o->json, "as JSON instead of text")->group("Output");
    app.footer("Example: rekindle devices");
    return {&app, "rekindle devices [--json]", [o]() -> Command { return *o; }};
}

Subcommand throughputCommandLine(CLI::App& bench)
{
    auto o = std::make_shared<ThroughputOptions>();
    CLI::App& app = *bench.add_subcommand(
        "throughput",
        "rays and samples per second of the GPU kernels and of Embree, on the same rays, as JSON");
    addSceneOptions(app, o->scene);
    addValue(app, "Measurement", "--width", o->width, "width of the view in pixels", {16, 8192});
    addValue(app, "Measurement", "--seconds", o->seconds, "time for each figure", {0.05, 600});
    addValue(app, "Measurement", "--device-index", o->deviceIndex,
             "Vulkan device as rekindle devices lists it; -1 chooses", {-1, 1024});
    const auto method = addMethod(app);
    app.footer("Example: rekindle bench throughput room.glb > throughput.json");
    return {&app, "rekindle bench throughput SCENE [options]", [o, method]() -> Command {
                o->params = method->params();
                require(!o->scene.file.empty(), "bench throughput", "the scene");
                if (o->scene.load.instancing == core::Instancing::kept)
                    badCommandLine("--instances kept: bench throughput traces triangles that are "
                                   "all stored — leave it out");
                return *o;
            }};
}

std::vector<std::string> commandNames(const CLI::App& app)
{
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
        names.push_back(command->get_name());
    return names;
}

/// Refuses arguments that nobody wanted, with the nearest name that somebody would have. Options
/// come first: what follows an unknown one is probably its value.
void refuseExtras(const CLI::App& app)
{
    const std::vector<std::string> extras = app.remaining();
    if (extras.empty()) return;
    const auto option = std::find_if(extras.begin(), extras.end(), [](const std::string& text) {
        return text.size() > 1 && text[0] == '-';
    });
    if (option == extras.end())
        badCommandLine("unexpected argument '" + extras.front() + "'" +
                       suggestion(extras.front(), commandNames(app)) + " — see --help");
    const std::string name = option->substr(0, option->find('='));
    badCommandLine("unknown option " + name + suggestion(name, optionNames(app)) + " — see --help");
}

/// `rekindle rendr x` would otherwise be a scene named rendr.
void refuseMistypedCommand(const CLI::App& root)
{
    const std::vector<std::string> scenes = root.get_option("SCENE")->results();
    const std::string scene = scenes.empty() ? "" : scenes.front();
    std::error_code none;
    if (scene.empty() || std::filesystem::exists(scene, none)) return;
    const std::string meant = suggestion(scene, commandNames(root));
    if (!meant.empty()) badCommandLine("there is no command " + scene + meant);
}

}  // namespace

bool hasExtension(const std::filesystem::path& file, std::string_view extension)
{
    std::string found = file.extension().string();
    std::transform(found.begin(), found.end(), found.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return found == extension;
}

/// The window without its command: the same options, but only the scene in the help.
static Subcommand rootCommandLine(CLI::App& root)
{
    const Subcommand command = viewCommandLine(root, "rekindle [COMMAND] [SCENE] [options]");
    for (CLI::Option* option : root.get_options())
        if (!option->get_positional()) option->group("");
    root.footer("Example: rekindle room.glb\n"
                "         rekindle render room.glb -o room.exr --spp 64\n\n"
                "Exit codes: 0 done, 1 unexpected failure, 2 bad command line, 3 bad input, "
                "4 no suitable device,\n5 device lost or out of memory, 6 target not reached, "
                "130 interrupted (what was rendered is saved).");
    return command;
}

/// All commands, the innermost first and the program itself last.
static std::vector<Subcommand> addCommands(CLI::App& root)
{
    CLI::App& view = *root.add_subcommand(
        "view", "a window in which to fly through a scene while it is rendered; F1 shows its keys. "
                "Without a display: a short fly-through as numbered pictures");
    view.footer("Example: rekindle view room.glb\n"
                "         rekindle view room.glb --device cpu --max-depth 3 --camera door\n"
                "         rekindle view --replay room.exr");
    std::vector<Subcommand> commands{viewCommandLine(view, "rekindle view [SCENE] [options]"),
                                     renderCommandLine(root),
                                     compareCommandLine(root),
                                     infoCommandLine(root),
                                     devicesCommandLine(root),
                                     labCommandLine(root)};
    CLI::App& bench = *root.add_subcommand(
        "bench", "measurements: bench throughput SCENE, bench flythrough SCENE... -o DIR, "
                 "bench manylights SCENE... -o DIR, bench guiding SCENE... -o DIR, "
                 "bench light SCENE... -o DIR");
    bench.footer("Example: rekindle bench throughput room.glb\n"
                 "         rekindle bench flythrough room.glb -o flythrough --quick\n"
                 "         rekindle bench manylights room.glb -o manylights --quick\n"
                 "         rekindle bench guiding room.glb -o guiding --quick\n"
                 "         rekindle bench light room.glb -o light --quick");
    bench.require_subcommand(0, 1);
    commands.push_back(throughputCommandLine(bench));
    commands.push_back(flythroughCommandLine(bench));
    commands.push_back(manyLightsCommandLine(bench));
    commands.push_back(guidingCommandLine(bench));
    commands.push_back(lightCommandLine(bench));
    commands.push_back({&bench, "rekindle bench MEASUREMENT [options]", []() -> Command {
                            badCommandLine(
                                "bench: which measurement? This version has: throughput, "
                                "flythrough, manylights, guiding, light");
                        }});
    root.require_subcommand(0, 1);
    commands.push_back(rootCommandLine(root));
    return commands;
}

/// Refuses what stands before a command: it would be read as meant for the window, and be ignored.
static void refuseBeforeCommand(const CLI::App& root, const CLI::App& command)
{
    for (const CLI::Option* option : root.get_options()) {
        if (option->count() == 0) continue;
        // A hidden option does not tell its own name.
        const std::string what = option->get_lnames().empty() ? option->results().front()
                                                              : "--" + option->get_lnames().front();
        badCommandLine(what + " stands before the command — put it behind " + command.get_name());
    }
}

Command parseArguments(int argc, const char* const* argv)
{
    CLI::App root(
        "Path-traces glTF scenes on Vulkan compute or, as reference, on the CPU. Without a "
        "command it shows the scene (default assets/cornell-diffuse.gltf) in a window, as view "
        "does and with the options of view; where there is no display it renders a short "
        "fly-through to numbered PNG files in rekindle-frames/ (or -2, -3, ...) and says where "
        "they are.");
    const std::vector<Subcommand> commands = addCommands(root);
    bool help = false, version = false, json = false, manual = false;
    for (const Subcommand& command : commands) {
        command.app->set_help_flag();  // ours does not end the parsing, and is told apart below
        command.app->add_flag("-h,--help", help, "this text")->group("Help")->trigger_on_parse();
        command.app->allow_extras();
    }
    root.add_flag("--version", version,
                  "versions of the program, its libraries and the system, for reports of faults")
        ->group("Help")
        ->trigger_on_parse();
    root.add_flag("--json", json, "with --version: as JSON")->group("Help")->trigger_on_parse();
    root.add_flag("--manual", manual)->group("")->trigger_on_parse();  // for the build

    std::string problem;
    try {
        root.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        problem = error.what();
    }
    if (version) return Printed{json ? versionJson() : versionText()};
    if (manual) return Printed{manualText(root, commands)};
    const Subcommand& chosen =
        *std::find_if(commands.begin(), commands.end(), [&](const Subcommand& command) {
            return command.app->parsed() || command.app == &root;
        });
    if (help) return Printed{helpText(*chosen.app, chosen.usage)};
    if (json) badCommandLine("--json alone says nothing — use --version --json");
    if (chosen.app == &root)
        refuseMistypedCommand(root);
    else
        refuseBeforeCommand(root, *chosen.app);
    refuseExtras(*chosen.app);
    refuseExtras(root);
    if (!problem.empty()) badCommandLine(problem);
    return chosen.finish();
}

}  // namespace app
