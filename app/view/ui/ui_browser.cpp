// The window that looks for a scene: a line to type a path into, the folder that it names, the
// scenes that were open before.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <utility>

#include "app/files/path_completion.h"
#include "app/files/scene_path.h"
#include "app/view/imgui/input.h"
#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUp = "..";

std::string folderOf(const std::string& typed)
{
    return typed.substr(0, typed.rfind('/') + 1);  // nothing without a slash
}

bool contains(const std::string& name, const std::string& part)
{
    const auto same = [](unsigned char a, unsigned char b) {
        return std::tolower(a) == std::tolower(b);
    };
    const auto found = std::search(name.begin(), name.end(), part.begin(), part.end(), same);
    return found != name.end() || part.empty();
}

/// The folder of the scene on show, or the one that the program runs in.
std::string startFolder(const Session& session)
{
    const Document* document = session.document();
    std::error_code unknown;
    const fs::path folder = document != nullptr && document->file.has_parent_path()
                                ? document->file.parent_path()
                                : fs::current_path(unknown);
    return folder.string() + (folder.string().ends_with('/') ? "" : "/");
}

void readFolder(SceneBrowser& browser)
{
    const std::string folder = expandHome(folderOf(browser.box.text));
    browser.listed = browser.box.text;
    browser.chosen = -1;
    const std::string part = browser.box.text.substr(folderOf(browser.box.text).size());
    const bool hidden = part.starts_with('.') && part != kUp;
    browser.entries = listFolder(folder.empty() ? "." : folder, sceneExtensions(),
                                 hidden ? HiddenNames::alone : HiddenNames::leftOut);
    std::erase_if(browser.entries,
                  [&](const FolderEntry& entry) { return !contains(entry.name, part); });
    browser.entries.insert(browser.entries.begin(), {kUp, true});
}

void goTo(SceneBrowser& browser, const std::string& path)
{
    browser.box.text = path;
    browser.box.focus = browser.box.caretAtEnd = true;
}

std::string above(const std::string& typed)
{
    std::error_code unknown;
    const std::string folder = expandHome(folderOf(typed));
    fs::path path = fs::absolute(folder.empty() ? "." : folder, unknown).lexically_normal();
    if (!path.has_filename()) path = path.parent_path();
    const std::string text = path.parent_path().string();
    return text + (text.ends_with('/') ? "" : "/");
}

void open(const UiContext& c, const std::string& path)
{
    c.act("load", {{"file", path}});
    c.state.browser.open = false;
}

/// What a press of Enter or a second click on it does.
void take(const UiContext& c, const FolderEntry& entry)
{
    SceneBrowser& browser = c.state.browser;
    const std::string folder = folderOf(browser.box.text);
    if (entry.folder && entry.name == kUp)
        goTo(browser, above(browser.box.text));
    else if (entry.folder)
        goTo(browser, folder + entry.name + "/");
    else
        open(c, expandHome(folder + entry.name));
}

/// A folder is gone into, unless one scene is in it; a name that is not there stands for the only
/// file that it is a part of.
void takeTyped(const UiContext& c)
{
    SceneBrowser& browser = c.state.browser;
    const std::string path = expandHome(browser.box.text);
    if (path.empty()) return;
    std::error_code unknown;
    if (!fs::exists(path, unknown)) {
        const auto isFile = [](const FolderEntry& entry) { return !entry.folder; };
        const auto found = std::ranges::find_if(browser.entries, isFile);
        if (std::ranges::count_if(browser.entries, isFile) == 1) return take(c, *found);
    }
    if (!fs::is_directory(path, unknown)) return open(c, path);
    const auto inside = listFolder(path, sceneExtensions());
    const auto scenes =
        std::ranges::count_if(inside, [](const FolderEntry& entry) { return !entry.folder; });
    if (scenes == 1) return open(c, path);
    goTo(browser, path + (path.ends_with('/') ? "" : "/"));
}

