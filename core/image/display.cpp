// Loops of shared/display.h.
#include "core/image/display.h"

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace core {

namespace {

/// Zero where there is no image, or none at this place: then `pixel` is kBeside.
glm::vec3 valueOf(const Image* image, uint32_t pixel)
{
    if (image == nullptr || pixel == shared::kBeside) return glm::vec3(0);
    const float* p = &image->pixels[size_t(pixel) * image->channels];
    return image->channels == 1 ? glm::vec3(*p) : glm::vec3(p[0], p[1], p[2]);
}

/// Of kShowPreview: the colour of a, smooth between pixels that `alike` says are of one surface.
glm::vec3 smoothed(const Image& a, const shared::DisplaySettings& s, uint32_t x, uint32_t y,
                   uint32_t alike)
{
    glm::uvec4 pixels;
    glm::vec4 weights;
    shared::displayCorners(s, x, y, alike, pixels, weights);
    glm::vec3 sum(0);
    for (int i = 0; i < 4; ++i)
        sum += weights[i] * shared::displayEncoded(s, valueOf(&a, pixels[i]));
    return sum;
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
                                     DisplaySize a, DisplaySize b, const DisplayPlaces& places)
{
    s.width = width;
    s.height = height;
    s.widthA = a.x;
    s.heightA = a.y;
    s.channelsA = a.z;
    s.widthB = b.x;
    s.heightB = b.y;
    s.channelsB = b.z;
    const auto place = [](uint32_t image, uint32_t output, float corner, float share, float& step,
                          float& from) {
        step = ratio(image, output) / share;
        from = -corner / share * static_cast<float>(image);
    };
    place(a.x, width, places.a.x, places.a.z, s.stepAx, s.fromAx);
    place(a.y, height, places.a.y, places.a.w, s.stepAy, s.fromAy);
    place(b.x, width, places.b.x, places.b.z, s.stepBx, s.fromBx);
    place(b.y, height, places.b.y, places.b.w, s.stepBy, s.fromBy);
    if (s.show == shared::kShowPreview && !shared::displayGuided(s)) s.show = shared::kShowRadiance;
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
            const glm::vec3 value = valueOf(&image, shared::displayIndexA(s, x, y));
            for (int c = 0; c < 3; ++c) result.at(x, y)[c] = value[c];
        }
    return result;
}

std::vector<uint8_t> displayImage(const Image* a, const Image* b,
                                  const shared::DisplaySettings& settings,
                                  const DisplayPlaces& places)
{
    const shared::DisplaySettings s =
        displaySizes(settings, settings.width, settings.height, sizeOf(a), sizeOf(b), places);
    CHECK(s.width > 0 && s.height > 0);
    if (s.widthA == 0) a = nullptr;
    if (s.widthB == 0) b = nullptr;
    std::vector<uint8_t> bytes(size_t(s.width) * s.height * 4);
    parallelFor(s.height, 8, [&](size_t begin, size_t end) {
        for (size_t row = begin; row < end; ++row) {
            const auto y = static_cast<uint32_t>(row);
            for (uint32_t x = 0; x < s.width; ++x) {
                const uint32_t pixelA = a != nullptr ? shared::displayIndexA(s, x, y) : 0;
                const uint32_t pixelB = b != nullptr ? shared::displayIndexB(s, x, y) : 0;
                glm::vec3 value = valueOf(a, pixelA);
                if (s.show == shared::kShowPreview && pixelA != shared::kBeside)
                    value = smoothed(*a, s, x, y, static_cast<uint32_t>(valueOf(b, pixelB).x));
                const glm::vec3 colour =
                    shared::displayColour(s, x, value, valueOf(b, pixelB),
                                          pixelA == shared::kBeside, pixelB == shared::kBeside);
                const uint32_t packed = shared::displayPack(colour);
                uint8_t* out = &bytes[(row * s.width + x) * 4];
                for (uint32_t c = 0; c < 4; ++c) out[c] = static_cast<uint8_t>(packed >> (8 * c));
            }
        }
    });
    return bytes;
}

}  // namespace core
