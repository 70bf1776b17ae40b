// Section of the panel: cameras, the lens, how fast one flies.
#include <algorithm>
#include <cmath>
#include <optional>

#include <glm/gtc/constants.hpp>

#include "app/camera/lens.h"
#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

/// `more` behind the text, if both have room in the field that comes next.
std::string withMore(const std::string& text, const std::string& more)
{
    const float room = ImGui::CalcItemWidth() - 2 * ImGui::GetStyle().FramePadding.x;
    const float letters = ImGui::CalcTextSize("0000.").x + ImGui::CalcTextSize(text.c_str()).x -
                          ImGui::CalcTextSize("%.4g").x + ImGui::CalcTextSize(more.c_str()).x;
    return letters <= room ? text + more : text;
}

/// A slider of a double in a row of its own, with a way back to `standard` where there is one;
/// true when it changed. `more` is written behind the number where there is room.
bool doubleRow(const char* label, const char* help, double& value, double low, double high,
               const std::string& text, bool logarithmic,
               const std::optional<double>& standard = {}, const std::string& more = {})
{
    ImGui::PushID(label);
    rowLabel(label, help);
    ImGuiSliderFlags flags = ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoRoundToFormat;
    if (logarithmic) flags |= ImGuiSliderFlags_Logarithmic;
    bool changed = ImGui::SliderScalar("##value", ImGuiDataType_Double, &value, &low, &high,
                                       withMore(text, more).c_str(), flags);
    tip(std::string(help) + "\n\nCtrl-click to type.");
    if (rowReset(standard && value != *standard, "that of the scene's camera")) {
        value = *standard;
        changed = true;
    }
    ImGui::PopID();
    return changed;
}

/// The same of a length, of which the world's units differ from metres where it is very small or
/// very large: see core::Placement.
bool lengthRow(const char* label, const char* help, double& value, double low, double high,
               const std::string& text, double perMetre, const std::optional<double>& standard = {},
               const std::string& more = {})
{
    double metres = value / perMetre;
    const auto home = standard ? std::optional(*standard / perMetre) : std::nullopt;
    if (!doubleRow(label, help, metres, low / perMetre, high / perMetre, text, true, home, more))
        return false;
    value = metres == home ? *standard : metres * perMetre;  // to the bit
    return true;
}

/// Of the world's units; 1 without a scene.
double unitsPerMetre(const UiContext& c)
{
    return c.session.document() ? c.session.document()->world->placement.scale : 1;
}

void drawSceneCameras(const UiContext& c)
{
    const Document* document = c.session.document();
    if (document == nullptr) return;
    const auto& cameras = document->world->cameras;
    rowLabel("of the scene", "cameras that the scene file has");
    ImGui::SetNextItemWidth(-1);
    if (!ImGui::BeginCombo("##scene cameras", cameras.empty() ? "none" : "go to...")) return;
    for (size_t i = 0; i < cameras.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        const std::string name =
            cameras[i].name.empty() ? "camera " + std::to_string(i) : cameras[i].name;
        if (ImGui::Selectable(name.c_str())) c.act("use-camera", {{"index", i}});
        ImGui::PopID();
    }
    ImGui::EndCombo();
}

void drawSavedCameras(const UiContext& c)
{
    int removed = -1;
    const auto& cameras = c.session.savedCameras();
    for (size_t i = 0; i < cameras.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        const float cross = buttonWidth("x");
        const float width =
            ImGui::GetContentRegionAvail().x - cross - ImGui::GetStyle().ItemSpacing.x;
        if (ImGui::Selectable(cameras[i].name.c_str(), false, 0,
                              ImVec2(std::max(width, 1.0f), 0))) {
            c.act("use-saved-camera", {{"index", i}});
        }
        tip("go there");
        ImGui::SameLine();
        if (ImGui::SmallButton("x")) removed = static_cast<int>(i);
        tip("forget this view");
        ImGui::PopID();
    }
    if (removed >= 0) c.act("remove-saved-camera", {{"index", removed}});
}

void drawKeep(const UiContext& c)
{
    const std::string why = c.session.document() ? "" : "there is no scene";
    rowLabel("this view", "a view that is kept comes back with the scene");
    ImGui::SetNextItemWidth(std::max(ImGui::GetContentRegionAvail().x - buttonWidth("Keep") -
                                         ImGui::GetStyle().ItemInnerSpacing.x,
                                     2 * c.em));
    const bool entered = textInput("##camera name", "name", c.state.cameraName);
    ImGui::SameLine(0, ImGui::GetStyle().ItemInnerSpacing.x);
    const bool clicked =
        actionButton(c, "Keep", "save-camera", why, {{"name", c.state.cameraName}});
    if (entered && why.empty()) c.act("save-camera", {{"name", c.state.cameraName}});
    if (clicked || entered) c.state.cameraName.clear();
}

