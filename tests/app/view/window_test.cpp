// The window under a real X server without a screen: frames, sizes, what scripts inject, fonts of
// other sizes, the loss of the display. Validation and synchronization validation are on and report
// nothing (V1, V8, V9, V17).
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include <imgui.h>

#include "app/view/gui_style.h"
#include "app/view/icon.h"
#include "core/base/check.h"
#include "core/image/display.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/session/window_fixture.h"

namespace {

using app::DisplayInputs;
using app::findFont;
using app::findKey;
using app::fontFolders;
using app::Gui;
using app::iconPixels;
using app::Window;
using gpu::vk;
using tests::flat;
using tests::inputsOf;
using tests::TemporaryFolder;
using tests::VirtualDisplay;

constexpr ImU32 kGreen = IM_COL32(10, 200, 30, 255);

void rectangle()
{
    ImGui::GetForegroundDrawList()->AddRectFilled({100, 100}, {200, 200}, kGreen);
}

void nothing() {}

class WindowTest : public tests::WindowFixture {};

TEST_F(WindowTest, ShowsFramesAndReadsThemBack)
{
    Window window("test", {640, 360});
    Gui gui(window, {.validation = true});
    const DisplayInputs inputs = inputsOf(flat(64, 36, {0.5f, 0.2f, 0.05f}));
    for (int i = 0; i < 30; ++i) frame(window, gui, inputs, rectangle);
    EXPECT_EQ(gui.stats().presented, 30u);
    glm::uvec2 size;
    const std::vector<uint8_t> bytes = gui.readFrame(size);
    ASSERT_EQ(size, glm::uvec2(640, 360));
    const auto pixel = [&](uint32_t x, uint32_t y) {
        const uint8_t* p = &bytes[(size_t(y) * 640 + x) * 4];
        return std::array<int, 4>{p[0], p[1], p[2], p[3]};
    };
    EXPECT_EQ(pixel(150, 150), (std::array<int, 4>{10, 200, 30, 255}));
    EXPECT_EQ(pixel(20, 20), (std::array<int, 4>{188, 124, 63, 255}));  // sRGB of 0.5, 0.2, 0.05
    EXPECT_EQ(pixel(620, 340), (std::array<int, 4>{188, 124, 63, 255}));

    std::array<uint8_t, 3> seen{};  // the server may take a while
    for (int wait = 0; wait < 100 && seen != std::array<uint8_t, 3>{10, 200, 30}; ++wait) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        seen = display->pixel(150, 150);
    }
    EXPECT_EQ(seen, (std::array<uint8_t, 3>{10, 200, 30}));
    EXPECT_EQ(display->pixel(20, 20), (std::array<uint8_t, 3>{188, 124, 63}));
}

TEST_F(WindowTest, ThePictureHasItsAreaAndNothingIsBesideIt)
{
    Window window("test", {640, 360});
    Gui gui(window, {.validation = true});
    DisplayInputs inputs = inputsOf(flat(64, 36, {0.5f, 0.2f, 0.05f}));
    inputs.corner = {200, 0};
    inputs.size = {440, 330};
    for (int i = 0; i < 3; ++i) frame(window, gui, inputs, nothing);
    glm::uvec2 size;
    std::vector<uint8_t> bytes = gui.readFrame(size);
    ASSERT_EQ(size, glm::uvec2(640, 360));
    const auto red = [&](uint32_t x, uint32_t y) { return int(bytes[(size_t(y) * 640 + x) * 4]); };
    // What the panel and the line of status stand on.
    const auto ground =
        static_cast<int>(std::lround(255 * ImGui::GetStyle().Colors[ImGuiCol_WindowBg].x));
    for (const auto& [x, y] : {std::pair(200u, 0u), {639u, 0u}, {200u, 329u}, {639u, 329u}})
        EXPECT_EQ(red(x, y), 188) << x << ' ' << y;
    for (const auto& [x, y] : {std::pair(199u, 0u), {0u, 359u}, {200u, 330u}, {639u, 330u}})
        EXPECT_EQ(red(x, y), ground) << x << ' ' << y;
    bytes = gui.readPicture(size);
    EXPECT_EQ(size, glm::uvec2(440, 330));
    inputs.corner = {600, 300};  // sticks out, as it may while a window shrinks
    for (int i = 0; i < 2; ++i) frame(window, gui, inputs, nothing);
    bytes = gui.readFrame(size);
    EXPECT_EQ(red(600, 300), 188);
    EXPECT_EQ(red(599, 300), ground);
    EXPECT_EQ(red(600, 299), ground);
    gui.readPicture(size);
    EXPECT_EQ(size, glm::uvec2(40, 60));
}

