// The table of actions. See actions.h. Arguments are checked where they are read: a wrong one is
// refused with its name.
#include "app/session/actions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/base/nearest.h"
#include "app/base/new_name.h"
#include "app/session/action_arguments.h"
#include "app/session/comparison_actions.h"
#include "app/session/file_actions.h"
#include "app/session/set_param.h"
#include "core/base/check.h"

namespace app {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

/// The slider hides every view: who asks for one gets it instead.
bool endComparing(const ActionContext& c)
{
    return std::exchange(c.session.comparing, false);
}

void show(const ActionContext& c, Show what)
{
    Show& now = c.session.settings.view.show;
    const bool back = !endComparing(c) && now == what;  // the same key goes back
    now = back ? Show::color : what;
}

/// The method's maps one after the other, then the picture again.
void nextMap(const ActionContext& c)
{
    ViewParams& view = c.session.settings.view;
    const std::string method(c.session.render.method.id());
    const size_t count = core::methodNamed(method).maps.size();
    if (count == 0 && view.show != Show::methodMap) {
        c.session.notices.tell(Severity::news, "the method " + method + " has no maps of its own");
        return;
    }
    if (endComparing(c) || view.show != Show::methodMap) {
        view.show = Show::methodMap;
        view.methodMap = 0;
    } else if (++view.methodMap >= count) {
        view.show = Show::color;
        view.methodMap = 0;
    }
}

template <Show what> void showAction(const ActionContext& c)
{
    show(c, what);
}

void flip(bool& value)
{
    value = !value;
}

// --- actions of more than a line

void setAction(const ActionContext& c)
{
    const std::string name = text(c, "name");
    const auto value = c.arguments.find("value");
    if (value == c.arguments.end()) refuse("value", "a value");
    Session& s = c.session;
    if (name == "method") {
        s.chooseMethod(value->is_string() ? value->get<std::string>() : value->dump());
        return;
    }
    if (setRenderParam(s.render, name, *value)) return;
    if (setParam(s.settings.view, name, *value) || setParam(s.settings.panels, name, *value) ||
        setParam(s.settings.sections, name, *value))
        return;
    std::vector<std::string> names = renderParamNames(s.render);
    for (const std::string& more : paramNames<ViewParams>()) names.push_back(more);
    for (const std::string& more : paramNames<PanelParams>()) names.push_back(more);
    for (const std::string& more : paramNames<SectionParams>()) names.push_back(more);
    throw unknownParam(name, names);
}

void presetAction(const ActionContext& c)
{
    const std::string name = text(c, "name");
    std::vector<std::string> names;
    const auto tryAll = [&](bool ofOtherMethods) {
        const auto isIt = [&](const std::string& known, const core::AnyParams& params) {
            if ((params.id() != c.session.render.method.id()) != ofOtherMethods) return false;
            names.push_back(known);
            if (known == name) c.session.chooseParams(core::AnyParams(params));
            return known == name;
        };
        for (const Preset& preset : c.session.settings.presets)
            if (isIt(preset.name, preset.params)) return true;
        for (const core::MethodInfo& method : core::methods())
            for (const core::MethodPreset& preset : method.presets)
                if (isIt(preset.name, preset.params)) return true;
        return false;
    };
    if (tryAll(false) || tryAll(true)) return;
    throw core::Error("preset: there is no \"" + name + "\"" + suggestion(name, names),
                      core::ExitCode::commandLine);
}

void flyAction(const ActionContext& c)
{
    const FlyInput input{number(c, "right", 0), number(c, "up", 0), number(c, "forward", 0),
                         truth(c, "fast", false), truth(c, "slow", false)};
    c.session.navigation.fly(input, std::clamp(number(c, "seconds", 0.1), 0.0, 60.0));
    c.session.moved();
}

void dolly(const ActionContext& c)
{
    if (c.arguments.contains("x")) {
        c.session.dolly(number(c, "steps"), {number(c, "x"), number(c, "y")});
        return;
    }
    c.session.navigation.dolly(number(c, "steps"));
    c.session.moved();
}

void screenshotAction(const ActionContext& c)
{
    c.app.screenshot = fileName(c, "file", newName(".png").string());
    c.app.screenshotWithPanel = truth(c, "panel", true);
}

void slot(const ActionContext& c, size_t side)
{
    if (!c.session.storeSlot(side)) return;
    c.session.notices.tell(Severity::news,
                           std::string("the picture is kept as ") + (side == 0 ? "A" : "B"));
}

void tone(const ActionContext& c)
{
    Tone& now = c.session.settings.view.tone;
    now = static_cast<Tone>((static_cast<size_t>(now) + 1) % core::enumNames<Tone>().size());
}

void exposure(const ActionContext& c, float stops)
{
    float& now = c.session.settings.view.exposure;
    now = std::clamp(now + stops, -20.0f, 20.0f);
}

void addKey(const ActionContext& c)
{
    if (!c.session.document()) return;
    if (c.arguments.contains("frame"))
        c.session.track.addAt(number(c, "frame"), c.session.navigation.camera());
    else
        c.session.track.add(c.session.navigation.camera());
    const size_t keys = c.session.track.keys().size();
    c.session.notices.tell(Severity::news, "the camera path has " + std::to_string(keys) +
                                               (keys == 1 ? " key" : " keys"));
}

void playPath(const ActionContext& c)
{
    CameraTrack& track = c.session.track;
    if (track.playing())
        track.stop();
    else if (track.keys().size() < 2)
        c.session.notices.tell(Severity::news, "a path needs two keys: K adds one where you stand");
    else
        track.play();
}

void removeKey(const ActionContext& c)
{
    const size_t index = count(c, "index");
    if (index < c.session.track.keys().size()) c.session.track.remove(index);
}

void animation(const ActionContext& c)
{
    AnimationPlayer& player = c.session.player;
    if (c.arguments.empty() && c.session.document() && !(player.duration > 0))
        c.session.notices.tell(Severity::news, "this scene has no animation");
    if (c.arguments.contains("time"))
        player.time = std::clamp(number(c, "time"), 0.0, player.duration);
    player.speed = std::clamp(number(c, "speed", player.speed), 0.01, 100.0);
    player.playing =
        player.duration > 0 &&
        truth(c, "play", c.arguments.contains("time") ? player.playing : !player.playing);
}

void cancel(const ActionContext& c)
{
    if (!c.arguments.contains("what")) return c.session.cancel();
    const std::span<const std::string_view> names = core::enumNames<Work>();
    const auto found = std::ranges::find(names, text(c, "what"));
    if (found == names.end()) refuse("what", "load, background, equal-time, path or animation");
    c.session.cancel(static_cast<Work>(found - names.begin()));
}

void speed(const ActionContext& c, double factor)
{
    c.session.navigation.setSpeed(c.session.navigation.speed() * factor);
}

}  // namespace

