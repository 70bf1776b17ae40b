// The kernel borrows the layout of the path tracer's; three of its storage buffers and the push
// constants are enough. It is specialised on what is shown: a software device runs every branch
// that is left in it, for each pixel.
#include "app/gpu/window/display.h"

#include <spirv/display.h>

namespace gpu {

namespace {

static_assert(sizeof(shared::DisplaySettings) <= 128);

/// The word that display.comp takes apart. What a view does not look at stays zero, so that it
/// makes no kernel of its own.
uint32_t choicesOf(const shared::DisplaySettings& s, bool swapped)
{
    const bool two = s.show == shared::kShowDifference || s.show == shared::kShowError ||
                     s.show == shared::kShowCompare;
    const uint32_t show = two && s.widthB == 0 ? shared::kShowRadiance : s.show;
    const bool radiance = show == shared::kShowRadiance || show == shared::kShowCompare;
    const bool mapped = show == shared::kShowScalar || show == shared::kShowError;
    uint32_t word = show;
    if (radiance) word |= s.tone << 4;
    if (mapped) word |= s.map << 8;
    if (show == shared::kShowError) word |= s.errorKind << 12;
    if (show == shared::kShowScalar && s.logarithmic != 0) word |= 1u << 16;
    word |= s.channelsA << 17;
    if (two) word |= s.channelsB << 19;
    return swapped ? word | 1u << 21 : word;
}

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
    core::Image small((image.width + step - 1) / step, (image.height + step - 1) / step,
                      image.channels);
    for (uint32_t y = 0; y < small.height; ++y) {
        for (uint32_t x = 0; x < small.width; ++x) {
            const float* from = image.at(x * step, y * step);
            std::copy(from, from + image.channels, small.at(x, y));
        }
    }
    return small;
}

}  // namespace

Display::Display(Device& device) : device_(device), layout_(device), bindings_(device, layout_) {}

void Display::setImage(int which, const core::Image* image)
{
    Input& input = inputs_[static_cast<size_t>(which)];
    if (image == nullptr || image->width == 0 || image->height == 0) {
        input.size = core::DisplaySize(0);
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
    input.size = {image->width, image->height, image->channels};
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

const Pipeline& Display::pipelineFor(uint32_t choices)
{
    Pipeline& pipeline = pipelines_[choices];
    if (pipeline.get() == VK_NULL_HANDLE)
        pipeline = Pipeline(device_, layout_, k_display, {.features = choices});
    return pipeline;
}

void Display::record(VkCommandBuffer commands, shared::DisplaySettings settings, bool swapped)
{
    settings = core::displaySizes(settings, width_, height_, inputs_[0].size, inputs_[1].size);
    const Pipeline& pipeline = pipelineFor(choicesOf(settings, swapped));
    barrier(commands);
    vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
    bindings_.use(commands, layout_);
    vk.CmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(settings),
                        &settings);
    vk.CmdDispatch(commands, (width_ + 7) / 8, (height_ + 7) / 8, 1);
    barrier(commands);
}

}  // namespace gpu
