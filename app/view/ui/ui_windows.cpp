// Windows over the picture: keys and messages.
#include <algorithm>

#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

/// A key and what it does.
struct KeyHelp {
    std::string key, help;
};
struct KeyGroup {
    std::string title;
    std::vector<KeyHelp> keys;
};

std::vector<KeyGroup> keyGroups()
{
    std::vector<KeyGroup> groups{
        {"Mouse",
         {{"left", "orbit, up to walls (View, walls); while flying, look around"},
          {"middle", "orbit, while flying, too"},
          {"right", "pan"},
          {"wheel", "towards what is under the cursor (or the pivot: View, wheel); while flying, "
                    "speed"},
          {"double click", "turn about what is there, and focus on it"},
          {"Ctrl-click", "on a slider of the panel: type the value"},
          {"drop a file",
           "a scene, a .png to return to its view, a reference (.exr), a camera path "
           "(.json)"}}},
        {"Held",
         {{"W A S D Q E", "while flying: move; Shift four times as fast, Ctrl a quarter"},
          {"Shift", "shows the reference"},
          {"Alt", "values of the pixel under the mouse"}}}};
    for (const ActionGroup& group : actionGroups()) {
        KeyGroup made{group.title, {}};
        for (const Action& action : group.actions)
            if (action.key[0] != '\0') made.keys.push_back({action.key, action.help});
        if (!made.keys.empty()) groups.push_back(std::move(made));
    }
    return groups;
}

std::string lower(std::string text)
{
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

/// Leaves what has the words in it; a title that has them keeps all of its keys.
void search(std::vector<KeyGroup>& groups, const std::string& words)
{
    const std::string wanted = lower(words);
    const auto has = [&](const std::string& text) {
        return lower(text).find(wanted) != std::string::npos;
    };
    for (KeyGroup& group : groups) {
        if (has(group.title)) continue;
        std::erase_if(group.keys, [&](const KeyHelp& k) { return !has(k.key) && !has(k.help); });
    }
    std::erase_if(groups, [](const KeyGroup& group) { return group.keys.empty(); });
}

void drawKeyGroup(const UiContext& c, const KeyGroup& group)
{
    dimText(group.title);
    if (!ImGui::BeginTable(group.title.c_str(), 2)) return;
    ImGui::TableSetupColumn("##key", ImGuiTableColumnFlags_WidthFixed, 7.5f * c.em);
    ImGui::TableSetupColumn("##help", ImGuiTableColumnFlags_WidthStretch);
    for (const KeyHelp& key : group.keys) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextColored(ImGui::GetStyleColorVec4(ImGuiCol_CheckMark), "%s", key.key.c_str());
        ImGui::TableNextColumn();
        wrappedText(key.help);
    }
    ImGui::EndTable();
    ImGui::Spacing();
}

/// Groups go one after the other into columns of about the same length.
void drawKeyColumns(const UiContext& c, const std::vector<KeyGroup>& groups)
{
    const int columns =
        std::clamp(static_cast<int>(ImGui::GetContentRegionAvail().x / (20 * c.em)), 1, 3);
    size_t rows = 0, done = 0;
    for (const KeyGroup& group : groups) rows += group.keys.size() + 2;
    if (!ImGui::BeginTable("##columns", columns)) return;
    int column = 0;
    ImGui::TableNextColumn();
    for (const KeyGroup& group : groups) {
        const size_t middle = done + (group.keys.size() + 2) / 2;
        const int wanted =
            static_cast<int>(middle * static_cast<size_t>(columns) / std::max<size_t>(rows, 1));
        for (; column < std::min(wanted, columns - 1); ++column) ImGui::TableNextColumn();
        drawKeyGroup(c, group);
        done += group.keys.size() + 2;
    }
    ImGui::EndTable();
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
    if (beginFloating(c, "Keys and mouse###help", &open, ImVec2(64 * c.em, 38 * c.em),
                      ImVec2(0.5f, 0.4f))) {
        ImGui::SetNextItemWidth(std::min(20 * c.em, ImGui::GetContentRegionAvail().x));
        if (ImGui::IsWindowAppearing()) c.state.search.clear();
        textInput("##search", "search", c.state.search);
        ImGui::BeginChild("##keys");
        std::vector<KeyGroup> groups = keyGroups();
        search(groups, c.state.search);
        if (groups.empty()) dimText("no key does that");
        drawKeyColumns(c, groups);
        ImGui::EndChild();
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
                if (!notice.file.empty() && ImGui::MenuItem("Copy the path"))
                    ImGui::SetClipboardText(notice.file.c_str());
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

}  // namespace app
