// The window under a real X server without a screen: frames, sizes, what scripts inject, letters of other sizes, the loss of
// the display. Validation and synchronization validation are on and say nothing (V1, V8, V17).
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <random>
#include <thread>

#include <imgui.h>

#include "app/view/gui.h"
#include "core/display.h"
#include "virtual_display.h"

namespace {

using app::DisplayInputs;
using app::Gui;
using app::Window;

#define NEED_DISPLAY() \
    if (!tests::VirtualDisplay::installed()) GTEST_SKIP() << "Xvfb is not installed"

class WindowTest : public testing::Test {
protected:
    void TearDown() override { EXPECT_EQ(gpu_messages(), 0u); }
    static uint64_t gpu_messages();
};

std::shared_ptr<const core::Image> flat(uint32_t width, uint32_t height, glm::vec3 colour)
{
    auto image = std::make_shared<core::Image>(width, height, 3);
    for (size_t i = 0; i < image->pixels.size(); ++i) image->pixels[i] = colour[static_cast<int>(i % 3)];
    return image;
}

/// Shows reflectances, so that a colour can be foretold: sRGB of the value.
DisplayInputs inputsOf(std::shared_ptr<const core::Image> image)
{
    DisplayInputs inputs;
    inputs.a = std::move(image);
    inputs.settings = {};
    inputs.settings.show = shared::kShowColour;
    return inputs;
}


}  // namespace

#include "app/gpu/device.h"
uint64_t WindowTest::gpu_messages()
{
    return gpu::validationMessages();
}

namespace {

TEST_F(WindowTest, ShowsFramesAndReadsThemBack)
{
    NEED_DISPLAY();
    tests::VirtualDisplay display;
    Window window("test", {640, 360});
    Gui gui(window, {.validation = true});
    const DisplayInputs inputs = inputsOf(flat(64, 36, {0.5f, 0.2f, 0.05f}));
    for (int i = 0; i < 30; ++i) {
        window.poll(0);
        ASSERT_TRUE(gui.begin());
        ImGui::GetForegroundDrawList()->AddRectFilled({100, 100}, {200, 200}, IM_COL32(10, 200, 30, 255));
        gui.end(inputs);
    }
    EXPECT_GE(gui.stats().presented, 29u);
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

    std::this_thread::sleep_for(std::chrono::milliseconds(200));  // the server shows what it was given
    EXPECT_EQ(display.pixel(150, 150), (std::array<uint8_t, 3>{10, 200, 30}));
    EXPECT_EQ(display.pixel(20, 20), (std::array<uint8_t, 3>{188, 124, 63}));
}

}  // namespace
