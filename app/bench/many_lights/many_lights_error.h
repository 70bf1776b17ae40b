// How far a picture of clustered lights is from that of all lights: on a display of 8 bits, as the
// thesis measures, and in linear radiance.
#pragma once

#include <array>
#include <span>

#include <glm/glm.hpp>

namespace app::many_lights {

struct LightErrors {
    double rmse8 = 0;   // of displayed(), 0 to 1
    double rmse = 0;    // of radiance
    double relMse = 0;  // mean of (a - b)^2 / (b^2 + .01)
};

/// Radiance as the thesis's comparison sees it: brightened by `exposure` stops, clamped to 0..1,
/// written as 8-bit sRGB, read back as linear, and raised to 1/2.2.
glm::vec3 displayed(const glm::vec3& radiance, double exposure);

/// Over all pixels and channels. Sizes are equal and not 0 (CHECK).
LightErrors errorsOf(std::span<const glm::vec3> picture, std::span<const glm::vec3> reference,
                     double exposure);

/// Share of the values that a display clips.
double clippedShare(std::span<const glm::vec3> picture, double exposure);

}  // namespace app::many_lights
