// Loops of shared/display.h.
#include "core/display.h"

#include "core/check.h"
#include "core/parallel.h"

namespace core {

namespace {

glm::vec3 valueAt(const Image* image, uint32_t x, uint32_t y, const shared::DisplaySettings& s)
{
    if (image == nullptr) return glm::vec3(0);
    const size_t i =
        size_t(shared::displayIndex(x, y, s.width, s.height, image->width, image->height)) * image->channels;
    const float* p = &image->pixels[i];
    return image->channels == 1 ? glm::vec3(*p) : glm::vec3(p[0], p[1], p[2]);
}

bool empty(const Image* image)
{
    return image == nullptr || image->width == 0 || image->height == 0;
}

}  // namespace

shared::DisplaySettings displaySizes(shared::DisplaySettings s, uint32_t width, uint32_t height, const Image* a,
                                     const Image* b)
{
    s.width = width;
    s.height = height;
    s.widthA = empty(a) ? 0 : a->width;
    s.heightA = empty(a) ? 0 : a->height;
    s.channelsA = empty(a) ? 0 : a->channels;
    s.widthB = empty(b) ? 0 : b->width;
    s.heightB = empty(b) ? 0 : b->height;
    s.channelsB = empty(b) ? 0 : b->channels;
    return s;
}

std::vector<uint8_t> displayImage(const Image* a, const Image* b, const shared::DisplaySettings& settings)
{
    const shared::DisplaySettings s = displaySizes(settings, settings.width, settings.height, a, b);
    CHECK(s.width > 0 && s.height > 0);
    if (s.widthA == 0) a = nullptr;
    if (s.widthB == 0) b = nullptr;
    CHECK(a == nullptr || a->channels == 1 || a->channels == 3);
    CHECK(b == nullptr || b->channels == 1 || b->channels == 3);
    std::vector<uint8_t> bytes(size_t(s.width) * s.height * 4);
    parallelFor(s.height, 8, [&](size_t begin, size_t end) {
        for (size_t row = begin; row < end; ++row) {
            const auto y = static_cast<uint32_t>(row);
            for (uint32_t x = 0; x < s.width; ++x) {
                const glm::vec3 colour = shared::displayColour(s, x, valueAt(a, x, y, s), valueAt(b, x, y, s));
                const uint32_t packed = shared::displayPack(colour);
                uint8_t* out = &bytes[(row * s.width + x) * 4];
                for (uint32_t c = 0; c < 4; ++c) out[c] = static_cast<uint8_t>(packed >> (8 * c));
            }
        }
    });
    return bytes;
}

}  // namespace core
