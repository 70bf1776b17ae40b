// See icon.h.
#include "app/view/icon.h"

#include <array>
#include <cmath>

#include <glm/glm.hpp>

namespace app {

namespace {

/// A circle and the cone from its highest point down to where it touches; in the SVG's units, y
/// down.
struct Drop {
    float top, centre, radius;
    glm::vec3 colour;
};
constexpr float kMiddle = 32;
constexpr std::array kDrops{Drop{6, 37, 19, {0xb3, 0x42, 0x1c}},
                            Drop{20, 41, 13, {0xf0, 0x87, 0x42}},
                            Drop{33, 45, 7, {0xff, 0xd7, 0x9a}}};

bool inside(const Drop& drop, glm::vec2 p)
{
    if (glm::distance(p, {kMiddle, drop.centre}) <= drop.radius) return true;
    const float height = drop.centre - drop.top, below = p.y - drop.top;
    if (below < 0 || below > height - drop.radius * drop.radius / height) return false;
    const float slope = drop.radius / std::sqrt(height * height - drop.radius * drop.radius);
    return std::abs(p.x - kMiddle) <= below * slope;
}

/// Colour of a point in 0 to 255, and whether the icon covers it.
glm::vec4 colourAt(glm::vec2 p)
{
    if (glm::distance(p, {32, 32}) > 31) return glm::vec4(0);
    glm::vec3 colour(0x16, 0x17, 0x1a);
    for (const Drop& drop : kDrops)
        if (inside(drop, p)) colour = drop.colour;
    return {colour, 1};
}

}  // namespace

std::vector<uint8_t> iconPixels(int side)
{
    constexpr int kSamples = 4;  // per pixel and axis
    std::vector<uint8_t> pixels;
    for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
            glm::vec4 sum(0);
            for (int i = 0; i < kSamples * kSamples; ++i) {
                const glm::vec2 within(i % kSamples, i / kSamples);
                const glm::vec2 at = glm::vec2(x, y) + (within + 0.5f) / float(kSamples);
                sum += colourAt(at * (64.0f / static_cast<float>(side)));
            }
            const glm::vec3 colour = sum.w > 0 ? glm::vec3(sum) / sum.w : glm::vec3(0);
            for (int c = 0; c < 3; ++c)
                pixels.push_back(static_cast<uint8_t>(std::lround(colour[c])));
            pixels.push_back(
                static_cast<uint8_t>(std::lround(sum.w * 255 / (kSamples * kSamples))));
        }
    }
    return pixels;
}

}  // namespace app
