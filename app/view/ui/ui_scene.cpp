// Sections of the panel: the scene, and pictures as files.
#include <algorithm>
#include <filesystem>

#include "app/files/path_completion.h"
#include "app/files/scene_path.h"
#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

namespace fs = std::filesystem;

std::string fileName(const std::string& path)
{
    const fs::path file(path);
    return file.filename().empty() ? path : file.filename().string();
}

void drawDocument(const Document& document)
{
    const core::World& world = *document.world;
    const std::string name =
        document.file.empty() ? "built-in scene" : fileName(document.file.string());
    ImGui::TextUnformatted(name.c_str());
    tip(document.file.string() + "\nloaded in " + secondsText(document.loadSeconds));
    dimText(countedText(core::shownTriangles(world), "triangle") + ", " +
            countedText(world.emitters.size(), "emitter") + ", " +
            countedText(world.materials.size(), "material"));
    if (!world.instances.empty())
        tip(countText(static_cast<double>(world.triangles.size())) + " are stored: " +
            countText(static_cast<double>(world.instances.size())) + " instances show " +
            countText(static_cast<double>(world.prototypes.size())) + " groups of meshes.");
    if (world.emitters.empty()) {
        ImGui::TextColored(kWarningColour, "nothing emits light");
        tip("No emissive material, light, environment or sun: every picture of this scene is "
            "black.");
    }
}

void drawWarnings(const std::vector<std::string>& warnings)
{
    if (warnings.empty()) return;
    ImGui::PushStyleColor(ImGuiCol_Text, kWarningColour);
    const bool open =
        ImGui::TreeNodeEx("##warnings", ImGuiTreeNodeFlags_SpanAvailWidth, "%zu warning%s",
                          warnings.size(), warnings.size() == 1 ? "" : "s");
    ImGui::PopStyleColor();
    tip("What the loader repaired or left out.");
    if (!open) return;
    const float rows = std::min(static_cast<float>(warnings.size()) * 2, 8.0f);
    ImGui::BeginChild("##list", ImVec2(0, rows * ImGui::GetTextLineHeightWithSpacing()), true);
    for (const std::string& warning : warnings) dimText(warning);
    ImGui::EndChild();
    if (plainButton("Copy##warnings", "all warnings to the clipboard")) {
        std::string all;
        for (const std::string& warning : warnings) all += warning + "\n";
        ImGui::SetClipboardText(all.c_str());
    }
    ImGui::TreePop();
}

void drawRecent(const UiContext& c)
{
    // A copy: loading puts the file to the front of the list that is being walked.
    const std::vector<std::string> recent = c.session.settings.recentFiles;
    ImGui::SetNextItemWidth(-1);
    if (!ImGui::BeginCombo("##recent", recent.empty() ? "No recent files" : "Recent files",
                           ImGuiComboFlags_HeightLarge)) {
        return;
    }
    for (size_t i = 0; i < recent.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        if (ImGui::Selectable(fileName(recent[i]).c_str())) c.act("load", {{"file", recent[i]}});
        tip(recent[i]);
        ImGui::PopID();
    }
    ImGui::EndCombo();
}

/// What is around the scene, and a line to ask for something else.
void drawEnvironment(const UiContext& c)
{
    const Document* document = c.session.document();
    if (document == nullptr) return;
    const std::string hint = "around it: " + document->environment;
    if (pathInput(c.state.environment, "environment", hint.c_str(),
                  {".exr", ".hdr", ".png", ".jpg", ".jpeg"}) &&
        !c.state.environment.text.empty()) {
        c.act("environment", {{"what", expandHome(c.state.environment.text)}});
        c.state.environment.text.clear();
    }
    tip("A panorama (.exr, .hdr, .png, .jpg) in place of the scene's own environment and sun; or "
        "plain (a grey sky), none, own, or auto: its own, and the plain one where nothing shines.");
}

}  // namespace

void drawSceneSection(const UiContext& c)
{
    if (const Document* document = c.session.document()) {
        drawDocument(*document);
        drawWarnings(document->warnings);
    } else {
        dimText(c.session.loading().active() ? "loading..." : "no scene");
    }
    if (pathInput(c.state.scene, "scene", "a .gltf or .glb", sceneExtensions())) {
        c.act("load", {{"file", c.state.scene.text}});
    }
    drawRecent(c);
    drawEnvironment(c);
    dimText("Or drop a file on the window: a scene, a .png to return to its view, a reference "
            "(.exr), a camera path (.json).");
}

void drawSaveSection(const UiContext& c)
{
    const std::string none = shownPicture(c) ? "" : "there is no picture yet";
    const bool entered =
        pathInput(c.state.picture, "picture", "name.exr or .png", {".exr", ".png"});
    // What has been typed counts without Enter, too.
    if (c.state.picture.text.empty())
        actionButton(c, "Save EXR", "save", none);
    else if (buttonOf(c, "Save", "save", none) || entered)
        writeTyped(c, "save", {{"file", c.state.picture.text}});
    sameLineIfRoom(buttonWidth("Screenshot"));
    actionButton(c, "Screenshot", "screenshot");
    sameLineIfRoom(buttonWidth("Without panel"));
    actionButton(c, "Without panel", "screenshot-picture");
    dimText("Every picture carries what is needed to render it again: view --replay FILE.");
}

}  // namespace app
