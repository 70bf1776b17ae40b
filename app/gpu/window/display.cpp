// The kernels see neither scene nor frame: two images, the colours of a small one, the output, and
// their settings as push constants.
#include "app/gpu/window/display.h"

#include <algorithm>
#include <cstring>

#include <spirv/display.h>
#include <spirv/encode.h>

namespace gpu {

namespace {

static_assert(sizeof(shared::DisplaySettings) <= 128);

/// What a view does not look at stays zero, so that it makes no kernel of its own.
DisplayChoices choicesOf(const shared::DisplaySettings& s, bool swapped)
{
    const bool two = s.show == shared::kShowDifference || s.show == shared::kShowError ||
                     s.show == shared::kShowCompare;
    DisplayChoices c;
    c.show = two && s.widthB == 0 ? shared::kShowRadiance : s.show;
    const bool radiance = c.show == shared::kShowRadiance || c.show == shared::kShowCompare;
    const bool mapped = c.show == shared::kShowScalar || c.show == shared::kShowError ||
                        c.show == shared::kShowDepth;
    if (radiance) c.tone = s.tone;
    if (mapped) c.map = s.map;
    if (c.show == shared::kShowError) c.errorKind = s.errorKind;
    if (mapped && c.show != shared::kShowError && s.logarithmic != 0) c.logarithmic = 1;
    c.channelsA = s.channelsA;
    if (two) c.channelsB = s.channelsB;
    c.swapped = swapped ? 1 : 0;
    return c;
}

/// The smallest step at which every step-th pixel of every step-th row are no more than `limit`.
uint32_t stepToFit(const core::Image& image, uint64_t limit)
{
    for (uint32_t step = 1;; ++step) {
        const uint64_t w = (image.width + step - 1) / step, h = (image.height + step - 1) / step;
        if (w * h <= limit) return step;
    }
}

/// Four floats a pixel, from that pixel on; a single channel is repeated.
void toTexels(const core::Image& image, size_t first, std::span<std::byte> bytes)
{
    const float* from = image.pixels.data() + image.channels * first;
    for (size_t i = 0; i < bytes.size(); i += sizeof(glm::vec4), from += image.channels) {
        const glm::vec4 texel =
            image.channels == 1 ? glm::vec4(*from) : glm::vec4(from[0], from[1], from[2], 0);
        std::memcpy(bytes.data() + i, &texel, sizeof(texel));
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

Display::Display(Device& device)
    : device_(device), kernel_(device, k_display), encode_(device, k_encode),
      set_(device, kernel_.own()), encodeSet_(device, encode_.own())
{}

void Display::setImage(int which, const core::Image* image)
{
    Input& input = inputs_[static_cast<size_t>(which)];
    if (image == nullptr || image->width == 0 || image->height == 0) {
        input.size = core::DisplaySize(0);
        return;
    }
    CHECK(image->channels == 1 || image->channels == 3);
    const uint64_t most = std::min<uint64_t>(device_.limits().maxTexelBufferElements,
                                             device_.info().maxAllocation / sizeof(glm::vec4));
    const uint32_t step = stepToFit(*image, most);
    if (step > 1) {
        const core::Image small = thinned(*image, step);
        setImage(which, &small);
        return;
    }
    const uint64_t bytes = uint64_t(image->width) * image->height * sizeof(glm::vec4);
    if (input.buffer.bytes() < bytes) {
        const uint32_t binding = which == 0 ? shared::kBindImageA : shared::kBindImageB;
        set_.unbind(binding);
        encodeSet_.unbind(binding);
        input = {};  // before the new one: both at once may not fit
        input.buffer = Buffer(device_, "the picture", bytes, VK_FORMAT_R32G32B32A32_SFLOAT);
        set_.bind(binding, input.buffer);
        encodeSet_.bind(binding, input.buffer);
    }
    input.buffer.fill(bytes, [&](std::span<std::byte> part, uint64_t offset) {
        toTexels(*image, offset / sizeof(glm::vec4), part);
    });
    input.size = {image->width, image->height, image->channels};
    makeRoomForColours();
}

/// Once both images of a kShowPreview are there.
void Display::makeRoomForColours()
{
    const core::DisplaySize a = inputs_[0].size, b = inputs_[1].size;
    const uint64_t bytes = uint64_t(a.x) * a.y * sizeof(glm::vec4);
    if (a != core::DisplaySize(b.x, b.y, 3) || b.z != 1 || encoded_.bytes() >= bytes) return;
    set_.unbind(shared::kBindEncoded);
    encodeSet_.unbind(shared::kBindEncoded);
    encoded_ = {};
    encoded_ = Buffer(device_, "the colours", bytes, VK_FORMAT_R32G32B32A32_SFLOAT);
    set_.bind(shared::kBindEncoded, encoded_);
    encodeSet_.bind(shared::kBindEncoded, encoded_);
}

void Display::setSize(uint32_t width, uint32_t height)
{
    const uint64_t bytes = uint64_t(width) * height * 4;
    if (output_.bytes() < bytes) {
        set_.unbind(shared::kBindDisplayed);
        width_ = height_ = 0;
        output_ = {};
        output_ = Buffer(device_, "the window's picture", bytes);
        set_.bind(shared::kBindDisplayed, output_);
    }
    width_ = width;
    height_ = height;
}

void Display::record(VkCommandBuffer commands, shared::DisplaySettings settings, bool swapped,
                     const core::DisplayPlaces& places)
{
    settings =
        core::displaySizes(settings, width_, height_, inputs_[0].size, inputs_[1].size, places);
    const Pipeline& pipeline = kernel_.pipeline(choicesOf(settings, swapped));
    barrier(commands);
    if (settings.show == shared::kShowPreview) {
        const GroupRows groups = groupRows(uint64_t(settings.widthA) * settings.heightA);
        encode_.dispatch(commands, encode_.pipeline({settings.tone}),
                         {nullptr, nullptr, &encodeSet_}, settings, groups.x, groups.y);
        barrier(commands);
    }
    kernel_.dispatch(commands, pipeline, {nullptr, nullptr, &set_}, settings, (width_ + 7) / 8,
                     (height_ + 7) / 8);
    barrier(commands);
}

}  // namespace gpu
