// Four buffers, and the kernels that add to them and divide them.
#include "app/gpu/film.h"

#include <algorithm>

#include "spirv/accumulate.h"
#include "spirv/mean.h"

namespace gpu {

Film::Film(Context& context)
    : context_(context), accumulate_(context.device, k_accumulate, &context.layouts),
      mean_(context.device, k_mean, &context.layouts),
      accumulateSet_(context.device, accumulate_.own()), meanSet_(context.device, mean_.own())
{
    accumulate_
        .pipeline();  // here, and not while commands are recorded, where failing leaves a mess
    mean_.pipeline();
}

void Film::reset(const Frame& frame)
{
    const uint64_t pixels = uint64_t(frame.width()) * frame.height();
    pixels_ = 0;
    // Larger than needed is good enough: while the camera moves, sizes change all the time. The
    // last buffer tells whether all could be had; the others, whose pixels fill whole units of
    // allocation, whether they are large enough.
    if (weights_.bytes() < std::max<uint64_t>(pixels * sizeof(glm::vec2), 16) ||
        words_[2].bytes() < pixels * sizeof(glm::vec4)) {
        weights_ = {};
        words_ = {};
        const auto make = [&](Buffer& buffer, uint32_t binding, uint64_t bytesPerPixel) {
            buffer = Buffer(context_.device, "the film", pixels * bytesPerPixel);
            for (DescriptorSet* set : {&accumulateSet_, &meanSet_}) set->bind(binding, buffer);
        };
        for (uint32_t i = 0; i < 3; ++i) make(words_[i], shared::kBindFilm0 + i, sizeof(glm::vec4));
        make(weights_, shared::kBindFilmWeight, sizeof(glm::vec2));
    }
    context_.device.submit(
        [&](VkCommandBuffer commands) {
            const auto clear = [&](const Buffer& buffer, uint64_t bytesPerPixel) {
                vk.CmdFillBuffer(commands, buffer.get(), 0, pixels * bytesPerPixel, 0);
            };
            for (const Buffer& buffer : words_) clear(buffer, sizeof(glm::vec4));
            clear(weights_, sizeof(glm::vec2));
            barrier(commands);
        },
        "the clearing of the film");
    pixels_ = pixels;
}

void Film::bindTo(DescriptorSet& set) const
{
    for (uint32_t i = 0; i < 3; ++i) set.bind(shared::kBindFilm0 + i, words_[i]);
    set.bind(shared::kBindFilmWeight, weights_);
}

void Film::setRadiance(const Buffer& radiance)
{
    accumulateSet_.bind(shared::kBindRadiance, radiance);
}

void Film::accumulate(VkCommandBuffer commands, const Frame& frame, const shared::Batch& batch)
{
    accumulate_.dispatch(commands, accumulate_.pipeline(), {nullptr, &frame.set(), &accumulateSet_},
                         batch, batch.tileCount);
    barrier(commands);
}

void Film::readWords(uint64_t first, uint64_t count, Words& words) const
{
    const auto read = [&](const Buffer& buffer, auto& values) {
        values.resize(count);
        buffer.read(std::as_writable_bytes(std::span(values)), first * sizeof(values[0]));
    };
    for (size_t i = 0; i < 3; ++i) read(words_[i], words.vectors[i]);
    read(weights_, words.weights);
}

void Film::readMean(core::Image& mean)
{
    constexpr uint32_t kMostGroups = 1u << 15;  // of one dispatch; every device takes twice that
    CHECK(mean.pixels.size() == 3 * pixels_);
    if (meanBuffer_.bytes() < pixels_ * sizeof(glm::vec3)) {
        meanSet_.unbind(shared::kBindMean);
        meanBuffer_ = {};
        meanBuffer_ = Buffer(context_.device, "the mean", pixels_ * sizeof(glm::vec3));
        meanSet_.bind(shared::kBindMean, meanBuffer_);
    }
    context_.device.submit(
        [&](VkCommandBuffer commands) {
            constexpr uint64_t kMost = uint64_t(kMostGroups) * shared::kGroupSize;
            for (uint64_t first = 0; first < pixels_; first += kMost) {
                const shared::PixelRange range{
                    static_cast<uint32_t>(first),
                    static_cast<uint32_t>(std::min(kMost, pixels_ - first))};
                mean_.dispatch(commands, mean_.pipeline(), {nullptr, nullptr, &meanSet_}, range,
                               groupsFor(range.pixelCount));
            }
            barrier(commands);
        },
        "the mean");
    meanBuffer_.read(std::as_writable_bytes(std::span(mean.pixels)));
}

}  // namespace gpu
