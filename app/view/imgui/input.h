// Keys and input of Dear ImGui, whatever its version. Until 1.86 keys are GLFW's numbers and input
// is written into ImGuiIO as a state; since 1.87 keys have names of their own and input is a queue
// of events. Scripts and tests send theirs through the functions here.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <imgui.h>

namespace app {

#if IMGUI_VERSION_NUM >= 18700
using UiKey = ImGuiKey;  // what ImGui::IsKeyDown and IsKeyPressed take
#else
using UiKey = int;
#endif

/// The key "W", "Space", "F1", "-", "Left", "Ctrl", ...; none when there is no such key.
std::optional<UiKey> findKey(const std::string& name);

/// Whether Esc went down in this frame; with `repeat` also while it is held.
bool escapePressed(bool repeat);

/// A key goes down or up. Left Ctrl, Shift, Alt and Super count as modifiers, too.
void sendKey(UiKey key, bool down);

/// A character was typed.
void sendCharacter(unsigned character);

/// The wheel turned, forward if positive.
void sendWheel(double steps);

/// Keys that go down and up again between two frames. ImGui before 1.87 keeps a state, not a queue,
/// and would not see them: each is held for one frame, with the modifiers that it came with.
class KeyLatch {
public:
    /// Of every key, as GLFW tells it.
    void told(int key, bool down, int modifiers);

    /// Between the back end's NewFrame and ImGui's.
    void apply();

private:
    struct Press {
        int key = 0, modifiers = 0;
    };
    std::vector<Press> pressed_;  // since the last frame
    std::vector<int> held_;       // here, in the last frame
    std::vector<int> down_;       // in truth
};

/// A cursor and buttons that are not the display's.
class SentPointer {
public:
    /// The cursor stays at `pixels` until forgetCursor().
    void moveTo(glm::dvec2 pixels);
    void forgetCursor() { cursor_.reset(); }
    bool hasCursor() const { return cursor_.has_value(); }

    /// Throws core::Error when ImGui has no such button: 0 left, 1 right, 2 middle.
    void press(int button, bool down);

    /// Overrules what the back end has asked the display for. Between the back end's NewFrame and
    /// ImGui's.
    void apply();

private:
    std::optional<glm::dvec2> cursor_;
    std::array<bool, 5> down_{}, clicked_{};  // clicked since the last frame
};

}  // namespace app
