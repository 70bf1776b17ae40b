// How everything that Dear ImGui draws looks: colours, spaces, letters.
#pragma once

struct ImGuiStyle;
struct ImFontAtlas;

namespace app {

/// The style at a size of letters of 1; scale it from here, never twice.
ImGuiStyle baseStyle();

/// Fills the atlas anew: font 0 is for text, font 1 has letters of one width, for numbers in
/// columns.
void addFonts(ImFontAtlas& atlas, float scale);

}  // namespace app
