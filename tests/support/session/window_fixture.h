// A window on a virtual display, and a table of Vulkan functions that is put back afterwards.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "app/gpu/base/device.h"
#include "app/view/gui.h"
#include "tests/support/session/virtual_display.h"

namespace tests {

/// Restores gpu::vk when it goes.
class VulkanTable {
public:
    VulkanTable() = default;
    ~VulkanTable() { gpu::vk = original; }
    VulkanTable(const VulkanTable&) = delete;
    VulkanTable& operator=(const VulkanTable&) = delete;
    const gpu::Api original = gpu::vk;
};

/// An image of one colour.
inline std::shared_ptr<const core::Image> flat(uint32_t width, uint32_t height, glm::vec3 colour)
{
    auto image = std::make_shared<core::Image>(width, height, 3);
    for (size_t i = 0; i < image->pixels.size(); ++i)
        image->pixels[i] = colour[static_cast<int>(i % 3)];
    return image;
}

/// Shown as reflectances, so that a colour can be predicted: the sRGB encoding of the value.
inline app::DisplayInputs inputsOf(std::shared_ptr<const core::Image> image)
{
    app::DisplayInputs inputs;
    inputs.a = std::move(image);
    inputs.settings = {};
    inputs.settings.show = shared::kShowColour;
    return inputs;
}

/// Each test has one display, skips without Xvfb, and fails when the validation layer reported
/// anything.
class WindowFixture : public testing::Test {
protected:
    void SetUp() override
    {
        messages_ = gpu::validationMessages();
        if (!VirtualDisplay::installed()) GTEST_SKIP() << "Xvfb is not installed";
        display = std::make_unique<VirtualDisplay>();
    }
    void TearDown() override { EXPECT_EQ(newMessages(), 0u); }

    uint64_t newMessages() const { return gpu::validationMessages() - messages_; }

    /// One turn of a window's loop; `draw` gives ImGui something.
    template <class F>
    static void frame(app::Window& window, app::Gui& gui, const app::DisplayInputs& inputs,
                      F&& draw)
    {
        window.poll(0);
        if (!gui.begin()) return;
        draw();
        gui.end(inputs);
    }

    VulkanTable table;  // put back after everything that used it
    std::unique_ptr<VirtualDisplay> display;

private:
    uint64_t messages_ = 0;
};

}  // namespace tests
