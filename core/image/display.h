// The display transform of shared/display.h over whole images on the CPU: what the window shows,
// for files and tests.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image/image.h"
#include "shared/display.h"

namespace core {

/// Width, height and channels (1 or 3) of an image; all 0: it is absent.
using DisplaySize = glm::uvec3;

/// Where the images stand in the output: corner and size, in fractions of it.
struct DisplayPlaces {
    glm::vec4 a{0, 0, 1, 1}, b{0, 0, 1, 1};

    friend bool operator==(const DisplayPlaces&, const DisplayPlaces&) = default;
};

/// `settings` with the sizes of an output and of the images filled in, and what follows from them.
shared::DisplaySettings displaySizes(shared::DisplaySettings settings, uint32_t width,
                                     uint32_t height, DisplaySize a, DisplaySize b,
                                     const DisplayPlaces& places = {});

/// The same for images, of which either may be absent.
shared::DisplaySettings displaySizes(shared::DisplaySettings settings, uint32_t width,
                                     uint32_t height, const Image* a, const Image* b);

/// An image of three channels stretched over an output of that size, as the window shows it.
Image stretched(const Image& image, glm::uvec2 size);

/// RGBA rows from the top, `settings.width` x `settings.height` (both at least 1; the images' sizes
/// are filled in).
std::vector<uint8_t> displayImage(const Image* a, const Image* b,
                                  const shared::DisplaySettings& settings,
                                  const DisplayPlaces& places = {});

}  // namespace core
