// Puts a frame on the window: the picture through the display kernel, Dear ImGui over it, the
// swapchain under it. Owns the window's own Vulkan device: whatever happens to the renderer's, this
// one goes on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "app/view/window.h"
#include "core/image/display.h"
#include "core/image/image.h"

namespace app {

struct GuiOptions {
    int deviceIndex = -1;
    bool validation = false;
    float uiScale = 0;                    // 0: the display's
    std::filesystem::path cacheFolder{};  // of gpu::DeviceOptions
};

/// The two images that the display kernel reads; each is uploaded only when its pointer changes.
struct DisplayInputs {
    std::shared_ptr<const core::Image> a, b;  // 1 or 3 channels; b may be absent
    shared::DisplaySettings settings;         // sizes are filled in
    core::DisplayPlaces places;               // of the images in the picture's area
    glm::uvec2 corner{0}, size{0};  // of that area in the window, pixels; no size: all of it
};

/// What a frame would change of what stands in the window.
struct GuiChanges {
    bool picture = false;  // its place and the window's size included
    bool panels = false;   // anything that ImGui draws
};

struct GuiStats {
    // Frames shown, not shown, swapchains made
    uint64_t presented = 0, skipped = 0, swapchains = 0;
    uint64_t deviceBytes = 0;
};

class Gui {
public:
    /// Throws core::Error (noDevice) when no device can show frames in this window.
    Gui(Window& window, const GuiOptions& options);
    ~Gui();

    /// Starts a frame of ImGui; false when there is nothing to draw on (minimised): then skip the
    /// frame.
    bool begin();

    /// Ends ImGui's frame and compares it with the one that was presented last. Where there is
    /// nothing to change, end() need not follow.
    GuiChanges changes(const DisplayInputs& inputs);

    /// Draws the picture into its area, then what ImGui has been given since begin(), and presents.
    /// Runs the display kernel only when its inputs changed.
    void end(const DisplayInputs& inputs);

    /// The frame that was presented last, RGBA rows from the top.
    std::vector<uint8_t> readFrame(glm::uvec2& size);
    /// What the display kernel made last: the picture's area, without what ImGui drew.
    std::vector<uint8_t> readPicture(glm::uvec2& size);

    void setUiScale(float scale);
    GuiStats stats() const;
    std::string deviceName() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace app
