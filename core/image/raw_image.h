// What the decoders of picture files give, and the limits that they keep: a size is judged before a
// pixel is allocated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace core {

/// Pixels as the file stores them: 1 to 4 interleaved channels of 8-bit, 16-bit or float values,
/// rows from the top.
struct RawImage {
    enum class Type { unsigned8, unsigned16, float32 };
    uint32_t width = 0, height = 0, channels = 0;
    Type type = Type::unsigned8;
    std::vector<std::byte> pixels;

    size_t rowBytes() const;
};

struct ImageGuards {
    uint32_t maxSize = 16384;               // width and height
    uint64_t maxBytes = uint64_t{1} << 30;  // of pixels
    uint64_t maxRatio = 1000;               // of pixel bytes to file bytes, beyond the first 16 MiB
    /// Called with the size before pixels are allocated; `bytes` counts what the decoder needs
    /// beside them. May throw to refuse.
    std::function<void(uint64_t pixels, uint64_t bytes)> beforeAllocation;
};

/// An image, or the reason why there is none (`problem` is then not empty). `damage`: what was
/// wrong with a file whose image can be shown all the same.
struct DecodedImage {
    RawImage image;
    std::string problem, damage;
};

using EncodedImage = std::span<const std::byte>;

/// What stands against an image of that size; empty when nothing does.
std::string sizeProblem(double width, double height, const ImageGuards& guards);

/// Allocates the pixels of an image whose other fields are set, for a file of `fileBytes`, of which
/// the decoder needs `extraBytes` more. Returns what stands against it; empty when nothing does.
std::string allocatePixels(RawImage& image, uint64_t fileBytes, uint64_t extraBytes,
                           const ImageGuards& guards);

}  // namespace core
