// The film on the device: sums over the samples of every pixel, as shared/film.h packs them.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "app/gpu/context.h"
#include "app/gpu/frame.h"
#include "core/image/image.h"
#include "shared/film.h"

namespace gpu {

class Film {
public:
    /// read() copies so many at once: enough for a graphics card to have few copies to make.
    static constexpr uint64_t kPixelsRead = 1u << 18;

    explicit Film(Context& context);

    /// An empty film for the frame's image. What it holds is kept for larger images than needed.
    void reset(const Frame& frame);

    /// Shows the film to a kernel that adds to it in its own way; to be done again after a reset.
    void bindTo(DescriptorSet& set) const;

    /// Where accumulate() finds the radiance of a batch: a vec4 per lane. Must outlive its use.
    void setRadiance(const Buffer& radiance);

    /// Records the addition of a batch's samples. The radiance must be visible to it; a barrier
    /// follows.
    void accumulate(VkCommandBuffer commands, const Frame& frame, const shared::Batch& batch);

    /// Calls `store(pixel index, FilmPixel)` for every pixel.
    template <class Store> void read(Store&& store) const
    {
        Words words;  // of a part: those of all would be another film
        for (uint64_t first = 0; first < pixels_; first += kPixelsRead) {
            readWords(first, std::min(kPixelsRead, pixels_ - first), words);
            for (size_t i = 0; i < words.weights.size(); ++i) {
                store(first + i, shared::unpackFilm({words.vectors[0][i], words.vectors[1][i],
                                                     words.vectors[2][i], words.weights[i]}));
            }
        }
    }

    /// The mean of every pixel, RGB, found on the device: a quarter of what read() copies.
    void readMean(core::Image& mean);

private:
    struct Words {
        std::array<std::vector<glm::vec4>, 3> vectors;
        std::vector<glm::vec2> weights;
    };
    void readWords(uint64_t first, uint64_t count, Words& words) const;

    Context& context_;
    Kernel<shared::Batch> accumulate_;
    Kernel<shared::PixelRange> mean_;
    DescriptorSet accumulateSet_, meanSet_;
    std::array<Buffer, 3> words_;
    Buffer weights_, meanBuffer_;
    uint64_t pixels_ = 0;
};

}  // namespace gpu
