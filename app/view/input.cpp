// Hands to actions. See input.h. While flying, the letters that fly do nothing else.
#include "app/view/input.h"

#include <cmath>
#include <string_view>
#include <utility>

#include <imgui.h>

#include "core/base/check.h"

namespace app {

namespace {

/// The letters that fly, and what each is as a key.
struct FlyKeys {
    UiKey left = *findKey("A"), right = *findKey("D"), forward = *findKey("W"),
          back = *findKey("S"), up = *findKey("E"), down = *findKey("Q");
    bool contains(UiKey key) const
    {
        return key == left || key == right || key == forward || key == back || key == up ||
               key == down;
    }
};

const FlyKeys& flyKeys()
{
    static const FlyKeys kKeys;
    return kKeys;
}

struct Binding {
    KeyChord chord;
    const Action* action;
};

const std::vector<Binding>& bindings()
{
    static const std::vector<Binding> kBindings = [] {
        std::vector<Binding> list;
        for (const Action& action : actions()) {
            if (action.key[0] == '\0') continue;
            const KeyChord chord = parseKey(action.key);
            CHECK(chord.key.has_value());
            list.push_back({chord, &action});
        }
        return list;
    }();
    return kBindings;
}

double held(UiKey positive, UiKey negative)
{
    return (ImGui::IsKeyDown(positive) ? 1.0 : 0.0) - (ImGui::IsKeyDown(negative) ? 1.0 : 0.0);
}

bool fly(Session& session, double seconds)
{
    const ImGuiIO& io = ImGui::GetIO();
    const FlyKeys& keys = flyKeys();
    if (io.KeyCtrl && (ImGui::IsKeyDown(keys.back) || ImGui::IsKeyDown(keys.down)))
        return false;  // save, quit
    FlyInput input;
    input.right = held(keys.right, keys.left);
    input.up = held(keys.up, keys.down);
    input.forward = held(keys.forward, keys.back);
    input.fast = io.KeyShift;
    input.slow = io.KeyCtrl;
    if (input.right == 0 && input.up == 0 && input.forward == 0) return false;
    session.navigation.fly(input, seconds);
    session.moved();
    return true;
}

/// Whether a key steers while one flies. With Ctrl, which slows down, two of them save and quit.
bool isFlyKey(UiKey key, bool ctrl)
{
    const FlyKeys& keys = flyKeys();
    return keys.contains(key) && !(ctrl && (key == keys.back || key == keys.down));
}

bool runKeys(Session& session, AppRequests& app)
{
    const ImGuiIO& io = ImGui::GetIO();
    bool any = false;
    for (const Binding& binding : bindings()) {
        if (binding.chord.ctrl != io.KeyCtrl || binding.chord.shift != io.KeyShift) continue;
        if (session.flying && isFlyKey(*binding.chord.key, io.KeyCtrl)) continue;
        if (!ImGui::IsKeyPressed(*binding.chord.key, false)) continue;
        runByHand(binding.action->name, session, app);
        any = true;
    }
    return any;
}

/// The wheel flies faster, or goes where the cursor is.
bool wheel(Session& session, glm::dvec2 position)
{
    const auto steps = static_cast<double>(ImGui::GetIO().MouseWheel);
    if (steps == 0) return false;
    Navigation& navigation = session.navigation;
    if (session.flying) {
        navigation.setSpeed(navigation.speed() * std::pow(1.2, steps));
        return false;
    }
    session.dolly(steps, position);
    return true;
}

/// How far the mouse has been dragged with a button held, since the frame before, in heights of the
/// picture. A hand that trembles while it clicks drags nothing: whatever moves the camera begins
/// the picture anew. What it has gone until it counts comes with the first motion.
glm::dvec2 draggedBy(Session& session, ImGuiMouseButton button, double height)
{
    constexpr float kTremble = 3;  // in the units of the mouse
    bool& dragging = session.dragging[static_cast<size_t>(button)];
    const bool before = std::exchange(dragging, ImGui::IsMouseDragging(button, kTremble));
    if (!dragging) return {0, 0};
    const ImVec2 by = before ? ImGui::GetIO().MouseDelta : ImGui::GetMouseDragDelta(button, 0);
    return glm::dvec2(by.x, by.y) / height;
}

/// The left button looks around while one flies; the middle one always orbits.
bool drag(Session& session, double height)
{
    constexpr glm::dvec2 kNone(0);
    const glm::dvec2 left = draggedBy(session, ImGuiMouseButton_Left, height);
    const glm::dvec2 middle = draggedBy(session, ImGuiMouseButton_Middle, height);
    const glm::dvec2 right = draggedBy(session, ImGuiMouseButton_Right, height);
    const glm::dvec2 turn = left != kNone ? left : middle;  // both held turn once
    if (left != kNone && session.flying)
        session.navigation.look(left.x, left.y);
    else if (turn != kNone)
        session.orbit(turn);
    if (right != kNone) session.pan(right);
    const bool any = turn != kNone || right != kNone;
    if (any) session.moved();
    return any;
}

bool mouse(Session& session, const Area& area)
{
    const ImGuiIO& io = ImGui::GetIO();
    if (!session.document() || area.empty()) return false;
    const glm::vec2 at(io.MousePos.x, io.MousePos.y);
    if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left) && area.contains(at)) {
        session.focusAt(area.fraction(at));
        session.moved();
        return true;
    }
    const bool dragged = drag(session, static_cast<double>(area.size.y));
    return (area.contains(at) && wheel(session, area.fraction(at))) || dragged;
}

}  // namespace

KeyChord parseKey(const std::string& text)
{
    KeyChord chord;
    std::string_view rest = text;
    while (true) {
        if (rest.starts_with("Ctrl+"))
            chord.ctrl = true;
        else if (rest.starts_with("Shift+"))
            chord.shift = true;
        else
            break;
        rest.remove_prefix(rest.find('+') + 1);
    }
    chord.key = findKey(std::string(rest));
    return chord;
}

bool handleInput(Session& session, AppRequests& app, const Area& area, double seconds)
{
    const ImGuiIO& io = ImGui::GetIO();
    bool any = false;
    bool reference = false;
    if (!io.WantCaptureKeyboard) {
        any = runKeys(session, app);
        if (session.flying)
            any = fly(session, seconds) || any;
        else
            reference = io.KeyShift && !io.KeyCtrl && session.referenceFits();
    }
    // Held for a moment: Shift with a key or a click is no look at the reference.
    constexpr double kMoment = 0.15;
    session.referenceKeySeconds = reference ? session.referenceKeySeconds + seconds : 0;
    session.holdReference = session.referenceKeySeconds > kMoment;
    if (!io.WantCaptureMouse) any = mouse(session, area) || any;
    return any;
}

}  // namespace app