int dispatches = 0;

TEST_F(WindowTest, RunsTheKernelOnlyWhenInputsChange)
{
    Window window("test", {320, 200});
    Gui gui(window, {.validation = true});
    dispatches = 0;
    vk.CmdDispatch = [](VkCommandBuffer commands, uint32_t x, uint32_t y, uint32_t z) {
        ++dispatches;
        vkCmdDispatch(commands, x, y, z);
    };
    DisplayInputs inputs = inputsOf(flat(32, 20, {0.1f, 0.2f, 0.3f}));
    for (int i = 0; i < 5; ++i) frame(window, gui, inputs, nothing);
    EXPECT_EQ(dispatches, 1);
    inputs.settings.show = shared::kShowRadiance;
    for (int i = 0; i < 3; ++i) frame(window, gui, inputs, nothing);
    EXPECT_EQ(dispatches, 2);
    inputs.b = flat(32, 20, {0.9f, 0.2f, 0.3f});
    for (int i = 0; i < 3; ++i) frame(window, gui, inputs, nothing);
    EXPECT_EQ(dispatches, 3);
    window.resize({300, 210});
    for (int i = 0; i < 5; ++i) frame(window, gui, inputs, nothing);
    EXPECT_EQ(dispatches, 4);

    inputs.settings.show = shared::kShowCompare;
    inputs.settings.slider = 0.25f;
    for (int i = 0; i < 2; ++i) frame(window, gui, inputs, nothing);
    EXPECT_EQ(dispatches, 5);
    glm::uvec2 size;
    const std::vector<uint8_t> shown = gui.readPicture(size);
    ASSERT_EQ(size, glm::uvec2(300, 210));
    inputs.settings.width = size.x;
    inputs.settings.height = size.y;
    EXPECT_EQ(shown, core::displayImage(inputs.a.get(), inputs.b.get(), inputs.settings));
}

// --- V8: a storm of sizes leaves nothing behind

struct Living {
    int swapchains = 0, views = 0, framebuffers = 0, semaphores = 0, memory = 0;
    int most = 0;  // swapchains at one time
} living;

void countObjects()
{
    living = {};
    vk.CreateSwapchainKHR = [](auto device, auto info, auto allocator, auto object) {
        living.most = std::max(living.most, ++living.swapchains);
        return vkCreateSwapchainKHR(device, info, allocator, object);
    };
    vk.DestroySwapchainKHR = [](auto device, auto object, auto allocator) {
        --living.swapchains;
        vkDestroySwapchainKHR(device, object, allocator);
    };
#define COUNT(create, destroy, member)                                                             \
    vk.create = [](auto device, auto info, auto allocator, auto object) {                          \
        ++living.member;                                                                           \
        return vk##create(device, info, allocator, object);                                        \
    };                                                                                             \
    vk.destroy = [](auto device, auto object, auto allocator) {                                    \
        --living.member;                                                                           \
        vk##destroy(device, object, allocator);                                                    \
    }
    COUNT(CreateImageView, DestroyImageView, views);
    COUNT(CreateFramebuffer, DestroyFramebuffer, framebuffers);
    COUNT(CreateSemaphore, DestroySemaphore, semaphores);
    COUNT(AllocateMemory, FreeMemory, memory);
#undef COUNT
}

TEST_F(WindowTest, SurvivesAStormOfSizes)
{
    countObjects();
    {
        Window window("test", {320, 200});
        Gui gui(window, {.validation = true});
        const DisplayInputs inputs = inputsOf(flat(64, 36, {0.5f, 0.2f, 0.05f}));
        std::mt19937 random(7);
        for (int i = 0; i < 50; ++i) {
            glm::uvec2 wanted(1 + random() % 1400, 1 + random() % 900);
            if (i == 10) wanted = {1, 1};
            if (i == 20) wanted = {0, 0};  // becomes 1x1: X11 would end the process
            window.resize(wanted);
            wanted = glm::max(wanted, 1u);
            for (int turn = 0; turn < 20; ++turn) {
                frame(window, gui, inputs, rectangle);
                if (window.framebufferSize() == wanted) break;
            }
            const uint64_t before = gui.stats().presented;
            frame(window, gui, inputs, rectangle);
            EXPECT_EQ(gui.stats().presented, before + 1) << wanted.x << "x" << wanted.y;
            EXPECT_EQ(window.framebufferSize(), wanted);
        }
        glm::uvec2 size;
        const std::vector<uint8_t> bytes = gui.readFrame(size);
        EXPECT_EQ(bytes.size(), size_t(size.x) * size.y * 4);
        EXPECT_EQ(size, window.framebufferSize());
        EXPECT_GE(gui.stats().swapchains, 50u);
        EXPECT_LE(living.most, 4);
        EXPECT_LE(gui.stats().deviceBytes,
                  1400u * 900 * 4 + (1u << 20));  // one output of the largest size
    }
    EXPECT_EQ(living.swapchains, 0);
    EXPECT_EQ(living.views, 0);
    EXPECT_EQ(living.framebuffers, 0);
    EXPECT_EQ(living.semaphores, 0);
    EXPECT_EQ(living.memory, 0);
}

