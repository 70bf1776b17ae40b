// Scenes that were open before, as tiles: a small picture of each, and its name.
#include <algorithm>
#include <filesystem>

#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

namespace fs = std::filesystem;

constexpr size_t kTiles = 4;  // in a row, and there is one row

/// Fills a rectangle, colours going over from pixel to pixel. A mesh and no texture: the oldest of
/// the panel libraries supported has no other texture than its letters.
void drawSmallPicture(ImVec2 corner, ImVec2 size, const SmallPicture& picture)
{
    constexpr uint32_t kWidth = SmallPicture::kWidth, kHeight = SmallPicture::kHeight;
    constexpr int kCells = (kWidth - 1) * (kHeight - 1);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.PrimReserve(6 * kCells, kWidth * kHeight);
    const auto first = static_cast<ImDrawIdx>(list._VtxCurrentIdx);
    const ImVec2 white = ImGui::GetFontTexUvWhitePixel();
    for (uint32_t y = 0; y < kHeight; ++y)
        for (uint32_t x = 0; x < kWidth; ++x) {
            const uint8_t* c = &picture.bytes[3 * (size_t(y) * kWidth + x)];
            const ImVec2 at(corner.x + size.x * float(x) / (kWidth - 1),
                            corner.y + size.y * float(y) / (kHeight - 1));
            list.PrimWriteVtx(at, white, IM_COL32(c[0], c[1], c[2], 255));
        }
    for (uint32_t y = 0; y + 1 < kHeight; ++y)
        for (uint32_t x = 0; x + 1 < kWidth; ++x)
            for (const uint32_t i : {0u, 1u, kWidth + 1, 0u, kWidth + 1, kWidth})
                list.PrimWriteIdx(static_cast<ImDrawIdx>(first + y * kWidth + x + i));
}

/// True when it was clicked.
bool drawTile(const RecentScene& scene, ImVec2 picture)
{
    const fs::path file(scene.file);
    const float gap = ImGui::GetStyle().FramePadding.x;
    const ImVec2 size(picture.x + 2 * gap,
                      picture.y + 2 * gap + ImGui::GetTextLineHeightWithSpacing());
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const bool clicked = ImGui::Selectable("##tile", false, ImGuiSelectableFlags_None, size);
    tip(scene.file);
    const ImVec2 at(corner.x + gap, corner.y + gap);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    if (scene.picture)
        drawSmallPicture(at, picture, scene.picture);
    else
        list.AddRectFilled(at, ImVec2(at.x + picture.x, at.y + picture.y),
                           ImGui::GetColorU32(ImGuiCol_FrameBg));
    list.AddText(ImVec2(at.x, at.y + picture.y + gap), ImGui::GetColorU32(ImGuiCol_Text),
                 shortenedLabel(file.filename().string(), picture.x).c_str());
    return clicked;
}

}  // namespace

std::vector<RecentScene> recentScenes(const Session& session)
{
    const Document* shown = session.document();
    std::error_code unknown;
    const fs::path current =
        shown != nullptr ? fs::absolute(shown->file, unknown).lexically_normal() : fs::path();
    std::vector<RecentScene> scenes;
    for (const std::string& file : session.settings.recentFiles) {
        if (scenes.size() == kTiles) break;
        if (current == file) continue;
        scenes.push_back({file, session.pictures().find(file)});
    }
    return scenes;
}

std::string drawRecentScenes(const std::vector<RecentScene>& scenes)
{
    if (scenes.empty()) return {};
    std::string chosen;
    ImGui::TextDisabled("Open before");
    const ImGuiStyle& style = ImGui::GetStyle();
    const float room = ImGui::GetContentRegionAvail().x + style.ItemSpacing.x;
    const float width = room / kTiles - style.ItemSpacing.x - 2 * style.FramePadding.x;
    const ImVec2 picture(width, width * SmallPicture::kHeight / SmallPicture::kWidth);
    for (size_t i = 0; i < scenes.size(); ++i) {
        if (i > 0) ImGui::SameLine();
        ImGui::PushID(static_cast<int>(i));
        if (drawTile(scenes[i], picture)) chosen = scenes[i].file;
        ImGui::PopID();
    }
    return chosen;
}

}  // namespace app