/// Enter, or the button.
void confirm(const UiContext& c)
{
    const SceneBrowser& browser = c.state.browser;
    const auto chosen = static_cast<size_t>(browser.chosen);
    if (browser.chosen < 0 || chosen >= browser.entries.size()) return takeTyped(c);
    take(c, browser.entries[chosen]);
}

void drawRow(const UiContext& c, size_t index, bool moved)
{
    SceneBrowser& browser = c.state.browser;
    const FolderEntry& entry = browser.entries[index];
    const bool chosen = browser.chosen == static_cast<int>(index);
    const std::string name = entry.folder ? entry.name + "/" : entry.name;
    ImGui::PushID(static_cast<int>(index));
    if (ImGui::Selectable(name.c_str(), chosen, ImGuiSelectableFlags_AllowDoubleClick)) {
        browser.chosen = static_cast<int>(index);
        if (entry.folder || ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) confirm(c);
    }
    if (chosen && moved) ImGui::SetScrollHereY();
    if (!entry.folder) {
        const std::string size = bytesText(entry.bytes);
        ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(size.c_str()).x);
        ImGui::TextDisabled("%s", size.c_str());
    }
    ImGui::PopID();
}

/// By the arrow keys; whether it moved.
bool moveChoice(SceneBrowser& browser)
{
    const int step = std::exchange(browser.box.arrows, 0);
    browser.chosen =
        std::clamp(browser.chosen + step, -1, static_cast<int>(browser.entries.size()) - 1);
    return step != 0;
}

void drawList(const UiContext& c)
{
    SceneBrowser& browser = c.state.browser;
    const bool moved = moveChoice(browser);
    const float height = std::min(14 * ImGui::GetTextLineHeightWithSpacing(), 0.4f * c.window.y);
    ImGui::BeginChild("##entries", ImVec2(0, height), true);
    for (size_t i = 0; i < browser.entries.size(); ++i) drawRow(c, i, moved);
    if (browser.entries.size() <= 1) dimText("no scene (.gltf, .glb) and no folder of that name");
    ImGui::EndChild();
}

void drawContents(const UiContext& c)
{
    SceneBrowser& browser = c.state.browser;
    if (pathInput(browser.box, "scene", "path of a .gltf or .glb", sceneExtensions())) confirm(c);
    if (browser.listed != browser.box.text) readFolder(browser);
    drawList(c);
    if (plainButton("Open", "what is chosen, or the path above")) confirm(c);
    ImGui::SameLine();
    dimText("Tab completes, arrows choose, Enter opens, Esc closes.");
    const std::string recent = drawRecentScenes(browser.recent);
    if (!recent.empty()) open(c, recent);
}

}  // namespace

void drawSceneBrowser(const UiContext& c)
{
    SceneBrowser& browser = c.state.browser;
    if (c.app.openPathBox) {
        c.app.openPathBox = false;
        browser.open = browser.box.focus = browser.box.ownList = true;
        browser.box.text = startFolder(c.session);
        browser.listed.clear();
        browser.recent = recentScenes(c.session);
    }
    if (!browser.open) return;
    const float width = std::min(44 * c.em, c.window.x - 2 * c.em);
    ImGui::SetNextWindowPos(ImVec2(c.window.x / 2, std::min(4 * c.em, 0.15f * c.window.y)),
                            ImGuiCond_Always, ImVec2(0.5f, 0));
    ImGui::SetNextWindowSizeConstraints(ImVec2(width, 0), ImVec2(width, c.window.y));
    constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoMove |
                                        ImGuiWindowFlags_NoSavedSettings |
                                        ImGuiWindowFlags_AlwaysAutoResize;
    ImGui::SetNextWindowBgAlpha(0.98f);
    if (ImGui::Begin("Open a scene###open", &browser.open, kFlags)) {
        drawContents(c);
        if (escapePressed(true)) browser.open = false;
    }
    ImGui::End();
}

}  // namespace app