// --- scripts

TEST_F(WindowTest, InjectedInputArrives)
{
    Window window("test", {400, 300});
    Gui gui(window, {.validation = true});
    const DisplayInputs inputs = inputsOf(flat(4, 3, {0, 0, 0}));
    ImGuiIO& io = ImGui::GetIO();
    for (int i = 0; i < 3; ++i) frame(window, gui, inputs, nothing);

    window.injectCursor({120, 80});
    window.injectButton(0, true);
    for (int i = 0; i < 3; ++i) {
        frame(window, gui, inputs, [&] {
            EXPECT_EQ(io.MousePos.x, 120);
            EXPECT_EQ(io.MousePos.y, 80);
            EXPECT_TRUE(ImGui::IsMouseDown(0)) << i;
            EXPECT_EQ(ImGui::IsMouseClicked(0), i == 0);
        });
    }
    window.injectCursor({130, 90});
    window.injectWheel(-2);
    // Since ImGui 1.87 what comes within one frame is spread over several.
    constexpr int kFrames = IMGUI_VERSION_NUM >= 18700 ? 3 : 1;
    float moved = 0, turned = 0;
    for (int i = 0; i < kFrames; ++i)
        frame(window, gui, inputs, [&] {
            moved += io.MouseDelta.x;
            turned += io.MouseWheel;
        });
    EXPECT_EQ(moved, 10);
    EXPECT_EQ(turned, -2);
    window.injectButton(0, false);
    frame(window, gui, inputs, [&] {
        EXPECT_TRUE(ImGui::IsMouseReleased(0));
        EXPECT_EQ(io.MouseWheel, 0);
    });
    window.injectButton(1, true);  // down and up between two frames is a click nevertheless
    window.injectButton(1, false);
    frame(window, gui, inputs, [&] { EXPECT_TRUE(ImGui::IsMouseClicked(1)); });

    window.injectKey("Ctrl+S", true);
    int pressed = 0;
    for (int i = 0; i < kFrames; ++i)
        frame(window, gui, inputs, [&] {
            EXPECT_TRUE(io.InputQueueCharacters.empty());
            if (!ImGui::IsKeyPressed(*findKey("S"), false)) return;
            ++pressed;
            EXPECT_TRUE(io.KeyCtrl);
        });
    EXPECT_EQ(pressed, 1);
    window.injectKey("Ctrl+S", false);
    window.injectKey("Shift+E", true);
    window.injectKey("Shift+E", false);
    window.injectKey("7", true);
    std::string typed;
    for (int i = 0; i < 8; ++i) {
        frame(window, gui, inputs, [&] {
            for (const ImWchar c : io.InputQueueCharacters) typed += static_cast<char>(c);
        });
    }
    EXPECT_EQ(typed, "E7");
    EXPECT_FALSE(io.KeyCtrl || io.KeyShift);
    EXPECT_TRUE(ImGui::IsKeyDown(*findKey("7")));
    EXPECT_THROW(window.injectKey("Hyper+Q", true), core::Error);
    EXPECT_THROW(window.injectButton(9, true), core::Error);

    window.injectDrop("/some/scene.glb");
    EXPECT_EQ(window.takeDrops(), std::vector<std::filesystem::path>{"/some/scene.glb"});
    EXPECT_TRUE(window.takeDrops().empty());
    window.setClipboard("a camera");
    EXPECT_EQ(window.clipboard(), "a camera");
}

