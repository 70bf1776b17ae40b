// See raw_image.h.
#include "core/image/raw_image.h"

#include <cstdio>

namespace core {

/// Whatever a header claims: it may be beyond all integers.
static std::string sizeText(double width, double height)
{
    char text[64];
    std::snprintf(text, sizeof text, "%.15g x %.15g", width, height);
    return text;
}

size_t RawImage::rowBytes() const
{
    const size_t size = type == Type::unsigned8 ? 1 : type == Type::unsigned16 ? 2 : 4;
    return size_t{width} * channels * size;
}

std::string sizeProblem(double width, double height, const ImageGuards& guards)
{
    if (!(width >= 1) || !(height >= 1)) return "has no pixels (" + sizeText(width, height) + ")";
    if (width > guards.maxSize || height > guards.maxSize)
        return "has " + sizeText(width, height) + " pixels, allowed are " +
               std::to_string(guards.maxSize) + " each way";
    return {};
}

std::string allocatePixels(RawImage& image, uint64_t fileBytes, uint64_t extraBytes,
                           const ImageGuards& guards)
{
    const uint64_t bytes = uint64_t{image.rowBytes()} * image.height;
    if (bytes > guards.maxBytes || bytes > guards.maxRatio * fileBytes + (16u << 20))
        return "would need " + std::to_string(bytes >> 20) + " MiB for " +
               sizeText(image.width, image.height) + " pixels, which is too much for a file of " +
               std::to_string(fileBytes) + " bytes";
    if (guards.beforeAllocation)
        guards.beforeAllocation(uint64_t{image.width} * image.height, bytes + extraBytes);
    image.pixels.resize(bytes);
    return {};
}

}  // namespace core
