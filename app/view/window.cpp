// GLFW: one window without a client API of its own. Its errors become core::Error where somebody
// waits for the result. Letters are scaled by the display's content scale over the ratio of pixels
// to screen coordinates: where the system enlarges the window's pixels itself (Wayland, macOS) that
// is 1, on X11 it is the content scale.
#include "app/view/window.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <thread>
#include <utility>

#include <dlfcn.h>
#include <GLFW/glfw3.h>

#include "app/gpu/base/handle.h"
#include "app/view/icon.h"
#include "core/base/check.h"

namespace app {

namespace {

std::string lastError;  // GLFW calls back on the thread that called it, which is the main one
std::atomic<bool> connectionLost{false};

void onError(int, const char* text)
{
    lastError = text;
}

#ifdef GLFW_PLATFORM
/// Whether a variable of the environment says something.
bool isSet(const char* name)
{
    const char* const value = std::getenv(name);
    return value != nullptr && *value != '\0';
}
#endif

/// endGlfw() undoes it.
bool startGlfw()
{
    lastError.clear();
    glfwSetErrorCallback(onError);
#ifdef GLFW_PLATFORM
    // Since 3.4 GLFW tries Wayland first, whose library writes to stderr when there is none.
    if (!isSet("WAYLAND_DISPLAY") && !isSet("WAYLAND_SOCKET") &&
        glfwPlatformSupported(GLFW_PLATFORM_X11))
        glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
#endif
    return glfwInit() == GLFW_TRUE;
}

/// Closes the connection to the display, but not while a device that hangs has been left to itself:
/// its threads may still read from the connection, which then ends with the process.
void endGlfw()
{
    if (!gpu::anyAbandoned()) glfwTerminate();
}

template <class F> F symbol(void* library, const char* name)
{
    return reinterpret_cast<F>(dlsym(library, name));
}

/// Xlib ends the process when its connection breaks, unless it is given something else to do. GLFW
/// for Wayland has no X11 in it, so the functions are looked up, in Xlib itself: since 3.4 GLFW
/// loads it for its own use alone.
void surviveLostConnection()
{
    connectionLost = false;
    using ErrorHandler = int (*)(void* display);
    using ExitHandler = void (*)(void* display, void* data);
    void* const xlib = dlopen("libX11.so.6", RTLD_LAZY | RTLD_NOLOAD);
    if (xlib == nullptr) return;
    const auto display = symbol<void* (*)()>(RTLD_DEFAULT, "glfwGetX11Display");
    const auto setError = symbol<ErrorHandler (*)(ErrorHandler)>(xlib, "XSetIOErrorHandler");
    // LibX11 1.7
    const auto setExit =
        symbol<void (*)(void*, ExitHandler, void*)>(xlib, "XSetIOErrorExitHandler");
    if (display == nullptr || setError == nullptr || setExit == nullptr || display() == nullptr)
        return;
    setError([](void*) {  // the default prints and exits
        connectionLost = true;
        return 0;
    });
    setExit(
        display(), [](void*, void*) {}, nullptr);
}

/// Wayland takes icons from the .desktop file and GLFW complains there: that is no fault.
void setIcon(GLFWwindow* window)
{
    std::vector<std::vector<uint8_t>> pixels;
    std::vector<GLFWimage> images;
    for (const int side : {16, 32, 48, 64, 128}) {
        pixels.push_back(iconPixels(side));
        images.push_back({side, side, pixels.back().data()});
    }
    glfwSetWindowIcon(window, static_cast<int>(images.size()), images.data());
    lastError.clear();
}

/// What a key types on an American keyboard; 0 for other keys.
unsigned typedBy(const std::string& key, bool shift)
{
    const std::string plain = " -=[]\\;',./`0123456789", shifted = " _+{}|:\"<>?~)!@#$%^&*(";
    if (key == "Space") return ' ';
    if (key.size() != 1) return 0;
    const char c = key[0];
    if (c >= 'A' && c <= 'Z') return static_cast<unsigned>(shift ? c : c - 'A' + 'a');
    const size_t place = plain.find(c);
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
#ifdef GLFW_WAYLAND_APP_ID  // since 3.4; the name of the .desktop file, which has the icon
        glfwWindowHintString(GLFW_WAYLAND_APP_ID, "rekindle");
#endif
        const glm::ivec2 s(glm::clamp(size, 1u, 16384u));
        window_ = glfwCreateWindow(s.x, s.y, title.c_str(), nullptr, nullptr);
        if (window_ == nullptr)
            throw core::Error("no window: " + lastError, core::ExitCode::noDevice);
    } catch (...) {
        endGlfw();
        throw;
    }
    setIcon(window_);
    glfwSetWindowUserPointer(window_, this);
    glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** files) {
        auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(window));
        for (int i = 0; i < count; ++i) self.drops_.emplace_back(files[i]);
    });
    glfwSetWindowRefreshCallback(window_, [](GLFWwindow* window) {
        static_cast<Window*>(glfwGetWindowUserPointer(window))->exposed_ = true;
    });
    glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int modifiers) {
        auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(window));
        if (action != GLFW_REPEAT) self.keys_.told(key, action == GLFW_PRESS, modifiers);
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
    endGlfw();
}

bool Window::displayAvailable(std::string& reason)
{
    if (!startGlfw()) {
        reason = lastError;
        return false;
    }
    endGlfw();
    return true;
}

bool Window::takeExposed()
{
    return std::exchange(exposed_, false);
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

glm::uvec2 Window::size() const
{
    if (lost() || glfwGetWindowAttrib(window_, GLFW_ICONIFIED) == GLFW_TRUE) return glm::uvec2(0);
    int width = 0, height = 0;
    glfwGetWindowSize(window_, &width, &height);
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

void Window::injectKey(const std::string& key, bool down)
{
    std::vector<UiKey> keys;
    std::string rest = key;
    const auto take = [&](const char* name) {
        const std::string prefix = std::string(name) + '+';
        if (!rest.starts_with(prefix)) return false;
        rest = rest.substr(prefix.size());
        keys.push_back(*findKey(name));
        return true;
    };
    bool ctrl = false, shift = false, alt = false;
    for (int i = 0; i < 3; ++i) {  // in any order
        ctrl |= take("Ctrl");
        shift |= take("Shift");
        alt |= take("Alt");
    }
    const std::optional<UiKey> found = findKey(rest);
    if (!found)
        throw core::Error("there is no key \"" + key +
                          "\" — try \"W\", \"Space\", \"Ctrl+S\" or \"F1\"");
    keys.push_back(*found);
    if (!down) std::reverse(keys.begin(), keys.end());
    for (const UiKey k : keys) sendKey(k, down);
    const unsigned typed = typedBy(rest, shift);
    if (down && typed != 0 && !ctrl && !alt) sendCharacter(typed);
}

void Window::injectCursor(glm::dvec2 pixels)
{
    const GLFWcursorenterfun onEnter = installed(&glfwSetCursorEnterCallback, window_);
    if (onEnter != nullptr) onEnter(window_, GLFW_TRUE);
    pointer_.moveTo(pixels);
}

void Window::injectButton(int button, bool down)
{
    pointer_.press(button, down);
}

void Window::injectWheel(double steps)
{
    sendWheel(steps);
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
    if (handCursor_ && glm::distance(*handCursor_, position) > 8) pointer_.forgetCursor();
    if (!handCursor_ || !pointer_.hasCursor()) handCursor_ = position;
}

void Window::applyInjected()
{
    keys_.apply();
    pointer_.apply();
}

}  // namespace app
