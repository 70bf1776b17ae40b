// Pictures of what sample reuse does at each pixel, the same on every device.
#pragma once

#include <vector>

#include "core/image/image.h"
#include "core/methods/method.h"
#include "shared/reuse_sums.h"

namespace core {

/// Maps in the order of reuseMaps(), of a picture of that size made by a shared::kReuse strategy;
/// `pixel(i)` and `map(i)` give what a pass has left.
template <class Pixel, class Map>
std::vector<Image> makeReuseMaps(glm::uvec2 size, uint32_t strategy, Pixel&& pixel, Map&& map)
{
    std::vector<Image> images(reuseMaps().size(), Image(size.x, size.y, 1));
    for (size_t i = 0; i < images[0].pixels.size(); ++i) {
        const float nominal = shared::unpackHistory(pixel(i).history).nominal;
        shared::ReuseMapPixel m = map(i);
        if (shared::keepsMeans(strategy)) m.effective = nominal;
        const float values[] = {nominal,      m.old,       m.c,
                                1.0f - m.old, m.effective, static_cast<float>(m.taken)};
        for (size_t k = 0; k < images.size(); ++k) images[k].pixels[i] = values[k];
    }
    return images;
}

}  // namespace core
