// Windows and lists of Dear ImGui that its public calls cannot reach.
#pragma once

#include <imgui.h>

namespace app {

/// Closes the list, menu or question that was opened last; false when none is open. Between
/// NewFrame and the windows of the frame.
bool closeInnermostPopup();

/// Draws the present window (between its Begin and End) in front of all others.
void bringToFront();

/// Where the window of that name stands, the hand's last motion included; false when it was not
/// drawn in the frame before.
bool lastPlace(const char* name, ImVec2& corner, ImVec2& size);

}  // namespace app