TEST_F(WindowTest, AButtonIsPressedByInjectedInput)
{
    Window window("test", {400, 300});
    Gui gui(window, {.validation = true});
    const DisplayInputs inputs = inputsOf(flat(4, 3, {0, 0, 0}));
    int pressed = 0;
    const auto panel = [&] {
        ImGui::SetNextWindowPos({20, 20});
        ImGui::SetNextWindowSize({200, 100});
        ImGui::Begin("panel");
        if (ImGui::Button("press", {150, 40})) ++pressed;
        ImGui::End();
    };
    const ImVec2 button{60, 75};
    window.injectCursor({button.x, button.y});
    for (int i = 0; i < 3; ++i) frame(window, gui, inputs, panel);
    EXPECT_TRUE(ImGui::GetIO().WantCaptureMouse);
    window.injectButton(0, true);
    for (int i = 0; i < 2; ++i) frame(window, gui, inputs, panel);
    EXPECT_EQ(pressed, 0);
    window.injectButton(0, false);
    for (int i = 0; i < 2; ++i) frame(window, gui, inputs, panel);
    EXPECT_EQ(pressed, 1);
}

// --- letters

TEST_F(WindowTest, LettersFollowTheScaleFromTheOriginalStyle)
{
    Window window("test", {400, 300});
    Gui gui(window, {.validation = true});
    const DisplayInputs inputs = inputsOf(flat(4, 3, {0, 0, 0}));
    EXPECT_EQ(window.contentScale(), 1.0f);
    frame(window, gui, inputs, nothing);
    const float letters = ImGui::GetFontSize();
    const ImVec2 padding = ImGui::GetStyle().WindowPadding;
    for (const float scale : {2.0f, 1.5f, 3.0f, 1.0f}) {
        gui.setUiScale(scale);
        frame(window, gui, inputs, [&] {
            ImGui::GetForegroundDrawList()->AddText({10, 10}, kGreen, "text: λ² ≤ 1");
        });
        EXPECT_NEAR(ImGui::GetFontSize(), letters * scale, 0.5f);
        EXPECT_NEAR(ImGui::GetStyle().WindowPadding.x, padding.x * scale, 1.0f);
    }
    EXPECT_EQ(ImGui::GetStyle().WindowPadding.x, padding.x);
    gui.setUiScale(0);
    frame(window, gui, inputs, nothing);
    EXPECT_EQ(ImGui::GetFontSize(), letters);
}

TEST(Fonts, AreFoundWhereSystemsKeepThem)
{
    const TemporaryFolder data;
    for (const char* kind : {"truetype/dejavu", "dejavu-sans-fonts", "TTF"}) {
        const std::filesystem::path folder = data.path() / "fonts" / kind;
        std::filesystem::create_directories(folder);
        const std::filesystem::path file = folder / (std::string("a.ttf"));
        std::ofstream(file) << "letters";
        setenv("XDG_DATA_DIRS", ("/nonexistent:" + data.path().string()).c_str(), 1);
        const std::filesystem::path found = findFont("a.ttf", fontFolders());
        unsetenv("XDG_DATA_DIRS");
        EXPECT_EQ(found, file);
        EXPECT_TRUE(findFont("b.ttf", fontFolders()).empty());
        std::filesystem::remove(file);
    }
}

TEST(Icon, IsADiscWithAFlame)
{
    for (const int side : {16, 48}) {
        const std::vector<uint8_t> pixels = iconPixels(side);
        ASSERT_EQ(pixels.size(), static_cast<size_t>(4 * side * side));
        const auto at = [&](double x, double y) {
            return &pixels[4 * (static_cast<size_t>(y * side) * static_cast<size_t>(side) +
                                static_cast<size_t>(x * side))];
        };
        EXPECT_EQ(at(0.0, 0.0)[3], 0) << "corners are transparent";
        EXPECT_EQ(at(0.5, 0.72)[3], 255);
        EXPECT_GT(at(0.5, 0.72)[0], 240) << "bright in its heart";
        EXPECT_LT(at(0.1, 0.5)[0], 60) << "dark around it";
    }
}

double channel(float encoded)
{
    return encoded <= 0.04045f ? double(encoded) / 12.92
                               : std::pow((double(encoded) + 0.055) / 1.055, 2.4);
}

/// Contrast as WCAG 2 defines it.
double contrast(ImVec4 a, ImVec4 b)
{
    const auto luminance = [](ImVec4 c) {
        return 0.2126 * channel(c.x) + 0.7152 * channel(c.y) + 0.0722 * channel(c.z);
    };
    const double x = luminance(a) + 0.05, y = luminance(b) + 0.05;
    return std::max(x, y) / std::min(x, y);
}

