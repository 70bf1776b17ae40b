// Windows and lists of Dear ImGui that its public calls cannot reach.
#pragma once

namespace app {

/// Closes the list, menu or question that was opened last; false when none is open. Between
/// NewFrame and the windows of the frame.
bool closeInnermostPopup();

/// Draws the present window (between its Begin and End) in front of all others.
void bringToFront();

/// What the hand has moved and resized, as text; empty unless it has changed since the last call.
const char* changedPlaces();

/// Windows that are drawn for the first time from now on stand where the text says. Text that is
/// not changedPlaces()'s own does no harm.
void recallPlaces(const char* text, unsigned length);

}  // namespace app
