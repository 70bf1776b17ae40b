// Virtual lights: points from which the light of a scene is thought to come once light paths have
// been traced from its emitters (Keller, "Instant Radiosity", 1997). A surface keeps its whole BSDF
// for the directions in which it shines.
#pragma once

#include <cstdint>
#include <vector>

#include "core/many_lights/light_shape.h"
#include "shared/extended_light.h"

namespace core::many_lights {

enum class LightKind : uint32_t { surface, point, directional };
inline constexpr uint32_t kLightKinds = 3;

/// One virtual light. Radiant intensity towards a unit direction w that leaves it:
///   surface      intensity * max(0, normal . w), |normal . w| where `bothSides`; times the BSDF of
///                `detail` where there is one
///   point        intensity, times the fall-off of `detail` where there is one
///   directional  none: `intensity` is irradiance at normal incidence, `normal` where it travels to
struct VirtualLight {
    glm::vec3 position{0};
    LightKind kind = LightKind::surface;
    glm::vec3 normal{0};   // geometric, unit
    uint32_t bounces = 0;  // scattering events that its light has behind it when it leaves
    glm::vec3 intensity{0};
    uint32_t detail = shared::kNone;  // kNone: Lambertian, or shining alike to all sides
    float importance = 0;  // luminance of what it sends out, as intensity of a Lambertian light;
                           // by this representatives are drawn. Positive
    uint32_t bothSides = 0;
};

/// A surface that sends out other than Lambert's.
struct LightSurface : shared::LightSurface {
    /// shared::scatteredByLight.
    glm::vec3 scattered(const glm::vec3& out) const { return shared::scatteredByLight(*this, out); }
};

/// Of a spot light.
struct SpotFalloff {
    float scale = 0, offset = 1;

    float at(float cosine) const { return shared::spotFalloff(scale, offset, cosine); }
};

/// The lights of one frame; `detail` counts in `surfaces` or `spots`.
struct LightSet {
    std::vector<VirtualLight> lights;
    std::vector<LightSurface> surfaces;
    std::vector<SpotFalloff> spots;
    uint64_t paths = 0;    // traced from emitters, those without a light included
    uint64_t rays = 0;     // of these paths
    uint64_t dropped = 0;  // lights that were not numbers
};

}  // namespace core::many_lights
