// The command line of the window. See args.h.
#include <memory>

#include "app/args/args_options.h"

namespace app {

namespace {

constexpr uint32_t kSmallestWindow = 64, kLargestWindow = 16384;  // a side, in pixels

/// Options that make no sense together.
void checkView(const ViewOptions& o)
{
    const std::string scene = o.scene.file.string();
    if (hasExtension(scene, ".exr") || hasExtension(scene, ".png"))
        badCommandLine(scene + " is a picture, not a scene — to return to its view: --replay " +
                       scene);
    if (!o.replay.empty()) {
        if (!hasExtension(o.replay, ".exr") && !hasExtension(o.replay, ".png"))
            badCommandLine("--replay " + o.replay.string() + ": the name must end in .exr or .png");
        if (!scene.empty()) badCommandLine("--replay names its own scene: leave out " + scene);
        if (!o.camera.empty()) badCommandLine("--replay has its own camera: leave out --camera");
        if (o.paramsGiven)
            badCommandLine("--replay has its own parameters: leave out those of the path tracer");
    }
    if (o.size && (glm::any(glm::lessThan(*o.size, glm::uvec2(kSmallestWindow))) ||
                   glm::any(glm::greaterThan(*o.size, glm::uvec2(kLargestWindow)))))
        badCommandLine("--size: the sides of a window are from 64 to 16384 pixels");
}

}  // namespace

Subcommand viewCommandLine(CLI::App& app, const std::string& usage)
{
    const auto o = std::make_shared<ViewOptions>();
    const std::string start = "Where to begin", window = "Window", device = "Device";
    addSceneOptions(app, o->scene);
    addValue(app, start, "--camera", o->camera,
             "name or index of a camera of the scene, or a JSON file (default: the first)");
    addValue(app, start, "--path", o->path, "camera path to play and edit, a JSON file");
    addValue(app, start, "--replay", o->replay,
             "picture made by this program: its scene, camera and parameters");
    addRead(app, window, "--size", "WxH", o->size, readSize,
            "width and height of the window (default: as it was left)");
    addValue(app, window, "--ui-scale", o->uiScale,
             "size of the letters; 0 is as it was left, or as the display says", {0, 4});
    app.add_flag("--no-settings", o->noSettings, "neither read nor keep settings")->group(window);
    addValue(app, window, "--script", o->script,
             "JSON file of actions, waits and screenshots to run; results as JSON on stdout");
    const auto method = addMethod(app);
    addValue(app, device, "--device", o->device,
             "Vulkan compute, or the Embree reference on all cores; can be changed in the window");
    addValue(app, device, "--device-index", o->deviceIndex,
             "Vulkan device as rekindle devices lists it; -1 chooses", {-1, 1024});
    app.add_flag("--validation", o->validation,
                 "run with the Vulkan validation layer and count its messages")
        ->group(device);
    addNoCache(app, device, o->noCache);
    return {&app, usage, [o, method]() -> Command {
                o->paramsGiven = method->given();
                o->params = method->params();
                requireRuns(o->params, o->device);
                checkView(*o);
                return *o;
            }};
}

}  // namespace app