TEST_F(WindowTest, TextStandsOutFromEveryBackground)
{
    Window window("test", {400, 300});
    Gui gui(window, {.validation = true});
    const ImVec4* c = ImGui::GetStyle().Colors;
    for (const int background :
         {ImGuiCol_WindowBg, ImGuiCol_PopupBg, ImGuiCol_FrameBg, ImGuiCol_TitleBgActive,
          ImGuiCol_FrameBgHovered, ImGuiCol_Button, ImGuiCol_Header, ImGuiCol_TableHeaderBg}) {
        EXPECT_GE(contrast(c[ImGuiCol_Text], c[background]), 7)
            << ImGui::GetStyleColorName(background);
    }
    EXPECT_GE(contrast(c[ImGuiCol_TextDisabled], c[ImGuiCol_WindowBg]), 4.5);
    EXPECT_GE(contrast(c[ImGuiCol_TextDisabled], c[ImGuiCol_PopupBg]), 4.5);
    EXPECT_GE(contrast(c[ImGuiCol_CheckMark], c[ImGuiCol_FrameBg]), 4.5);
}

/// A translucent colour over an opaque one.
ImVec4 over(ImVec4 front, ImVec4 ground)
{
    const auto mix = [&](float f, float g) { return g + front.w * (f - g); };
    return {mix(front.x, ground.x), mix(front.y, ground.y), mix(front.z, ground.z), 1};
}

TEST_F(WindowTest, NumbersStandOutFromTheGrabThatLiesOnThem)
{
    Window window("test", {400, 300});
    Gui gui(window, {.validation = true});
    const ImVec4* c = ImGui::GetStyle().Colors;
    EXPECT_GE(contrast(c[ImGuiCol_Text], over(c[ImGuiCol_SliderGrab], c[ImGuiCol_FrameBg])), 7);
    EXPECT_GE(
        contrast(c[ImGuiCol_Text], over(c[ImGuiCol_SliderGrabActive], c[ImGuiCol_FrameBgActive])),
        4);
}

// --- what may be missing

TEST_F(WindowTest, WithoutADisplayTheReasonIsTold)
{
    std::string reason;
    EXPECT_TRUE(Window::displayAvailable(reason));
    setenv("DISPLAY", ":4711", 1);  // no server; the fixture's display restores the variable
    unsetenv("WAYLAND_DISPLAY");
    EXPECT_FALSE(Window::displayAvailable(reason));
    EXPECT_NE(reason.find("X11"), std::string::npos) << reason;
    try {
        Window window("test", {100, 100});
        FAIL();
    } catch (const core::Error& error) {
        EXPECT_EQ(error.code(), core::ExitCode::noDevice);
        EXPECT_NE(std::string(error.what()).find("render"), std::string::npos);
    }
}

/// V17: the server dies under the window: the loop goes on, says so, and ends; nothing waits for
/// ever.
/// As the program does: what is left of a window without its display is not taken down, for that
/// crashes inside libX11 1.8.10.
TEST_F(WindowTest, TheLossOfTheDisplayEndsNothingButTheWindow)
{
    testing::GTEST_FLAG(death_test_style) = "threadsafe";
    const auto lose = [&] {
        Window window("test", {320, 200});
        Gui gui(window, {.validation = true});
        const DisplayInputs inputs = inputsOf(flat(4, 3, {0.5f, 0.5f, 0.5f}));
        for (int i = 0; i < 5; ++i) frame(window, gui, inputs, rectangle);
        display->kill();
        bool failed = false;
        for (int i = 0; i < 50 && !window.lost() && !failed; ++i) {
            try {
                frame(window, gui, inputs, rectangle);
            } catch (const core::Error&) {
                failed = true;  // the surface went first, and no other can be created
            }
            window.poll(0.01);
        }
        EXPECT_TRUE(window.lost());
        EXPECT_TRUE(window.closeRequested());
        EXPECT_EQ(window.framebufferSize(), glm::uvec2(0));
        EXPECT_FALSE(gui.begin());
        window.resize({100, 100});
        window.setTitle("gone");
        EXPECT_EQ(window.clipboard(), "");
        std::_Exit(HasFailure() ? 7 : 0);
    };
    const auto begun = std::chrono::steady_clock::now();
    EXPECT_EXIT(lose(), testing::ExitedWithCode(0), "");
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(30));
}

}  // namespace
