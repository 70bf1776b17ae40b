// GLFW: one window without a client API of its own. Its errors become core::Error where somebody
// waits for the result. Letters are scaled by the display's content scale over the ratio of pixels
// to screen coordinates: where the system enlarges the window's pixels itself (Wayland, macOS) that
// is 1, on X11 it is the content scale.
#include "app/view/window.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <thread>
#include <utility>

#define GLFW_INCLUDE_VULKAN
#include <dlfcn.h>
#include <GLFW/glfw3.h>
#include <imgui.h>

#include "core/base/check.h"

namespace app {

namespace {

std::string lastError;  // GLFW calls back on the thread that called it, which is the main one
std::atomic<bool> connectionLost{false};

void onError(int, const char* text)
{
    lastError = text;
}

/// glfwTerminate() undoes it.
bool startGlfw()
{
    lastError.clear();
    glfwSetErrorCallback(onError);
    return glfwInit() == GLFW_TRUE;
}

template <class F> F symbol(const char* name)
{
    return reinterpret_cast<F>(dlsym(RTLD_DEFAULT, name));
}

/// Xlib ends the process when its connection breaks, unless it is given something else to do. GLFW
/// for Wayland has no X11 in it, so the functions are looked up.
void surviveLostConnection()
{
    connectionLost = false;
    using ErrorHandler = int (*)(void* display);
    using ExitHandler = void (*)(void* display, void* data);
    const auto display = symbol<void* (*)()>("glfwGetX11Display");
    const auto setError = symbol<ErrorHandler (*)(ErrorHandler)>("XSetIOErrorHandler");
    // LibX11 1.7
    const auto setExit = symbol<void (*)(void*, ExitHandler, void*)>("XSetIOErrorExitHandler");
    if (display == nullptr || setError == nullptr || setExit == nullptr || display() == nullptr)
        return;
    setError([](void*) {  // the default prints and exits
        connectionLost = true;
        return 0;
    });
    setExit(
        display(), [](void*, void*) {}, nullptr);
}

const std::map<std::string, int>& namedKeys()
{
    static const std::map<std::string, int> keys = [] {
        std::map<std::string, int> k{
            {"Space", GLFW_KEY_SPACE},
            {"Enter", GLFW_KEY_ENTER},
            {"Tab", GLFW_KEY_TAB},
            {"Esc", GLFW_KEY_ESCAPE},
            {"Escape", GLFW_KEY_ESCAPE},
            {"Backspace", GLFW_KEY_BACKSPACE},
            {"Delete", GLFW_KEY_DELETE},
            {"Insert", GLFW_KEY_INSERT},
            {"Home", GLFW_KEY_HOME},
            {"End", GLFW_KEY_END},
            {"PageUp", GLFW_KEY_PAGE_UP},
            {"PageDown", GLFW_KEY_PAGE_DOWN},
            {"Left", GLFW_KEY_LEFT},
            {"Right", GLFW_KEY_RIGHT},
            {"Up", GLFW_KEY_UP},
            {"Down", GLFW_KEY_DOWN},
            {"Shift", GLFW_KEY_LEFT_SHIFT},
            {"Ctrl", GLFW_KEY_LEFT_CONTROL},
            {"Alt", GLFW_KEY_LEFT_ALT},
            {"Super", GLFW_KEY_LEFT_SUPER},
        };
        for (int i = 1; i <= 12; ++i)
            k[std::string("F").append(std::to_string(i))] = GLFW_KEY_F1 + i - 1;
        // GLFW's numbers of the printable keys are their ASCII codes.
        for (const char c : std::string("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-=[]\\;',./`"))
            k[std::string(1, c)] = c;
        return k;
    }();
    return keys;
}

/// What a printable key types on an American keyboard; 0 for other keys.
unsigned typedBy(int key, bool shift)
{
    const std::string plain = " -=[]\\;',./`0123456789", shifted = " _+{}|:\"<>?~)!@#$%^&*(";
    if (key >= 'A' && key <= 'Z') return static_cast<unsigned>(shift ? key : key - 'A' + 'a');
    const size_t place =
        key > 0 && key < 128 ? plain.find(static_cast<char>(key)) : std::string::npos;
    return place == std::string::npos ? 0u
                                      : static_cast<unsigned>((shift ? shifted : plain)[place]);
}

/// The callback that is installed, so that injected events take the way of real ones.
template <class F> F installed(F (*set)(GLFWwindow*, F), GLFWwindow* window)
{
    const F callback = set(window, nullptr);
    set(window, callback);
    return callback;
}

}  // namespace

Window::Window(const std::string& title, glm::uvec2 size)
{
    if (!startGlfw()) {
        throw core::Error("no window: " + lastError +
                              " — `rekindle render SCENE -o FILE` needs none",
                          core::ExitCode::noDevice);
    }
    surviveLostConnection();
    try {
        if (glfwVulkanSupported() == GLFW_FALSE) {
            throw core::Error("no window: there is no Vulkan loader or it cannot draw in windows — "
                              "install libvulkan1 and "
                              "mesa-vulkan-drivers",
                              core::ExitCode::noDevice);
        }
        glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
        glfwWindowHintString(GLFW_X11_CLASS_NAME, "rekindle");
        glfwWindowHintString(GLFW_X11_INSTANCE_NAME, "rekindle");
        const glm::ivec2 s(glm::clamp(size, 1u, 16384u));
        window_ = glfwCreateWindow(s.x, s.y, title.c_str(), nullptr, nullptr);
        if (window_ == nullptr)
            throw core::Error("no window: " + lastError, core::ExitCode::noDevice);
    } catch (...) {
        glfwTerminate();
        throw;
    }
    glfwSetWindowUserPointer(window_, this);
    glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** files) {
        auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(window));
        for (int i = 0; i < count; ++i) self.drops_.emplace_back(files[i]);
    });
    glfwSetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) {
        static_cast<Window*>(glfwGetWindowUserPointer(window))->onCursor({x, y});
    });
}