std::span<const Action> actions()
{
    using C = const ActionContext&;
    static constexpr std::array kActions{
        // picture
        Action{"pause", "Space", "", "pause or go on", [](C c) { flip(c.session.paused); }},
        Action{"restart",
               "R",
               "",
               "begin the picture anew",
               [](C c) { c.session.restart(); },
               {.picture = true}},
        Action{"show-color", "1", "", "show the picture", showAction<Show::color>},
        Action{"show-depth", "2", "", "show distances of first hits", showAction<Show::depth>},
        Action{"show-normal", "3", "", "show shading normals", showAction<Show::normal>},
        Action{"show-albedo", "4", "", "show reflectances", showAction<Show::albedo>},
        Action{"show-triangle", "5", "", "show triangles", showAction<Show::triangle>},
        Action{"show-material", "6", "", "show materials", showAction<Show::material>},
        Action{"show-emitter", "7", "", "show emitters", showAction<Show::emitter>},
        Action{"show-samples", "8", "", "show samples per pixel", showAction<Show::samples>},
        Action{"show-deviation", "9", "", "show the standard deviation of each pixel",
               showAction<Show::deviation>},
        Action{"show-difference", "D", "", "show the difference from the reference",
               showAction<Show::difference>},
        Action{"show-error", "Shift+D", "", "show the error against the reference as a map",
               showAction<Show::error>},
        Action{"show-flip", "Ctrl+D", "", "show the error as a viewer sees it (FLIP)",
               showAction<Show::flip>},
        Action{"next-map", "0", "", "show the method's own maps, one after the other", nextMap},
        Action{"brighter", "E", "", "exposure up by half a stop", [](C c) { exposure(c, 0.5f); }},
        Action{"darker", "Shift+E", "", "exposure down by half a stop",
               [](C c) { exposure(c, -0.5f); }},
        Action{"expose", "Ctrl+E", "", "expose for the picture: its middle becomes mid-grey",
               [](C c) { c.session.expose(); }},
        Action{"tone", "T", "", "next tone curve", tone},
        // camera
        Action{"focus", "F", "x, y", "look at the whole scene; within a room at the room",
               [](C c) {
                   if (c.arguments.contains("x"))
                       c.session.focusAt({number(c, "x"), number(c, "y")});
                   else
                       c.session.frameScene();
               }},
        Action{"home", "Home", "", "the scene's camera", [](C c) { c.session.goHome(); }},
        Action{"previous-view", "Backspace", "", "back to the view before",
               [](C c) { c.session.goBack(); }},
        Action{"next-view", "Shift+Backspace", "", "forward again",
               [](C c) { c.session.goForward(); }},
        Action{"fly-mode", "G", "", "fly with W A S D Q E, or orbit",
               [](C c) { flip(c.session.flying); }},
        Action{"faster", "=", "", "fly faster", [](C c) { speed(c, 1.25); }},
        Action{"slower", "-", "", "fly slower", [](C c) { speed(c, 0.8); }},
        Action{"orbit", "", "dx, dy", "turn about the pivot, in heights of the picture",
               [](C c) {
                   c.session.navigation.orbit(number(c, "dx", 0), number(c, "dy", 0));
                   c.session.moved();
               }},
        Action{"pan", "", "dx, dy", "move sideways",
               [](C c) {
                   c.session.navigation.pan(number(c, "dx", 0), number(c, "dy", 0));
                   c.session.moved();
               }},
        Action{"dolly", "", "steps, x, y", "move towards the pivot; with x, y: as the wheel there",
               dolly},
        Action{"look", "", "dx, dy", "turn about the eye",
               [](C c) {
                   c.session.navigation.look(number(c, "dx", 0), number(c, "dy", 0));
                   c.session.moved();
               }},
        Action{"fly", "", "right, up, forward, seconds, fast, slow", "fly for a time", flyAction},
        Action{"use-camera", "", "index", "a camera of the scene",
               [](C c) { c.session.useSceneCamera(count(c, "index")); }},
        Action{"save-camera", "Ctrl+K", "name", "keep this view with the scene",
               [](C c) { c.session.saveCamera(text(c, "name", "")); }},
        Action{"use-saved-camera", "", "index", "a view that was kept",
               [](C c) { c.session.useSavedCamera(count(c, "index")); }},
        Action{"remove-saved-camera", "", "index", "forget a view",
               [](C c) { c.session.removeSavedCamera(count(c, "index")); }},
        Action{"copy-camera", "Ctrl+C", "", "the view as JSON to the clipboard",
               [](C c) {
                   c.app.toClipboard = c.session.cameraText();
                   c.session.notices.tell(Severity::news, "the view is in the clipboard");
               }},
        Action{"paste-camera", "Ctrl+V", "json", "a view from the clipboard",
               [](C c) {
                   if (c.arguments.contains("json"))
                       c.session.pasteCamera(text(c, "json"));
                   else
                       c.app.pasteCamera = true;
               }},
        Action{"add-key", "K", "frame", "add a key of the camera path here", addKey},
        Action{"remove-key", "", "index", "remove a key", removeKey},
        Action{"clear-path",
               "",
               "",
               "remove all keys",
               [](C c) { c.session.track.clear(); },
               {.path = true}},
        Action{"play-path", "L", "", "play the camera path, or stop", playPath},
        Action{"load-path", "", "file", "read a camera path", loadPathAction, {.path = true}},
        Action{"save-path", "", "file, replace", "write the camera path", savePathAction},
        Action{"export-path", "", "file, spp, replace", "render the path's frames to files (%04d)",
               exportPathAction},
        Action{"animation", "N", "play, time, speed", "play the scene's animation, or stop",
               animation},
        // comparison
        Action{"compare", "C", "", "the slider between A and B",
               [](C c) { flip(c.session.comparing); }},
        Action{"store-a", "[", "", "keep the picture as A", [](C c) { slot(c, 0); }, {.a = true}},
        Action{"store-b", "]", "", "keep the picture as B", [](C c) { slot(c, 1); }, {.b = true}},
        Action{"swap", "\\", "", "swap A and B", [](C c) { c.session.swapSlots(); }},
        Action{"clear-slots",
               "",
               "",
               "both sides live again",
               [](C c) {
                   c.session.slots = {};
                   c.session.chosenParams = {};
               },
               {.a = true, .b = true}},
        Action{"live-a",
               "",
               "",
               "what is being rendered as A",
               [](C c) { c.session.slots[0] = {}; },
               {.a = true}},
        Action{"live-b",
               "",
               "",
               "what is being rendered as B",
               [](C c) { c.session.slots[1] = {}; },
               {.b = true}},
        Action{"params-a", "", "params", "choose the panel's parameters for A at equal time",
               [](C c) { chooseParamsAction(c, 0); }},
        Action{"params-b", "", "params", "choose the panel's parameters for B at equal time",
               [](C c) { chooseParamsAction(c, 1); }},
        Action{"use-params", "", "side", "the parameters of A or B into the panel",
               useParamsAction},
        Action{"equal-time",
               "",
               "seconds, a, b",
               "render A's parameters, then B's, for the same time",
               equalTimeAction,
               {.picture = true, .a = true, .b = true}},
        Action{"copy-comparison", "", "", "the errors of A and B to the clipboard",
               copyComparisonAction},
        Action{"reference",
               "B",
               "spp, method",
               "render a reference in the background",
               referenceAction,
               {.reference = true},
               [](const Session& session) {
                   const core::JobStatus job = session.coreThread();
                   return job.active() && job.name != kReferenceJob;
               }},
        Action{"keep-reference",
               "Shift+B",
               "",
               "keep the picture as the reference",
               [](C c) { c.session.keepAsReference(); },
               {.reference = true}},
        Action{"load-reference",
               "",
               "file",
               "a reference from a file",
               [](C c) { c.session.loadReference(fileName(c, "file")); },
               {.reference = true}},
        Action{"drop-reference",
               "",
               "",
               "forget the reference",
               [](C c) { c.session.dropReference(); },
               {.reference = true}},
        Action{"clear-curves", "", "", "forget the curves of earlier pictures",
               [](C c) { c.session.clearCurves(); }},
        // files
        Action{"open", "Ctrl+O", "", "look for a scene to open",
               [](C c) { c.app.openPathBox = true; }},
        Action{"load", "", "file", "load a scene",
               [](C c) { c.session.load(fs::path(fileName(c, "file"))); }, kPartsOfScene},
        Action{"environment",
               "",
               "what",
               "a panorama around the scene; or plain, none, own, auto",
               [](C c) { c.session.setEnvironment(text(c, "what")); },
               {.picture = true, .a = true, .b = true, .reference = true}},
        Action{"replay", "", "file", "the view of a saved picture",
               [](C c) { c.session.replay(fileName(c, "file")); }, kPartsOfScene},
        Action{"save", "Ctrl+S", "file, replace", "save the picture (EXR, or PNG by its name)",
               saveAction},
        Action{"screenshot", "F12", "file, panel", "the window as PNG", screenshotAction},
        Action{"screenshot-picture", "Shift+F12", "", "the picture's area alone as PNG",
               [](C c) {
                   c.app.screenshot = newName(".png");
                   c.app.screenshotWithPanel = false;
               }},
        // parameters
        Action{"set", "", "name, value", "set any parameter by its name", setAction},
        Action{"preset", "", "name", "a named set of parameters", presetAction},
        // window
        Action{"help", "H", "", "the list of keys",
               [](C c) { flip(c.session.settings.panels.help); }},
        Action{"help-f1", "F1", "", "the list of keys",
               [](C c) { flip(c.session.settings.panels.help); }},
        Action{"panel", "F2", "", "hide or show everything over the picture",
               [](C c) { flip(c.session.settings.panels.panel); }},
        Action{"fold-panel", "Tab", "", "fold the panel away, or open it again",
               [](C c) { c.app.foldPanel = true; }},
        Action{"panel-side", "", "", "the panel at the other edge of the window",
               [](C c) {
                   PanelSide& side = c.session.settings.panels.side;
                   side = side == PanelSide::left ? PanelSide::right : PanelSide::left;
               }},
        Action{"plot", "O", "", "error over time", [](C c) { c.app.togglePlot = true; }},
        Action{"profiler", "P", "", "times and memory",
               [](C c) { flip(c.session.settings.panels.profiler); }},
        Action{"log", "`", "", "messages", [](C c) { flip(c.session.settings.panels.log); }},
        Action{"resize", "", "width, height", "size of the window",
               [](C c) { c.app.resize = glm::uvec2(count(c, "width"), count(c, "height")); }},
        Action{"cancel", "", "what", "cancel this work; without a name all", cancel},
        Action{"escape", "Esc", "",
               "close a list or a box, cancel the newest work, stop flying, quit",
               [](C c) { c.app.escape = true; }},
        Action{"quit", "Ctrl+Q", "", "quit; asks when more than a minute of rendering is lost",
               [](C c) { c.app.leave = true; }},
        Action{"quit-now", "", "", "quit, whatever is lost", [](C c) { c.app.quit = true; }},
        Action{"save-and-quit", "", "file", "save what would be lost, each to a new file, and quit",
               saveAndQuitAction},
    };
    return kActions;
}

}  // namespace app
