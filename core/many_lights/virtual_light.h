// Virtual lights: points from which the light of a scene is thought to come once light paths have
// been traced from its emitters (Keller, "Instant Radiosity", 1997). A surface keeps its whole BSDF
// for the directions in which it shines.
#pragma once

#include <cstdint>
#include <vector>

#include "shared/surface.h"

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

/// A surface that scatters other than Lambert's, with the direction from which its light arrives.
struct LightSurface {
    glm::mat3 frame;
    glm::vec3 normal;    // geometric, on the side where light arrives
    glm::vec3 incident;  // unit, in the frame: to where the light came from
    shared::Bsdf bsdf;
    shared::LobeChoice lobes;

    /// BSDF (no cosine) for flux that arrives and leaves to `out` (unit, world). Flux does not have
    /// radiance's factor of the squared index (Veach 1997, 5.2).
    glm::vec3 scattered(const glm::vec3& out) const
    {
        const glm::vec3 local = shared::toLocal(frame, out);
        if (!(glm::dot(out, normal) * local.z > 0)) return glm::vec3(0);
        glm::vec3 f;
        float pdf;
        shared::evalPdfLobes(bsdf, lobes, incident, local, f, pdf);
        const bool refracted = local.z < 0 && (bsdf.parts & shared::kBsdfSolid) != 0;
        return refracted ? f * (bsdf.eta * bsdf.eta) : f;
    }
};

/// Fall-off of a spot light (KHR_lights_punctual): the square of a ramp in the cosine to its axis.
struct SpotFalloff {
    float scale = 0, offset = 1;

    float at(float cosine) const
    {
        const float ramp = glm::clamp(cosine * scale + offset, 0.0f, 1.0f);
        return ramp * ramp;
    }
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
