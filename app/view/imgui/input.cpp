// See input.h.
#include "app/view/imgui/input.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/base/check.h"

#if IMGUI_VERSION_NUM < 18700
#include <GLFW/glfw3.h>
#endif

namespace app {

namespace {

// One table for both: UI_KEY(ImGui's name, GLFW's name).
#if IMGUI_VERSION_NUM >= 18700
#define UI_KEY(imgui, glfw) ImGuiKey_##imgui
constexpr UiKey kFirstLetter = ImGuiKey_A, kFirstDigit = ImGuiKey_0;
#else
#define UI_KEY(imgui, glfw) GLFW_KEY_##glfw
constexpr UiKey kFirstLetter = GLFW_KEY_A, kFirstDigit = GLFW_KEY_0;
#endif

const std::map<std::string, UiKey>& namedKeys()
{
    static const std::map<std::string, UiKey> keys = [] {
        std::map<std::string, UiKey> k{
            {"Space", UI_KEY(Space, SPACE)},
            {"Enter", UI_KEY(Enter, ENTER)},
            {"Tab", UI_KEY(Tab, TAB)},
            {"Esc", UI_KEY(Escape, ESCAPE)},
            {"Escape", UI_KEY(Escape, ESCAPE)},
            {"Backspace", UI_KEY(Backspace, BACKSPACE)},
            {"Delete", UI_KEY(Delete, DELETE)},
            {"Insert", UI_KEY(Insert, INSERT)},
            {"Home", UI_KEY(Home, HOME)},
            {"End", UI_KEY(End, END)},
            {"PageUp", UI_KEY(PageUp, PAGE_UP)},
            {"PageDown", UI_KEY(PageDown, PAGE_DOWN)},
            {"Left", UI_KEY(LeftArrow, LEFT)},
            {"Right", UI_KEY(RightArrow, RIGHT)},
            {"Up", UI_KEY(UpArrow, UP)},
            {"Down", UI_KEY(DownArrow, DOWN)},
            {"Shift", UI_KEY(LeftShift, LEFT_SHIFT)},
            {"Ctrl", UI_KEY(LeftCtrl, LEFT_CONTROL)},
            {"Alt", UI_KEY(LeftAlt, LEFT_ALT)},
            {"Super", UI_KEY(LeftSuper, LEFT_SUPER)},
            {"-", UI_KEY(Minus, MINUS)},
            {"=", UI_KEY(Equal, EQUAL)},
            {"[", UI_KEY(LeftBracket, LEFT_BRACKET)},
            {"]", UI_KEY(RightBracket, RIGHT_BRACKET)},
            {"\\", UI_KEY(Backslash, BACKSLASH)},
            {";", UI_KEY(Semicolon, SEMICOLON)},
            {"'", UI_KEY(Apostrophe, APOSTROPHE)},
            {",", UI_KEY(Comma, COMMA)},
            {".", UI_KEY(Period, PERIOD)},
            {"/", UI_KEY(Slash, SLASH)},
            {"`", UI_KEY(GraveAccent, GRAVE_ACCENT)},
        };
        for (int i = 0; i < 12; ++i)
            k[std::string("F").append(std::to_string(i + 1))] =
                static_cast<UiKey>(UI_KEY(F1, F1) + i);
        for (int i = 0; i < 26; ++i)
            k[std::string(1, static_cast<char>('A' + i))] = static_cast<UiKey>(kFirstLetter + i);
        for (int i = 0; i < 10; ++i) k[std::to_string(i)] = static_cast<UiKey>(kFirstDigit + i);
        return k;
    }();
    return keys;
}

}  // namespace

std::optional<UiKey> findKey(const std::string& name)
{
    const auto found = namedKeys().find(name);
    if (found == namedKeys().end()) return std::nullopt;
    return found->second;
}

bool escapePressed(bool repeat)
{
    return ImGui::IsKeyPressed(UI_KEY(Escape, ESCAPE), repeat);
}

void sendCharacter(unsigned character)
{
    ImGui::GetIO().AddInputCharacter(character);
}

#if IMGUI_VERSION_NUM >= 18700

void KeyLatch::told(int, bool, int) {}
void KeyLatch::apply() {}

void sendKey(UiKey key, bool down)
{
    // The GLFW back end asks the display about modifiers, which knows nothing of what is sent.
    ImGuiIO& io = ImGui::GetIO();
    if (key == ImGuiKey_LeftCtrl) io.AddKeyEvent(ImGuiMod_Ctrl, down);
    if (key == ImGuiKey_LeftShift) io.AddKeyEvent(ImGuiMod_Shift, down);
    if (key == ImGuiKey_LeftAlt) io.AddKeyEvent(ImGuiMod_Alt, down);
    if (key == ImGuiKey_LeftSuper) io.AddKeyEvent(ImGuiMod_Super, down);
    io.AddKeyEvent(key, down);
}

void sendWheel(double steps)
{
    ImGui::GetIO().AddMouseWheelEvent(0, static_cast<float>(steps));
}

void SentPointer::apply()
{
    if (!cursor_) return;
    ImGui::GetIO().AddMousePosEvent(static_cast<float>(cursor_->x), static_cast<float>(cursor_->y));
}

#else

void KeyLatch::told(int key, bool down, int modifiers)
{
    if (key < 0 || key >= static_cast<int>(std::size(ImGui::GetIO().KeysDown))) return;
    std::erase(down_, key);
    if (!down) return;
    down_.push_back(key);
    pressed_.push_back({key, modifiers});
}

void KeyLatch::apply()
{
    ImGuiIO& io = ImGui::GetIO();
    const auto isDown = [this](int key) { return std::ranges::count(down_, key) > 0; };
    const bool let = !held_.empty();
    for (const int key : std::exchange(held_, {}))
        if (!isDown(key)) io.KeysDown[key] = false;
    const auto either = [&](int left, int right) {
        return io.KeysDown[left] || io.KeysDown[right];
    };
    if (let) {  // those of the hand again
        io.KeyCtrl = either(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL);
        io.KeyShift = either(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT);
        io.KeyAlt = either(GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT);
        io.KeySuper = either(GLFW_KEY_LEFT_SUPER, GLFW_KEY_RIGHT_SUPER);
    }
    for (const Press& press : std::exchange(pressed_, {})) {
        if (isDown(press.key)) continue;
        io.KeysDown[press.key] = true;
        held_.push_back(press.key);
        io.KeyCtrl = io.KeyCtrl || (press.modifiers & GLFW_MOD_CONTROL) != 0;
        io.KeyShift = io.KeyShift || (press.modifiers & GLFW_MOD_SHIFT) != 0;
        io.KeyAlt = io.KeyAlt || (press.modifiers & GLFW_MOD_ALT) != 0;
        io.KeySuper = io.KeySuper || (press.modifiers & GLFW_MOD_SUPER) != 0;
    }
}

void sendKey(UiKey key, bool down)
{
    ImGuiIO& io = ImGui::GetIO();
    io.KeysDown[key] = down;
    if (key == GLFW_KEY_LEFT_CONTROL) io.KeyCtrl = down;
    if (key == GLFW_KEY_LEFT_SHIFT) io.KeyShift = down;
    if (key == GLFW_KEY_LEFT_ALT) io.KeyAlt = down;
    if (key == GLFW_KEY_LEFT_SUPER) io.KeySuper = down;
}

void sendWheel(double steps)
{
    ImGui::GetIO().MouseWheel += static_cast<float>(steps);
}

void SentPointer::apply()
{
    ImGuiIO& io = ImGui::GetIO();
    if (cursor_) io.MousePos = {static_cast<float>(cursor_->x), static_cast<float>(cursor_->y)};
    for (size_t i = 0; i < down_.size(); ++i)
        io.MouseDown[i] = io.MouseDown[i] || down_[i] || clicked_[i];
    clicked_.fill(false);
}

#endif

void SentPointer::moveTo(glm::dvec2 pixels)
{
    cursor_ = pixels;
#if IMGUI_VERSION_NUM >= 18700
    apply();  // now, so that it comes before a button that is pressed next
#endif
}

void SentPointer::press(int button, bool down)
{
    if (button < 0 || static_cast<size_t>(button) >= down_.size()) {
        throw core::Error("there is no mouse button " + std::to_string(button) +
                          " — 0 left, 1 right, 2 middle");
    }
#if IMGUI_VERSION_NUM >= 18700
    ImGui::GetIO().AddMouseButtonEvent(button, down);
#endif
    down_[static_cast<size_t>(button)] = down;
    if (down) clicked_[static_cast<size_t>(button)] = true;
}

}  // namespace app
