// How everything that Dear ImGui draws looks: colours, spaces, letters.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

struct ImGuiStyle;
struct ImFontAtlas;

namespace app {

/// The style at a size of letters of 1; scale it from here, never twice.
ImGuiStyle baseStyle();

/// Folders in which systems keep fonts, from the XDG variables: below each data folder those of
/// Debian, Fedora, Arch and SUSE, and the user's own.
std::vector<std::filesystem::path> fontFolders();

/// The first file of this name in one of the folders; empty when there is none.
std::filesystem::path findFont(const std::string& name,
                               const std::vector<std::filesystem::path>& folders);

/// Fills the atlas anew: font 0 is for text, font 1 has letters of one width, for numbers in
/// columns.
void addFonts(ImFontAtlas& atlas, float scale);

}  // namespace app
