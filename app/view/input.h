// Mouse and keys over the picture: what ImGui does not want moves the camera or runs an action.
#pragma once

#include "app/session/actions.h"
#include "app/session/session.h"
#include "app/view/imgui/input.h"

namespace app {

/// Between ImGui::NewFrame and ImGui::Render; `area` is the picture's. True when the hand did
/// something to the picture.
bool handleInput(Session& session, AppRequests& app, const Area& area, double seconds);

/// "Ctrl+Shift+S" as its modifiers and its key; none when unknown.
struct KeyChord {
    std::optional<UiKey> key;
    bool ctrl = false, shift = false;
};
KeyChord parseKey(const std::string& text);

}  // namespace app