bool angleRow(double& yfov, const core::Camera& home)
{
    constexpr double kDegree = glm::pi<double>() / 180;
    double degrees = yfov / kDegree;
    const std::optional<double> standard =
        home.orthographic ? std::nullopt : std::optional(home.yfov / kDegree);
    if (!doubleRow(
            "angle of view",
            "vertical, in degrees, and the focal length on a camera whose film is 24 mm high",
            degrees, 2, 150, "%.1f deg", false, standard, format(", %.0f mm", focalLengthMm(yfov))))
        return false;
    yfov = degrees == standard ? home.yfov : degrees * kDegree;  // to the bit
    return true;
}

void drawLens(const UiContext& c)
{
    const double radius =
        c.session.document()
            ? std::max(static_cast<double>(c.session.document()->world->radius), 1e-3)
            : 1;
    core::Camera& camera = c.session.navigation.edit();
    const core::Camera home = c.session.document() ? c.session.homeCamera() : camera;
    const double perMetre = unitsPerMetre(c);
    bool changed = false;
    std::string opening = "%.4g m", stop;
    if (camera.orthographic) {
        changed |= lengthRow("height", "half the height of what is seen, in metres", camera.ymag,
                             1e-3 * radius, 10 * radius, "%.4g m", perMetre,
                             home.orthographic ? std::optional(home.ymag) : std::nullopt);
    } else {
        changed |= angleRow(camera.yfov, home);
        if (camera.apertureRadius > 0)
            stop = format(", f/%.2g", fNumber(camera.yfov, camera.apertureRadius / perMetre));
    }
    if (camera.apertureRadius == 0) opening = "pinhole";
    changed |= lengthRow(
        "aperture",
        "radius of the lens in metres, and what that is on a camera whose film is 24 mm high; 0 is "
        "a pinhole, where all is sharp",
        camera.apertureRadius, 0, 0.1 * radius, opening, perMetre, home.apertureRadius, stop);
    changed |= lengthRow(
        "focus",
        "distance in metres at which the picture is sharp; a double click on the picture sets it",
        camera.focusDistance, 1e-3 * radius, 10 * radius, "%.4g m", perMetre, home.focusDistance);
    if (changed) c.session.moved();
}

}  // namespace

void drawCameraSection(const UiContext& c)
{
    drawSceneCameras(c);
    drawSavedCameras(c);
    drawKeep(c);
    const std::string why = c.session.document() ? "" : "there is no scene";
    actionButton(c, "Copy", "copy-camera", why);
    sameLineIfRoom(buttonWidth("Paste"));
    actionButton(c, "Paste", "paste-camera", why);
    sameLineIfRoom(buttonWidth("Whole scene"));
    actionButton(c, "Whole scene", "focus", why);
    ImGui::Spacing();
    drawLens(c);
    ImGui::PushID("fly");
    rowLabel("fly", "W A S D, Q and E move, the mouse turns; otherwise the mouse orbits");
    if (bool flying = c.session.flying; ImGui::Checkbox("##value", &flying)) c.act("fly-mode");
    tip("fly or orbit  [" + keyOf("fly-mode") + "]");
    ImGui::PopID();
    double speed = c.session.navigation.speed();
    const double usual =
        c.session.document() ? static_cast<double>(c.session.document()->world->radius) / 4 : 0.25;
    if (lengthRow("speed",
                  "metres per second of flying; Shift is four times as fast, Ctrl a quarter; wheel "
                  "or - and =",
                  speed, usual * 1e-3, usual * 100, "%.3g m/s", unitsPerMetre(c))) {
        c.session.navigation.setSpeed(speed);
    }
}

void drawAnimationSection(const UiContext& c)
{
    AnimationPlayer& player = c.session.player;
    actionButton(c, player.playing ? "Stop" : "Play", "animation", {}, {}, 5 * c.em);
    ImGui::SameLine();
    ImGui::Checkbox("loop", &player.loop);
    doubleRow("time", "seconds of the scene's animation", player.time, 0, player.duration, "%.2f s",
              false);
    doubleRow("pace", "seconds of the animation per second", player.speed, 0.01, 100, "%.2f", true);
}

}  // namespace app