Window::~Window()
{
    // Also when the connection is gone: Xlib then sends nothing, and another window can be opened
    // afterwards.
    glfwDestroyWindow(window_);
    glfwTerminate();
}

bool Window::displayAvailable(std::string& reason)
{
    if (!startGlfw()) {
        reason = lastError;
        return false;
    }
    glfwTerminate();
    return true;
}

void Window::poll(double seconds)
{
    if (lost()) {
        std::this_thread::sleep_for(std::chrono::duration<double>(std::min(seconds, 0.1)));
        return;
    }
    if (seconds > 0) {
        glfwWaitEventsTimeout(seconds);
    } else {
        glfwPollEvents();
    }
}

void Window::wake()
{
    if (!connectionLost) glfwPostEmptyEvent();
}

bool Window::closeRequested() const
{
    return lost() || glfwWindowShouldClose(window_) == GLFW_TRUE;
}

void Window::requestClose(bool close)
{
    glfwSetWindowShouldClose(window_, close ? GLFW_TRUE : GLFW_FALSE);
}

bool Window::lost() const
{
    return connectionLost;
}

glm::uvec2 Window::framebufferSize() const
{
    if (lost() || glfwGetWindowAttrib(window_, GLFW_ICONIFIED) == GLFW_TRUE) return glm::uvec2(0);
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    return {static_cast<uint32_t>(std::max(width, 0)), static_cast<uint32_t>(std::max(height, 0))};
}

float Window::contentScale() const
{
    if (lost()) return 1;
    float scale = 1;
    glfwGetWindowContentScale(window_, &scale, nullptr);
    int window = 0, framebuffer = 0;
    glfwGetWindowSize(window_, &window, nullptr);
    glfwGetFramebufferSize(window_, &framebuffer, nullptr);
    const float ratio = window > 0 && framebuffer > 0
                            ? static_cast<float>(framebuffer) / static_cast<float>(window)
                            : 1.0f;
    return std::isfinite(scale) ? std::clamp(scale / ratio, 1.0f, 8.0f) : 1.0f;
}

void Window::resize(glm::uvec2 size)
{
    if (lost()) return;
    const glm::ivec2 s(glm::clamp(size, 1u, 16384u));  // X11 ends the process for zero
    glfwSetWindowSize(window_, s.x, s.y);
}

void Window::setTitle(const std::string& title)
{
    if (!lost()) glfwSetWindowTitle(window_, title.c_str());
}

std::vector<std::filesystem::path> Window::takeDrops()
{
    return std::exchange(drops_, {});
}

std::string Window::clipboard() const
{
    const char* text = lost() ? nullptr : glfwGetClipboardString(window_);
    return text == nullptr ? "" : text;
}

void Window::setClipboard(const std::string& text)
{
    if (!lost()) glfwSetClipboardString(window_, text.c_str());
}

std::vector<const char*> Window::instanceExtensions() const
{
    uint32_t count = 0;
    const char** names = glfwGetRequiredInstanceExtensions(&count);
    if (names == nullptr) {
        throw core::Error("no Vulkan driver can show frames in a window (" + lastError +
                              ") — `rekindle render SCENE -o FILE` needs none",
                          core::ExitCode::noDevice);
    }
    return {names, names + count};
}

