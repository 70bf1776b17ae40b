// What counts as one surface in the pixels of coarse pictures, whose light may be averaged or taken
// from one to the next, and what of their radiance is light.
#pragma once

#include <glm/glm.hpp>

#include "core/methods/renderer.h"

namespace app {

inline constexpr float kSameTurn = 0.9f;  // cosine between normals, at least
// A line between two points of a plane or a sphere is normal to the sum of their normals; of one
// surface may be what leaves it by less than 11 degrees: the square of that, against the sum.
inline constexpr float kSameBend = 0.16f;
inline constexpr float kLeastAlbedo = 0.05f;  // light on what is darker cannot be told

/// What radiance is divided by for the light on the surface in a pixel, row by row from the top.
inline glm::vec3 albedoAt(const core::Aovs& aovs, size_t pixel)
{
    const float* a = &aovs.albedo.pixels[3 * pixel];
    return glm::max(glm::vec3(a[0], a[1], a[2]), glm::vec3(kLeastAlbedo));
}

/// Whether radiance comes from what is seen in the pixel itself.
inline bool emits(const core::Aovs& aovs, size_t pixel)
{
    if (aovs.emission.pixels.empty()) return false;
    const float* e = &aovs.emission.pixels[3 * pixel];
    return e[0] + e[1] + e[2] > 0;
}

}  // namespace app
