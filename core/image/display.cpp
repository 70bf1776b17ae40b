// Loops of shared/display.h.
#include "core/image/display.h"

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace core {

namespace {

glm::vec3 valueAt(const Image* image, bool second, uint32_t x, uint32_t y,
                  const shared::DisplaySettings& s)
{
    if (image == nullptr) return glm::vec3(0);
    const uint32_t pixel =
        second ? shared::displayIndex(x, y, s.widthB, s.heightB, s.stepBx, s.stepBy)
               : shared::displayIndex(x, y, s.widthA, s.heightA, s.stepAx, s.stepAy);
    const size_t i = size_t(pixel) * image->channels;
    const float* p = &image->pixels[i];
    return image->channels == 1 ? glm::vec3(*p) : glm::vec3(p[0], p[1], p[2]);
}

DisplaySize sizeOf(const Image* image)
{
    if (image == nullptr || image->width == 0 || image->height == 0) return DisplaySize(0);
    CHECK(image->channels == 1 || image->channels == 3);
    return {image->width, image->height, image->channels};
}

float ratio(uint32_t image, uint32_t output)
{
    return static_cast<float>(image) / static_cast<float>(output);
}

}  // namespace

shared::DisplaySettings displaySizes(shared::DisplaySettings s, uint32_t width, uint32_t height,
                                     DisplaySize a, DisplaySize b)
{
    s.width = width;
    s.height = height;
    s.widthA = a.x;
    s.heightA = a.y;
    s.channelsA = a.z;
    s.widthB = b.x;
    s.heightB = b.y;
    s.channelsB = b.z;
    s.stepAx = ratio(a.x, width);
    s.stepAy = ratio(a.y, height);
    s.stepBx = ratio(b.x, width);
    s.stepBy = ratio(b.y, height);
    return s;
}

shared::DisplaySettings displaySizes(shared::DisplaySettings settings, uint32_t width,
                                     uint32_t height, const Image* a, const Image* b)
{
    return displaySizes(settings, width, height, sizeOf(a), sizeOf(b));
}

Image stretched(const Image& image, glm::uvec2 size)
{
    CHECK(image.channels == 3 && image.width > 0 && image.height > 0);
    const shared::DisplaySettings s = displaySizes({}, size.x, size.y, &image, nullptr);
    Image result(size.x, size.y, 3);
    for (uint32_t y = 0; y < size.y; ++y)
        for (uint32_t x = 0; x < size.x; ++x) {
            const glm::vec3 value = valueAt(&image, false, x, y, s);
            for (int c = 0; c < 3; ++c) result.at(x, y)[c] = value[c];
        }
    return result;
}

std::vector<uint8_t> displayImage(const Image* a, const Image* b,
                                  const shared::DisplaySettings& settings)
{
    const shared::DisplaySettings s = displaySizes(settings, settings.width, settings.height, a, b);
    CHECK(s.width > 0 && s.height > 0);
    if (s.widthA == 0) a = nullptr;
    if (s.widthB == 0) b = nullptr;
    std::vector<uint8_t> bytes(size_t(s.width) * s.height * 4);
    parallelFor(s.height, 8, [&](size_t begin, size_t end) {
        for (size_t row = begin; row < end; ++row) {
            const auto y = static_cast<uint32_t>(row);
            for (uint32_t x = 0; x < s.width; ++x) {
                const glm::vec3 colour = shared::displayColour(s, x, valueAt(a, false, x, y, s),
                                                               valueAt(b, true, x, y, s));
                const uint32_t packed = shared::displayPack(colour);
                uint8_t* out = &bytes[(row * s.width + x) * 4];
                for (uint32_t c = 0; c < 4; ++c) out[c] = static_cast<uint8_t>(packed >> (8 * c));
            }
        }
    });
    return bytes;
}

}  // namespace core
