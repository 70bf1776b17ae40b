// Windows over the picture: keys, messages, the box to open a file, the question before quitting.
#include <algorithm>

#include "app/view/imgui/input.h"
#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

void keyRow(const char* key, const char* help)
{
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextColored(ImGui::GetStyleColorVec4(ImGuiCol_CheckMark), "%s", key);
    ImGui::TableNextColumn();
    ImGui::TextWrapped("%s", help);
}

void heading(const char* text)
{
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::Spacing();
    dimText(text);
}

ImVec4 severityColour(Severity severity)
{
    if (severity == Severity::error) return kErrorColour;
    return severity == Severity::warning ? kWarningColour : ImGui::GetStyleColorVec4(ImGuiCol_Text);
}

std::string noticeLine(const Notice& notice)
{
    return format("%8.1f  ", notice.seconds) + notice.text + timesText(notice);
}

}  // namespace

void drawHelpWindow(const UiContext& c)
{
    bool& open = c.session.settings.panels.help;
    if (!open) return;
    if (beginFloating(c, "Keys and mouse###help", &open, ImVec2(32 * c.em, 34 * c.em),
                      ImVec2(0.5f, 0.4f)) &&
        ImGui::BeginTable("##keys", 2)) {
        ImGui::TableSetupColumn("##key", ImGuiTableColumnFlags_WidthFixed, 8 * c.em);
        ImGui::TableSetupColumn("##help", ImGuiTableColumnFlags_WidthStretch);
        heading("Mouse");
        keyRow("left", "orbit; while flying, look around");
        keyRow("middle, right", "pan");
        keyRow("wheel", "towards the pivot, away from it; while flying, speed");
        keyRow("double click", "turn about what is there, and focus on it");
        keyRow("Ctrl-click", "on a slider of the panel: type the value");
        keyRow("drop a file",
               "a scene, a .png to return to its view, a reference (.exr), a camera path (.json)");
        heading("Keys");
        for (const Action& action : actions()) {
            if (action.key[0] != '\0') keyRow(action.key, action.help);
        }
        keyRow("W A S D Q E", "while flying: move; Shift four times as fast, Ctrl a quarter");
        keyRow("hold Shift", "shows the reference");
        keyRow("hold Alt", "values of the pixel under the mouse");
        ImGui::EndTable();
    }
    ImGui::End();
}

void drawLogWindow(const UiContext& c)
{
    bool& open = c.session.settings.panels.log;
    if (!open) return;
    if (beginFloating(c, "Messages###log", &open, ImVec2(44 * c.em, 16 * c.em),
                      ImVec2(0.5f, 0.9f))) {
        const std::vector<Notice> notices = c.session.notices.list();
        if (plainButton("Copy all", "all messages to the clipboard",
                        notices.empty() ? "there are none" : "")) {
            std::string all;
            for (const Notice& notice : notices) all += noticeLine(notice) + "\n";
            ImGui::SetClipboardText(all.c_str());
        }
        ImGui::SameLine();
        if (plainButton("Clear", "forget all messages", notices.empty() ? "there are none" : "")) {
            c.session.notices.clear();
        }
        ImGui::BeginChild("##messages", ImVec2(0, 0), true);
        for (const Notice& notice : notices) {
            ImGui::PushID(static_cast<int>(notice.number));
            ImGui::PushStyleColor(ImGuiCol_Text, severityColour(notice.severity));
            ImGui::TextWrapped("%s", noticeLine(notice).c_str());
            ImGui::PopStyleColor();
            if (ImGui::BeginPopupContextItem("##message")) {
                if (ImGui::MenuItem("Copy")) ImGui::SetClipboardText(notice.text.c_str());
                ImGui::EndPopup();
            }
            ImGui::PopID();
        }
        if (c.session.notices.count() != c.state.loggedNotices) ImGui::SetScrollHereY(1);
        c.state.loggedNotices = c.session.notices.count();
        ImGui::EndChild();
    }
    ImGui::End();
}

void drawOpenBox(const UiContext& c)
{
    if (c.app.openPathBox) {
        c.app.openPathBox = false;
        c.state.openBox = true;
        c.state.scene.focus = true;
    }
    if (!c.state.openBox) return;
    const float width = std::min(44 * c.em, c.window.x - 2 * c.em);
    ImGui::SetNextWindowPos(ImVec2(c.window.x / 2, std::min(4 * c.em, 0.15f * c.window.y)),
                            ImGuiCond_Always, ImVec2(0.5f, 0));
    ImGui::SetNextWindowSizeConstraints(ImVec2(width, 0), ImVec2(width, c.window.y));
    constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoMove |
                                        ImGuiWindowFlags_NoSavedSettings |
                                        ImGuiWindowFlags_AlwaysAutoResize;
    ImGui::SetNextWindowBgAlpha(0.98f);
    if (ImGui::Begin("Open a scene###open", &c.state.openBox, kFlags)) {
        if (pathInput(c.state.scene, "scene", "path of a .gltf or .glb", {".gltf", ".glb"})) {
            c.act("load", {{"file", c.state.scene.text}});
            c.state.openBox = false;
        }
        dimText("Tab completes, Enter loads, Esc closes.");
        if (escapePressed(true)) c.state.openBox = false;
    }
    ImGui::End();
}

void drawQuitQuestion(const UiContext& c)
{
    if (c.app.askQuit) {
        c.app.askQuit = false;
        ImGui::OpenPopup("Quit?###quit");
    }
    ImGui::SetNextWindowPos(ImVec2(c.window.x / 2, c.window.y / 2), ImGuiCond_Always,
                            ImVec2(0.5f, 0.5f));
    constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_AlwaysAutoResize |
                                        ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings;
    if (!ImGui::BeginPopupModal("Quit?###quit", nullptr, kFlags)) return;
    ImGui::TextUnformatted("The picture is lost unless it was saved.");
    ImGui::Spacing();
    actionButton(c, "Quit", "quit", {}, {}, 6 * c.em);
    ImGui::SameLine();
    const bool stay = ImGui::Button("Stay", ImVec2(6 * c.em, 0));
    // The key that asked is still down in the first frame: it must not answer as well.
    const bool escape = !ImGui::IsWindowAppearing() && escapePressed(false);
    if (stay || escape || c.app.quit) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
}

}  // namespace app
