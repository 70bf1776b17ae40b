// Images of scenes, decoded behind guards. OpenImageIO would read what a file's content asks for:
// here the content's first bytes choose one of four readers by name, and the size is checked before
// a pixel is allocated.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace core {

/// Pixels as the file stores them: 1 to 4 interleaved channels of 8-bit, 16-bit or float values,
/// rows from the top.
struct RawImage {
    enum class Type { unsigned8, unsigned16, float32 };
    uint32_t width = 0, height = 0, channels = 0;
    Type type = Type::unsigned8;
    std::vector<std::byte> pixels;
};

struct ImageGuards {
    uint32_t maxSize = 16384;               // width and height
    uint64_t maxBytes = uint64_t{1} << 30;  // of pixels
    uint64_t maxRatio = 1000;               // of pixel bytes to file bytes, beyond the first 16 MiB
    /// Called with the size before pixels are allocated; may throw to refuse.
    std::function<void(uint64_t pixels, uint64_t rawBytes)> beforeAllocation;
};

/// An image, or the reason why there is none (`problem` is then not empty).
struct DecodedImage {
    RawImage image;
    std::string problem;
};

/// Decodes PNG, JPEG, OpenEXR or Radiance bytes. Alpha is not multiplied in.
DecodedImage decodeImage(std::span<const std::byte> bytes, const ImageGuards& guards,
                         std::stop_token stop = {});

/// Half floats for renderers. `color`: integers are decoded from sRGB to linear (alpha never is);
/// floats are linear already. Grey becomes three equal channels, missing alpha one. `repaired`
/// counts values that are not finite, negative or beyond the range of half floats; they become 0, 0
/// and 65504.
Texture makeTexture(const RawImage& image, bool color, uint64_t& repaired);

/// The same as 32-bit floats, linear; values above 1e30 are lowered to it.
std::vector<glm::vec4> makeRadiance(const RawImage& image, uint64_t& repaired);

/// Magenta and grey squares: stands for a base colour that cannot be shown.
Texture checkerTexture();

}  // namespace core
