// What a display system may answer at any time, injected through the table of Vulkan functions at
// acquisition and at presentation while ImGui draws (V4, V5, V9, V10, V16). Validation and
// synchronization validation say nothing.
#include <array>
#include <functional>
#include <set>

#include <imgui.h>

#include "app/gpu/window/swapchain.h"
#include "core/base/check.h"
#include "tests/support/session/window_fixture.h"
#include "tests/support/vulkan/leak_on_purpose.h"

namespace {

using app::Gui;
using app::Window;
using gpu::vk;

/// What the replaced functions do: at the `at`-th call, `times` times, give `result` without the
/// driver.
struct Injection {
    VkResult result = VK_SUCCESS;
    int at = 0, times = 1, calls = 0;
    bool afterReal = false;  // the driver does its work nevertheless

    bool strikes()
    {
        const int call = calls++;
        return call >= at && call < at + times;
    }
};
Injection acquire, present;
int destroyedSurfaces = 0;  // destroyed

class SwapchainTest : public tests::WindowFixture {
protected:
    void SetUp() override
    {
        WindowFixture::SetUp();
        acquire = present = {};
        destroyedSurfaces = 0;
        vk.AcquireNextImageKHR = [](auto device, auto chain, auto timeout, auto semaphore,
                                    auto fence, auto index) {
            if (acquire.result == VK_SUCCESS || !acquire.strikes()) {
                return vkAcquireNextImageKHR(device, chain, timeout, semaphore, fence, index);
            }
            if (acquire.result > 0 && acquire.result != VK_TIMEOUT &&
                acquire.result != VK_NOT_READY) {
                const VkResult real =
                    vkAcquireNextImageKHR(device, chain, timeout, semaphore, fence, index);
                return real == VK_SUCCESS ? acquire.result : real;
            }
            return acquire.result;
        };
        vk.QueuePresentKHR = [](auto queue, auto info) {
            if (present.result == VK_SUCCESS || !present.strikes())
                return vkQueuePresentKHR(queue, info);
            if (present.afterReal) vkQueuePresentKHR(queue, info);
            return present.result;
        };
        vk.DestroySurfaceKHR = [](auto instance, auto surface, auto allocator) {
            ++destroyedSurfaces;
            vkDestroySurfaceKHR(instance, surface, allocator);
        };
    }

    static void frames(Window& window, Gui& gui, int count)
    {
        static const app::DisplayInputs inputs =
            tests::inputsOf(tests::flat(16, 9, {0.5f, 0.2f, 0.05f}));
        for (int i = 0; i < count; ++i) {
            frame(window, gui, inputs, [] {
                ImGui::GetForegroundDrawList()->AddRectFilled({10, 10}, {60, 60},
                                                              IM_COL32(10, 200, 30, 255));
                ImGui::GetForegroundDrawList()->AddText({70, 10}, IM_COL32_WHITE, "text");
            });
        }
    }

