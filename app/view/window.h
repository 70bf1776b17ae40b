// The window of the operating system: GLFW, and nothing else of the program sees it. No rendering
// here.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <vulkan/vulkan.h>

#include "app/view/imgui/input.h"

struct GLFWwindow;

namespace app {

class Window {
public:
    /// Throws core::Error (noDevice) when there is no display or no Vulkan loader. One at a time,
    /// on the main thread.
    Window(const std::string& title, glm::uvec2 size);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    /// Whether a display answers at all; says why not in `reason`.
    static bool displayAvailable(std::string& reason);

    /// Handles what has happened; waits for it up to `seconds` (0: does not wait).
    void poll(double seconds);
    /// Ends the wait of poll(). From any thread, while a window lives.
    static void wake();
    bool closeRequested() const;
    void requestClose(bool close);
    bool lost() const;  // the connection to the display is gone: the window is 0x0 and nothing more
                        // comes from it

    glm::uvec2 framebufferSize() const;  // pixels; 0x0 when minimised
    glm::uvec2 size() const;             // as resize() takes it; 0x0 when minimised or lost
    float
    contentScale() const;  // of letters: see the rule for displays of high density in window.cpp
    void resize(glm::uvec2 size);  // screen coordinates; at least 1x1
    void setTitle(const std::string& title);

    bool
    takeExposed();  // whether the display has lost what stood in the window since the last call
    std::vector<std::filesystem::path> takeDrops();  // files dropped since the last call
    std::string clipboard() const;
    void setClipboard(const std::string& text);

    std::vector<const char*> instanceExtensions() const;
    VkSurfaceKHR makeSurface(VkInstance instance) const;
    GLFWwindow* get() const { return window_; }

    // --- for scripts; once a Gui has been made for the window
    /// "W", "Space", "Ctrl+S" (presses the modifiers, too). Throws core::Error for keys that do not
    /// exist.
    void injectKey(const std::string& key, bool down);
    /// Stays there until the hand moves the real one.
    void injectCursor(glm::dvec2 pixels);
    /// 0 left, 1 right, 2 middle; throws core::Error for others.
    void injectButton(int button, bool down);
    void injectWheel(double steps);
    void injectDrop(const std::filesystem::path& file);
    /// Hands ImGui the injected cursor and buttons, which its GLFW back end would ask the display
    /// for, and keys that were too quick for it. Called by Gui between the two NewFrames.
    void applyInjected();

private:
    void onCursor(glm::dvec2 position);

    GLFWwindow* window_ = nullptr;
    std::vector<std::filesystem::path> drops_;
    bool exposed_ = false;
    SentPointer pointer_;
    KeyLatch keys_;
    std::optional<glm::dvec2> handCursor_;
};

}  // namespace app
