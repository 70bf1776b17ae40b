// The kernel borrows the layout of the path tracer's; three of its storage buffers and the push constants are enough.
#include "app/gpu/display.h"

#include <spirv/display.h>

namespace gpu {

namespace {

struct Push {
    shared::DisplaySettings settings;
    uint32_t swapped;
};
static_assert(sizeof(Push) == sizeof(shared::DisplaySettings) + 4 && sizeof(Push) <= 128);

/// The smallest step at which every step-th pixel of every step-th row fits.
uint32_t stepToFit(const core::Image& image, uint64_t limit)
{
    for (uint32_t step = 1;; ++step) {
        const uint64_t w = (image.width + step - 1) / step, h = (image.height + step - 1) / step;
        if (w * h * image.channels * sizeof(float) <= limit) return step;
    }
}

core::Image thinned(const core::Image& image, uint32_t step)
{
    core::Image small((image.width + step - 1) / step, (image.height + step - 1) / step, image.channels);
    for (uint32_t y = 0; y < small.height; ++y) {
        for (uint32_t x = 0; x < small.width; ++x) {
            const float* from = image.at(x * step, y * step);
            std::copy(from, from + image.channels, small.at(x, y));
        }
    }
    return small;
}

}  // namespace

Display::Display(Device& device)
    : device_(device), layout_(device), pipeline_(device, layout_, k_display, {}), bindings_(device, layout_)
{
}

void Display::setImage(int which, const core::Image* image)
{
    Input& input = inputs_[static_cast<size_t>(which)];
    if (image == nullptr || image->width == 0 || image->height == 0) {
        input.width = input.height = input.channels = 0;
        return;
    }
    CHECK(image->channels == 1 || image->channels == 3);
    const uint32_t step = stepToFit(*image, device_.limits().maxStorageBufferRange - 16);
    if (step > 1) {
        const core::Image small = thinned(*image, step);
        setImage(which, &small);
        return;
    }
    const auto bytes = std::as_bytes(std::span(image->pixels));
    if (input.buffer.bytes() < bytes.size()) {
        const uint32_t binding = which == 0 ? shared::kBindStates : shared::kBindRadiance;
        bindings_.unbind(binding);
        input = {};  // before the new one: both at once may not fit
        input.buffer = Buffer(device_, "the picture", bytes.size());
        bindings_.bind(binding, input.buffer);
    }
    input.buffer.write(bytes);
    input.width = image->width;
    input.height = image->height;
    input.channels = image->channels;
}

void Display::setSize(uint32_t width, uint32_t height)
{
    const uint64_t bytes = uint64_t(width) * height * 4;
    if (output_.bytes() < bytes) {
        bindings_.unbind(shared::kBindOutput);
        width_ = height_ = 0;
        output_ = {};
        output_ = Buffer(device_, "the window's picture", bytes);
        bindings_.bind(shared::kBindOutput, output_);
    }
    width_ = width;
    height_ = height;
}

void Display::record(VkCommandBuffer commands, shared::DisplaySettings settings, bool swapped)
{
    settings.width = width_;
    settings.height = height_;
    settings.widthA = inputs_[0].width;
    settings.heightA = inputs_[0].height;
    settings.channelsA = inputs_[0].channels;
    settings.widthB = inputs_[1].width;
    settings.heightB = inputs_[1].height;
    settings.channelsB = inputs_[1].channels;
    const Push push{settings, swapped ? 1u : 0u};
    barrier(commands);
    vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    bindings_.use(commands, layout_);
    vk.CmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(push), &push);
    vk.CmdDispatch(commands, (width_ + 7) / 8, (height_ + 7) / 8, 1);
    barrier(commands);
}

}  // namespace gpu
