// The display kernel: two images of floats in, packed 8-bit colours out, in a buffer that is copied
// to the window's image.
#pragma once

#include "app/gpu/base/pipeline.h"
#include "core/image/display.h"

namespace gpu {

class Display {
public:
    explicit Display(Device& device);

    /// Uploads image 0 (a) or 1 (b), of 1 or 3 channels; null: it is absent. An image that exceeds
    /// the device's storage range is thinned to every second, third, ... pixel. No command that
    /// record() wrote may be running.
    void setImage(int which, const core::Image* image);

    /// Makes room for an output of that size. As setImage: nothing may be running.
    void setSize(uint32_t width, uint32_t height);

    /// Runs the kernel; the sizes of `settings` are filled in. `swapped`: B8G8R8A8 instead of
    /// R8G8B8A8. What follows may copy the output; a copy that an earlier command buffer makes of
    /// it comes first.
    void record(VkCommandBuffer commands, shared::DisplaySettings settings, bool swapped);

    /// Rows from the top, four bytes per pixel, of the order that record() was given.
    const Buffer& output() const { return output_; }
    uint32_t width() const { return width_; }
    uint32_t height() const { return height_; }

private:
    struct Input {
        Buffer buffer;
        core::DisplaySize size{0};
    };

    const Pipeline& pipelineFor(uint32_t choices);

    Device& device_;
    KernelLayout layout_;
    std::map<uint32_t, Pipeline> pipelines_;  // by what they are specialised on
    Bindings bindings_;
    std::array<Input, 2> inputs_;
    Buffer output_;
    uint32_t width_ = 0, height_ = 0;
};

}  // namespace gpu
