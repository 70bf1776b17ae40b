// Dark greys with a trace of blue, which keep out of the picture's way, and one accent, the colour
// of embers. Text on its background has a contrast of at least 7 to 1, hints 4.5 to 1 (tested).
#include "app/view/gui_style.h"

#include <cmath>
#include <cstdlib>
#include <sstream>

#include <imgui.h>

namespace app {

namespace fs = std::filesystem;

namespace {

constexpr float kTextPixels = 15;
const ImVec4 kAccent{0.94f, 0.53f, 0.26f, 1.0f};

ImVec4 grey(float level, float alpha = 1)
{
    return {level * 0.96f, level, level * 1.09f, alpha};
}

ImVec4 accent(float alpha)
{
    return {kAccent.x, kAccent.y, kAccent.z, alpha};
}

void setColours(ImVec4* c)
{
    c[ImGuiCol_Text] = grey(0.90f);
    c[ImGuiCol_TextDisabled] = grey(0.56f);
    c[ImGuiCol_WindowBg] = grey(0.085f, 0.94f);
    c[ImGuiCol_ChildBg] = {0, 0, 0, 0};
    c[ImGuiCol_PopupBg] = grey(0.11f, 0.98f);
    c[ImGuiCol_Border] = grey(1.0f, 0.10f);
    c[ImGuiCol_BorderShadow] = {0, 0, 0, 0};
    c[ImGuiCol_FrameBg] = grey(0.155f);
    c[ImGuiCol_FrameBgHovered] = grey(0.20f);
    c[ImGuiCol_FrameBgActive] = grey(0.24f);
    c[ImGuiCol_TitleBg] = grey(0.07f);
    c[ImGuiCol_TitleBgActive] = grey(0.07f);
    c[ImGuiCol_TitleBgCollapsed] = grey(0.07f, 0.8f);
    c[ImGuiCol_MenuBarBg] = grey(0.10f);
    c[ImGuiCol_ScrollbarBg] = {0, 0, 0, 0};
    c[ImGuiCol_ScrollbarGrab] = grey(0.28f);
    c[ImGuiCol_ScrollbarGrabHovered] = grey(0.36f);
    c[ImGuiCol_ScrollbarGrabActive] = grey(0.44f);
    c[ImGuiCol_CheckMark] = kAccent;
    c[ImGuiCol_SliderGrab] = accent(0.25f);  // it may lie on the number
    c[ImGuiCol_SliderGrabActive] = accent(0.4f);
    c[ImGuiCol_Button] = grey(0.20f);
    c[ImGuiCol_ButtonHovered] = grey(0.27f);
    c[ImGuiCol_ButtonActive] = accent(0.55f);
    c[ImGuiCol_Header] = grey(0.17f);
    c[ImGuiCol_HeaderHovered] = grey(0.23f);
    c[ImGuiCol_HeaderActive] = grey(0.27f);
    c[ImGuiCol_Separator] = grey(1.0f, 0.09f);
    c[ImGuiCol_SeparatorHovered] = accent(0.6f);
    c[ImGuiCol_SeparatorActive] = kAccent;
    c[ImGuiCol_ResizeGrip] = grey(1.0f, 0.06f);
    c[ImGuiCol_ResizeGripHovered] = accent(0.6f);
    c[ImGuiCol_ResizeGripActive] = kAccent;
    c[ImGuiCol_Tab] = grey(0.13f);
    c[ImGuiCol_TabHovered] = grey(0.27f);
    c[ImGuiCol_TabActive] = grey(0.22f);
    c[ImGuiCol_TabUnfocused] = grey(0.13f);
    c[ImGuiCol_TabUnfocusedActive] = grey(0.20f);
    c[ImGuiCol_PlotLines] = grey(0.75f);
    c[ImGuiCol_PlotLinesHovered] = kAccent;
    c[ImGuiCol_PlotHistogram] = accent(0.9f);
    c[ImGuiCol_PlotHistogramHovered] = kAccent;
    c[ImGuiCol_TableHeaderBg] = grey(0.13f);
    c[ImGuiCol_TableBorderStrong] = grey(1.0f, 0.12f);
    c[ImGuiCol_TableBorderLight] = grey(1.0f, 0.06f);
    c[ImGuiCol_TableRowBg] = {0, 0, 0, 0};
    c[ImGuiCol_TableRowBgAlt] = grey(1.0f, 0.025f);
    c[ImGuiCol_TextSelectedBg] = accent(0.35f);
    c[ImGuiCol_DragDropTarget] = kAccent;
    c[ImGuiCol_NavHighlight] = kAccent;
    c[ImGuiCol_NavWindowingHighlight] = grey(1.0f, 0.7f);
    c[ImGuiCol_NavWindowingDimBg] = {0, 0, 0, 0.4f};
    c[ImGuiCol_ModalWindowDimBg] = {0, 0, 0, 0.5f};
}

/// Letters, digits and the signs that a program about numbers and pictures writes.
const ImWchar* glyphs()
{
    static const ImWchar ranges[] = {
        0x0020, 0x024f,  // Latin
        0x0370, 0x03ff,  // Greek
        0x0400, 0x052f,  // Cyrillic, in names of files
        0x1e00, 0x1eff,  // Latin, as of Vietnam
        0x2010, 0x205e,  // dashes, quotes, ellipsis
        0x2070, 0x209f,  // superscripts, subscripts
        0x2190, 0x21ff,  // arrows
        0x2200, 0x22ff,  // mathematics
        0x25a0, 0x25ff,  // triangles, circles
        0x2713, 0x2717,  // check mark, cross
        0,
    };
    return ranges;
}

}  // namespace

ImGuiStyle baseStyle()
{
    ImGuiStyle style;
    style.WindowPadding = {14, 12};
    style.FramePadding = {8, 4};
    style.ItemSpacing = {8, 7};
    style.ItemInnerSpacing = {7, 5};
    style.CellPadding = {6, 3};
    style.IndentSpacing = 16;
    style.ScrollbarSize = 12;
    style.GrabMinSize = 12;
    style.WindowRounding = 9;
    style.ChildRounding = 6;
    style.FrameRounding = 5;
    style.PopupRounding = 7;
    style.ScrollbarRounding = 9;
    style.GrabRounding = 4;
    style.TabRounding = 5;
    style.WindowBorderSize = 1;
    style.FrameBorderSize = 0;
    style.PopupBorderSize = 1;
    style.WindowTitleAlign = {0.0f, 0.5f};
    style.WindowMenuButtonPosition = ImGuiDir_Right;
    setColours(style.Colors);
    return style;
}

std::vector<fs::path> fontFolders()
{
    const auto variable = [](const char* name, const std::string& otherwise) {
        const char* value = std::getenv(name);
        return value != nullptr && *value != '\0' ? std::string(value) : otherwise;
    };
    const std::string home = variable("HOME", "");
    const std::string own = variable("XDG_DATA_HOME", home.empty() ? "" : home + "/.local/share");
    std::istringstream data(own + ':' + variable("XDG_DATA_DIRS", "/usr/local/share:/usr/share"));
    std::vector<fs::path> folders;
    for (std::string folder; std::getline(data, folder, ':');) {
        if (folder.empty()) continue;
        for (const char* kind : {"truetype/dejavu", "dejavu-sans-fonts", "dejavu-sans-mono-fonts",
                                 "TTF", "truetype", "dejavu", "."})
            folders.push_back(fs::path(folder) / "fonts" / kind);
    }
    return folders;
}

fs::path findFont(const std::string& name, const std::vector<fs::path>& folders)
{
    std::error_code none;
    for (const fs::path& folder : folders)
        if (fs::is_regular_file(folder / name, none)) return folder / name;
    return {};
}

void addFonts(ImFontAtlas& atlas, float scale)
{
    const std::vector<fs::path> folders = fontFolders();
    const float pixels = std::round(kTextPixels * scale);
    atlas.Clear();
    ImFontConfig config;
    config.OversampleH = 2;
    config.OversampleV = 1;
    config.PixelSnapH = false;
    for (const char* name : {"DejaVuSans.ttf", "DejaVuSansMono.ttf"}) {
        const fs::path file = findFont(name, folders);
        if (!file.empty() &&
            atlas.AddFontFromFileTTF(file.c_str(), pixels, &config, glyphs()) != nullptr) {
            continue;
        }
        ImFontConfig builtIn;  // one width, Latin only, made for 13 pixels
        builtIn.SizePixels = std::round(13 * scale);
        atlas.AddFontDefault(&builtIn);
    }
}

}  // namespace app