    /// The frame is right, and so is what follows.
    static void expectPicture(Gui& gui)
    {
        glm::uvec2 size;
        const std::vector<uint8_t> bytes = gui.readFrame(size);
        ASSERT_GT(size.x, 30u);
        const size_t inside = (size_t(30) * size.x + 30) * 4,
                     outside = (size_t(size.y - 5) * size.x + 30) * 4;
        EXPECT_EQ(bytes[inside], 10);
        EXPECT_EQ(bytes[inside + 1], 200);
        EXPECT_EQ(bytes[outside], 188);
        EXPECT_EQ(bytes[outside + 1], 124);
    }
};

TEST_F(SwapchainTest, ResultsAreValues)
{
    using gpu::Outcome;
    gpu::Device device({.validation = true});
    EXPECT_EQ(gpu::outcomeOf(device, VK_SUCCESS, ""), Outcome::ok);
    EXPECT_EQ(gpu::outcomeOf(device, VK_TIMEOUT, ""), Outcome::notReady);
    EXPECT_EQ(gpu::outcomeOf(device, VK_NOT_READY, ""), Outcome::notReady);
    EXPECT_EQ(gpu::outcomeOf(device, VK_SUBOPTIMAL_KHR, ""), Outcome::suboptimal);
    EXPECT_EQ(gpu::outcomeOf(device, VK_ERROR_OUT_OF_DATE_KHR, ""), Outcome::outOfDate);
    EXPECT_EQ(gpu::outcomeOf(device, VK_ERROR_FULL_SCREEN_EXCLUSIVE_MODE_LOST_EXT, ""),
              Outcome::outOfDate);
    EXPECT_EQ(gpu::outcomeOf(device, VK_ERROR_SURFACE_LOST_KHR, ""), Outcome::surfaceLost);
    EXPECT_THROW(gpu::outcomeOf(device, VK_ERROR_OUT_OF_DEVICE_MEMORY, ""), core::Error);
}

/// What one result at one place asks for, counted over ten frames of which one meets it.
struct ResultCase {
    const char* name;
    bool atPresent, afterReal;
    VkResult result;
    uint64_t shown, made;  // frames, and swapchains beyond the first
    int surfaces;          // destroyed while the window lives
};

TEST_F(SwapchainTest, EveryAnswerIsLived)
{
    const std::array<ResultCase, 12> cases{{
        {"acquire out of date", false, false, VK_ERROR_OUT_OF_DATE_KHR, 10, 1, 0},
        {"acquire suboptimal", false, false, VK_SUBOPTIMAL_KHR, 10, 1, 0},
        {"acquire exclusive lost", false, false, VK_ERROR_FULL_SCREEN_EXCLUSIVE_MODE_LOST_EXT, 10,
         1, 0},
        {"acquire surface lost", false, false, VK_ERROR_SURFACE_LOST_KHR, 10, 1, 1},
        {"acquire timeout", false, false, VK_TIMEOUT, 9, 0, 0},
        {"acquire not ready", false, false, VK_NOT_READY, 9, 0, 0},
        {"present out of date", true, false, VK_ERROR_OUT_OF_DATE_KHR, 9, 1, 0},
        {"present out of date, done", true, true, VK_ERROR_OUT_OF_DATE_KHR, 9, 1, 0},
        {"present suboptimal", true, true, VK_SUBOPTIMAL_KHR, 10, 1, 0},
        {"present exclusive lost", true, true, VK_ERROR_FULL_SCREEN_EXCLUSIVE_MODE_LOST_EXT, 9, 1,
         0},
        {"present surface lost", true, false, VK_ERROR_SURFACE_LOST_KHR, 9, 1, 1},
        {"present surface lost, done", true, true, VK_ERROR_SURFACE_LOST_KHR, 9, 1, 1},
    }};
    for (const ResultCase& c : cases) {
        SCOPED_TRACE(c.name);
        {
            Window window("test", {200, 120});
            Gui gui(window, {.validation = true});
            acquire = present = {};
            (c.atPresent ? present
                         : acquire) = {.result = c.result, .at = 3, .afterReal = c.afterReal};
            destroyedSurfaces = 0;
            frames(window, gui, 10);
            EXPECT_EQ(gui.stats().presented, c.shown);
            EXPECT_EQ(gui.stats().presented + gui.stats().skipped, 10u);
            EXPECT_EQ(gui.stats().swapchains, 1 + c.made);
            EXPECT_EQ(destroyedSurfaces, c.surfaces);
            expectPicture(gui);
        }
        EXPECT_EQ(newMessages(), 0u);
    }
}

/// Every frame out of date, for ever: nothing is shown, nothing piles up, and it recovers.
TEST_F(SwapchainTest, EndlessRefusalsDoNotPileUp)
{
    static int alive, most;
    alive = most = 0;
    vk.CreateSwapchainKHR = [](auto device, auto info, auto allocator, auto object) {
        most = std::max(most, ++alive);
        return vkCreateSwapchainKHR(device, info, allocator, object);
    };
    vk.DestroySwapchainKHR = [](auto device, auto object, auto allocator) {
        --alive;
        vkDestroySwapchainKHR(device, object, allocator);
    };
    Window window("test", {200, 120});
    Gui gui(window, {.validation = true});
    acquire = {.result = VK_ERROR_OUT_OF_DATE_KHR, .at = 3, .times = 60};
    frames(window, gui, 33);  // 3 that work, 30 that try twice each
    EXPECT_EQ(gui.stats().presented, 3u);
    EXPECT_LE(most, 5);
    frames(window, gui, 5);
    EXPECT_EQ(gui.stats().presented, 8u);
    expectPicture(gui);
    EXPECT_LE(alive, 3);
}

TEST_F(SwapchainTest, ASurfaceThatIsLostAgainAndAgainEndsTheWindow)
{
    Window window("test", {200, 120});
    Gui gui(window, {.validation = true});
    acquire = {.result = VK_ERROR_SURFACE_LOST_KHR, .at = 2, .times = 5};
    frames(window, gui, 12);  // five times in a row is tolerated
    EXPECT_EQ(destroyedSurfaces, 5);
    expectPicture(gui);
    present = {.result = VK_ERROR_SURFACE_LOST_KHR, .at = 0, .times = 1000};
    EXPECT_THROW(frames(window, gui, 50), core::Error);
    EXPECT_EQ(destroyedSurfaces, 10);
}

TEST_F(SwapchainTest, LossOfTheDeviceIsAnErrorAndTheEndIsClean)
{
    for (const bool atPresent : {false, true}) {
        Window window("test", {200, 120});
        Gui gui(window, {.validation = true});
        acquire = present = {};
        (atPresent ? present
                   : acquire) = {.result = VK_ERROR_DEVICE_LOST, .at = 4, .afterReal = true};
        try {
            frames(window, gui, 10);
            FAIL();
        } catch (const core::Error& error) {
            EXPECT_EQ(error.code(), core::ExitCode::deviceLost);
        }
        EXPECT_EQ(gui.stats().presented, 4u);
    }
}

/// A frame that would change nothing need not be drawn; one that did not come to the window does.
TEST_F(SwapchainTest, TellsWhatAFrameWouldChange)
{
    Window window("test", {200, 120});
    Gui gui(window, {.validation = true});
    app::DisplayInputs inputs = tests::inputsOf(tests::flat(16, 9, {0.5f, 0.2f, 0.05f}));
    const auto turn = [&](const char* text, bool show) {
        window.poll(0);
        EXPECT_TRUE(gui.begin());
        ImGui::GetForegroundDrawList()->AddText({70, 10}, IM_COL32_WHITE, text);
        const app::GuiChanges changes = gui.changes(inputs);
        if (show) gui.end(inputs);
        return std::pair(changes.picture, changes.panels);
    };
    const std::pair all(true, true), nothing(false, false), panels(false, true),
        picture(true, false);
    EXPECT_EQ(turn("a", true), all);
    EXPECT_EQ(turn("a", false), nothing);
    EXPECT_EQ(turn("a", true), nothing);
    EXPECT_EQ(turn("b", false), panels);
    EXPECT_EQ(turn("a", false), nothing);
    EXPECT_EQ(turn("b", true), panels);
    EXPECT_EQ(turn("b", false), nothing);
    inputs.a = tests::flat(16, 9, {0.5f, 0.2f, 0.05f});
    EXPECT_EQ(turn("b", false), picture);
    EXPECT_EQ(turn("b", true), picture);
    inputs.settings.exposure = 1;
    EXPECT_EQ(turn("b", true), picture);
    inputs.corner = {10, 10};
    inputs.size = {100, 60};
    EXPECT_EQ(turn("b", true), picture);
    EXPECT_EQ(turn("b", false), nothing);
    acquire = {.result = VK_TIMEOUT, .at = 0};
    EXPECT_EQ(turn("c", true), panels);
    EXPECT_EQ(turn("c", true), all) << "the frame before was not shown";
    EXPECT_EQ(turn("c", false), nothing);
}

/// V9: no area, no swapchain, no frame; then it goes on.
TEST_F(SwapchainTest, NoAreaNoFrame)
{
    static bool minimised;
    minimised = false;
    vk.GetPhysicalDeviceSurfaceCapabilitiesKHR = [](auto physical, auto surface, auto can) {
        const VkResult result = vkGetPhysicalDeviceSurfaceCapabilitiesKHR(physical, surface, can);
        if (minimised) can->currentExtent = {0, 0};
        return result;
    };
    Window window("test", {200, 120});
    Gui gui(window, {.validation = true});
    frames(window, gui, 3);
    minimised = true;
    acquire = {.result = VK_ERROR_OUT_OF_DATE_KHR, .at = 0};
    frames(window, gui, 4);
    EXPECT_EQ(gui.stats().presented, 3u);
    EXPECT_EQ(gui.stats().skipped, 4u);
    EXPECT_EQ(gui.stats().swapchains, 1u);
    minimised = false;
    frames(window, gui, 3);
    EXPECT_EQ(gui.stats().presented, 6u);
    EXPECT_EQ(gui.stats().swapchains, 2u);
    expectPicture(gui);
}

/// Displays that leave the size to the program (Wayland) get that of the window's framebuffer.
TEST_F(SwapchainTest, TheWindowDecidesWhereTheSurfaceDoesNot)
{
    vk.GetPhysicalDeviceSurfaceCapabilitiesKHR = [](auto physical, auto surface, auto can) {
        const VkResult result = vkGetPhysicalDeviceSurfaceCapabilitiesKHR(physical, surface, can);
        can->currentExtent = {0xffffffffu, 0xffffffffu};
        return result;
    };
    Window window("test", {230, 120});
    Gui gui(window, {.validation = true});
    frames(window, gui, 3);
    glm::uvec2 size;
    gui.readFrame(size);
    EXPECT_EQ(size, glm::uvec2(230, 120));
}

/// V16: the message says what there is to do without a window.
TEST_F(SwapchainTest, ADeviceThatCannotPresentIsRefusedWithAdvice)
{
    const auto expectAdvice = [](const char* what) {
        Window window("test", {200, 120});
        try {
            Gui gui(window, {.validation = true});
            ADD_FAILURE() << what;
        } catch (const core::Error& error) {
            EXPECT_EQ(error.code(), core::ExitCode::noDevice) << what;
            EXPECT_NE(std::string(error.what()).find("rekindle render"), std::string::npos)
                << error.what();
        }
    };
    vk.GetPhysicalDeviceSurfaceSupportKHR = [](auto, auto, auto, auto presents) {
        *presents = VK_FALSE;
        return VK_SUCCESS;
    };
    expectAdvice("no queue");
    vk.GetPhysicalDeviceSurfaceSupportKHR = table.original.GetPhysicalDeviceSurfaceSupportKHR;

    vk.EnumerateDeviceExtensionProperties = [](auto, auto, auto count, auto) {
        *count = 0;
        return VK_SUCCESS;
    };
    expectAdvice("no extension");
    vk.EnumerateDeviceExtensionProperties = table.original.EnumerateDeviceExtensionProperties;

    vk.GetPhysicalDeviceSurfaceFormatsKHR = [](auto, auto, auto count, auto formats) {
        *count = 1;
        if (formats != nullptr)
            *formats = {VK_FORMAT_R16G16B16A16_SFLOAT, VK_COLOR_SPACE_SRGB_NONLINEAR_KHR};
        return VK_SUCCESS;
    };
    expectAdvice("no format");
    EXPECT_EQ(destroyedSurfaces, 3);  // none is left
}

/// V16: of several families the one is taken that presents, whatever its index.
TEST_F(SwapchainTest, TheFamilyThatPresentsIsTaken)
{
    vk.GetPhysicalDeviceQueueFamilyProperties = [](auto physical, auto count, auto families) {
        if (families == nullptr) {
            vkGetPhysicalDeviceQueueFamilyProperties(physical, count, nullptr);
            ++*count;
            return;
        }
        uint32_t real = *count - 1;
        families[*count - 1] = {VK_QUEUE_COMPUTE_BIT,
                                1,
                                64,
                                {1, 1, 1}};  // computes only: never asked whether it presents
        vkGetPhysicalDeviceQueueFamilyProperties(physical, &real, families);
        std::swap(families[0], families[*count - 1]);
    };
    static std::set<uint32_t> asked;
    asked.clear();
    vk.GetPhysicalDeviceSurfaceSupportKHR = [](auto, uint32_t family, auto, auto presents) {
        asked.insert(family);
        *presents = family == 1 ? VK_TRUE : VK_FALSE;
        return VK_SUCCESS;
    };
    static uint32_t taken;
    taken = 99;
    vk.CreateDevice = [](auto, auto info, auto, auto) {
        taken = info->pQueueCreateInfos[0].queueFamilyIndex;
        return VK_ERROR_INITIALIZATION_FAILED;  // the real device has no such family
    };
    Window window("test", {200, 120});
    EXPECT_THROW(Gui(window, {.validation = true}), core::Error);
    EXPECT_EQ(taken, 1u);
    EXPECT_EQ(asked, std::set<uint32_t>{1u});
}

/// V4: a fence that never comes ends in a lost device, not in a wait without end.
TEST_F(SwapchainTest, AFenceThatNeverComesIsGivenUp)
{
    Window window("test", {200, 120});
    static int waits;
    waits = 0;
    {
        const tests::LeakOnPurpose leak;
        Gui gui(window, {.validation = false});  // what is left behind on purpose would be reported
        frames(window, gui, 3);
        vk.WaitForFences = [](auto, auto, auto, auto, uint64_t timeout) {
            ++waits;
            EXPECT_LE(timeout, 2'000'000'000u);
            return VK_TIMEOUT;
        };
        try {
            frames(window, gui, 3);
            FAIL();
        } catch (const core::Error& error) {
            EXPECT_EQ(error.code(), core::ExitCode::deviceLost);
        }
        EXPECT_LE(waits, 300);
    }
    EXPECT_LE(waits, 330);
}

/// A headless device needs nothing of a window (V11).
TEST_F(SwapchainTest, WithoutASurfaceNothingOfAWindowIsAskedFor)
{
    static int asked;
    static uint32_t instanceExtensions, deviceExtensions;
    asked = 0;
    instanceExtensions = deviceExtensions = 99;
    vk.GetPhysicalDeviceSurfaceSupportKHR = [](auto physical, auto family, auto surface,
                                               auto presents) {
        ++asked;
        return vkGetPhysicalDeviceSurfaceSupportKHR(physical, family, surface, presents);
    };
    vk.CreateInstance = [](auto info, auto allocator, auto instance) {
        instanceExtensions = info->enabledExtensionCount;
        return vkCreateInstance(info, allocator, instance);
    };
    vk.CreateDevice = [](auto physical, auto info, auto allocator, auto device) {
        deviceExtensions = info->enabledExtensionCount;
        return vkCreateDevice(physical, info, allocator, device);
    };
    const gpu::Device device({});
    EXPECT_EQ(asked, 0);
    EXPECT_EQ(instanceExtensions, 0u);
    EXPECT_EQ(deviceExtensions, 0u);
}

}  // namespace