VkSurfaceKHR Window::makeSurface(VkInstance instance) const
{
    VkSurfaceKHR surface = VK_NULL_HANDLE;
    lastError.clear();
    const VkResult result = lost() ? VK_ERROR_SURFACE_LOST_KHR
                                   : glfwCreateWindowSurface(instance, window_, nullptr, &surface);
    if (result != VK_SUCCESS) {
        throw core::Error("no frames in the window: the display gave no surface" +
                              (lastError.empty() ? std::string() : " (" + lastError + ")"),
                          core::ExitCode::noDevice);
    }
    return surface;
}

// --- what scripts inject
// ----------------------------------------------------------------------------------------

std::optional<int> Window::keyCode(const std::string& name)
{
    const auto found = namedKeys().find(name);
    if (found == namedKeys().end()) return std::nullopt;
    return found->second;
}

void Window::injectKey(const std::string& key, bool down)
{
    std::vector<int> codes;
    std::string rest = key;
    int modifiers = 0;
    const auto take = [&](const char* prefix, int code, int bit) {
        if (!rest.starts_with(prefix)) return;
        rest = rest.substr(std::string(prefix).size());
        codes.push_back(code);
        modifiers |= bit;
    };
    for (int i = 0; i < 3; ++i) {  // in any order
        take("Ctrl+", GLFW_KEY_LEFT_CONTROL, GLFW_MOD_CONTROL);
        take("Shift+", GLFW_KEY_LEFT_SHIFT, GLFW_MOD_SHIFT);
        take("Alt+", GLFW_KEY_LEFT_ALT, GLFW_MOD_ALT);
    }
    const std::optional<int> code = keyCode(rest);
    if (!code)
        throw core::Error("there is no key \"" + key +
                          "\" — try \"W\", \"Space\", \"Ctrl+S\" or \"F1\"");
    codes.push_back(*code);
    if (!down) std::reverse(codes.begin(), codes.end());

    const GLFWkeyfun onKey = installed(&glfwSetKeyCallback, window_);
    for (const int c : codes) {
        if (onKey != nullptr)
            onKey(window_, c, glfwGetKeyScancode(c), down ? GLFW_PRESS : GLFW_RELEASE, modifiers);
    }
    const unsigned typed = typedBy(*code, (modifiers & GLFW_MOD_SHIFT) != 0);
    const GLFWcharfun onChar = installed(&glfwSetCharCallback, window_);
    if (down && typed != 0 && onChar != nullptr &&
        (modifiers & (GLFW_MOD_CONTROL | GLFW_MOD_ALT)) == 0) {
        onChar(window_, typed);
    }
}

void Window::injectCursor(glm::dvec2 pixels)
{
    const GLFWcursorenterfun onEnter = installed(&glfwSetCursorEnterCallback, window_);
    if (onEnter != nullptr) onEnter(window_, GLFW_TRUE);
    injectedCursor_ = pixels;
}

void Window::injectButton(int button, bool down)
{
    if (button < 0 || static_cast<size_t>(button) >= injectedButtons_.size()) {
        throw core::Error("there is no mouse button " + std::to_string(button) +
                          " — 0 left, 1 right, 2 middle");
    }
    const GLFWmousebuttonfun onButton = installed(&glfwSetMouseButtonCallback, window_);
    if (onButton != nullptr) onButton(window_, button, down ? GLFW_PRESS : GLFW_RELEASE, 0);
    injectedButtons_[static_cast<size_t>(button)] = down;
}

void Window::injectWheel(double steps)
{
    const GLFWscrollfun onScroll = installed(&glfwSetScrollCallback, window_);
    if (onScroll != nullptr) onScroll(window_, 0, steps);
}

void Window::injectDrop(const std::filesystem::path& file)
{
    const GLFWdropfun onDrop = installed(&glfwSetDropCallback, window_);
    const std::string name = file.string();
    const char* names[] = {name.c_str()};
    if (onDrop != nullptr) onDrop(window_, 1, names);
}

void Window::onCursor(glm::dvec2 position)
{
    // Displays report a resting cursor anew when windows change; only real motion takes over.
    if (handCursor_ && glm::distance(*handCursor_, position) > 8) injectedCursor_.reset();
    if (!handCursor_ || !injectedCursor_) handCursor_ = position;
}

void Window::applyInjected()
{
    ImGuiIO& io = ImGui::GetIO();
    if (injectedCursor_)
        io.MousePos = {static_cast<float>(injectedCursor_->x),
                       static_cast<float>(injectedCursor_->y)};
    for (size_t i = 0; i < injectedButtons_.size(); ++i)
        io.MouseDown[i] = io.MouseDown[i] || injectedButtons_[i];
}

}  // namespace app
