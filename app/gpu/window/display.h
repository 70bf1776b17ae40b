// The display kernel: two images of floats in, packed 8-bit colours out, in a buffer that is copied
// to the window's image. Small pictures are encoded before they are enlarged.
#pragma once

#include "app/gpu/base/kernel.h"
#include "core/image/display.h"

namespace gpu {

/// What the display kernel is specialised on, in the order of its constants: a software device runs
/// every branch that is left in it, for each pixel. The names are those of shared::DisplaySettings.
struct DisplayChoices {
    static constexpr uint32_t kFirst = shared::kSpecializeShow;
    uint32_t show = 0, tone = 0, map = 0, errorKind = 0, logarithmic = 0;
    uint32_t channelsA = 0, channelsB = 0;
    uint32_t swapped = 0;  // 1: red and blue are exchanged
};

/// What the kernel that encodes small pictures is specialised on.
struct EncodeChoices {
    static constexpr uint32_t kFirst = shared::kSpecializeShow;
    uint32_t tone = 0;
};

class Display {
public:
    explicit Display(Device& device);

    /// Uploads image 0 (a) or 1 (b), of 1 or 3 channels; null: it is absent. An image of more
    /// pixels than a texel buffer holds is thinned to every second, third, ... pixel. No command
    /// that record() wrote may be running.
    void setImage(int which, const core::Image* image);

    /// Makes room for an output of that size. As setImage: nothing may be running.
    void setSize(uint32_t width, uint32_t height);

    /// Runs the kernels; the sizes of `settings` are filled in. `swapped`: B8G8R8A8 instead of
    /// R8G8B8A8. What follows may copy the output; a copy that an earlier command buffer makes of
    /// it comes first.
    void record(VkCommandBuffer commands, shared::DisplaySettings settings, bool swapped,
                const core::DisplayPlaces& places = {});

    /// Rows from the top, four bytes per pixel, of the order that record() was given.
    const Buffer& output() const { return output_; }
    uint32_t width() const { return width_; }
    uint32_t height() const { return height_; }

private:
    struct Input {
        Buffer buffer;
        core::DisplaySize size{0};
    };

    void makeRoomForColours();

    Device& device_;
    Kernel<shared::DisplaySettings, DisplayChoices> kernel_;
    Kernel<shared::DisplaySettings, EncodeChoices> encode_;
    DescriptorSet set_, encodeSet_;
    std::array<Input, 2> inputs_;
    Buffer encoded_;  // of a picture that has a guide: its colours
    Buffer output_;
    uint32_t width_ = 0, height_ = 0;
};

}  // namespace gpu
