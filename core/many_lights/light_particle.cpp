// See light_particle.h.
#include "core/many_lights/light_particle.h"

#include <algorithm>
#include <cmath>

namespace core::many_lights {

namespace {

using glm::vec3;

constexpr float kMostSurvival = 0.95f;  // of roulette, so that no path is endless

/// A surface that is met in `direction`, as a light: with its normal bent to nobody.
LightSurface asLight(const shared::SceneView& scene, const shared::Hit& hit,
                     const shared::Vertex& v, const vec3& direction)
{
    const vec3 side = v.surface.backFace != 0 ? -v.surface.normal : v.surface.normal;
    LightSurface surface{{v.surface.frame, side, v.wo, v.bsdf, v.lobes}};
    // A normal that has been bent leaves the path just above its horizon (ensureVisible).
    constexpr float kMostOfBent = 0.02f;
    if (v.wo.z > kMostOfBent) return surface;
    shared::SurfacePoint s = shared::makeSurfacePoint(scene, hit, -side);
    shared::evaluateMaterial(scene, s, -side);
    surface.frame = s.frame;
    surface.incident = shared::toLocal(s.frame, -direction);
    return surface;
}

float angleBetween(const vec3& a, const vec3& b)
{
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

/// A direction between both horizons, uniform in solid angle, and what it weighs: to where paths
/// see the surface with its normal bent (shared::scatteredByLight), and no lobe of it goes.
bool scatterBetween(const Met& met, const shared::VertexNumbers& numbers, vec3& wi, vec3& weight)
{
    const vec3 normal = met.surface.normal;
    const vec3 axis = glm::normalize(glm::cross(normal, met.surface.frame[2]));
    const float along = 2 * numbers.bsdf.x - 1, away = std::sqrt(std::max(0.0f, 1 - along * along));
    const float around = met.angle * numbers.bsdf.y - 0.5f * shared::kPi;
    wi = along * axis +
         away * (std::cos(around) * normal + std::sin(around) * glm::cross(axis, normal));
    const bool transmits = (met.v.bsdf.parts & shared::kBsdfTransmission) != 0;
    if (transmits && numbers.lobe.x < 0.5f) wi = -wi;
    const float directions = 2 * met.angle * (transmits ? 2.0f : 1.0f);
    const float held = shared::heldCosine(met.surface.incident);
    weight = met.surface.scattered(wi) *
             (std::abs(glm::dot(wi, normal)) * directions * held / met.arriving);
    return shared::maxComponent(weight) > 0;
}

/// A direction by the surface's lobes. Refraction keeps flux, but not radiance.
bool scatterByLobes(const shared::Vertex& v, const shared::VertexNumbers& numbers, float correction,
                    vec3& wi, vec3& weight)
{
    shared::BsdfSample next;
    if (!shared::sampleLobes(v.bsdf, v.lobes, v.wo, numbers.lobe.x, numbers.bsdf, next))
        return false;
    wi = shared::toWorld(v.surface.frame, next.wi);
    float side;
    if (!shared::sideOf(v.surface, wi, next.wi.z, side)) return false;
    weight = next.weight * (correction * std::abs(side / next.wi.z));
    if ((next.flags & shared::kLobeTransmission) != 0 && (v.bsdf.parts & shared::kBsdfSolid) != 0)
        weight *= v.bsdf.eta * v.bsdf.eta;
    return true;
}

}  // namespace

bool meet(const shared::SceneView& scene, const shared::Hit& hit, Particle& p, Met& met)
{
    shared::Vertex& v = met.v;
    v.surface = shared::makeSurfacePoint(scene, hit, p.direction);
    const shared::Shading shading = shared::evaluateMaterial(scene, v.surface, p.direction);
    const uint32_t flags = shading.inputs.flags;
    p.flux *= shared::transmittanceTo(scene, v.surface, flags, hit.t, p.medium);
    if ((flags & shared::kMaterialUnlit) != 0) return false;
    v.bsdf = shared::makeBsdf(shading.inputs);
    v.wo = shared::toLocal(v.surface.frame, -p.direction);
    v.lobes = shared::lobesAt(v.bsdf, v.wo);
    met.arriving = std::abs(glm::dot(p.direction, v.surface.normal));
    if (!(met.arriving > 0) || !(v.wo.z > 0)) return false;
    met.correction = v.wo.z / met.arriving;
    met.surface = asLight(scene, hit, v, p.direction);
    met.angle = angleBetween(met.surface.normal, met.surface.frame[2]);
    return true;
}

/// The factor beside the BSDF's weight is that of the adjoint where shading and geometric normals
/// differ (Veach 1997, 5.3.2).
bool scatterFlux(const Met& met, shared::VertexNumbers numbers, Particle& p)
{
    constexpr float kBetween = 0.25f;  // share of particles, per radian between the horizons
    constexpr float kLeast = 0.01f;    // radians, below which it does not matter
    const shared::Vertex& v = met.v;
    const vec3 normal = met.surface.normal;
    const bool goesBetween = met.angle > kLeast && !shared::isDelta(v.bsdf);
    const float share = goesBetween ? kBetween * met.angle : 0.0f;
    vec3 wi, weight;
    if (numbers.lobe.x < share) {
        numbers.lobe.x /= share;
        if (!scatterBetween(met, numbers, wi, weight)) return false;
        weight /= share;
    } else {
        numbers.lobe.x = std::min((numbers.lobe.x - share) / (1 - share), shared::kOneMinusEpsilon);
        if (!scatterByLobes(v, numbers, met.correction, wi, weight)) return false;
        weight /= 1 - share;
    }
    const float survival = std::min(kMostSurvival, shared::maxComponent(weight));
    if (!(numbers.lobe.y < survival)) return false;
    const float side = glm::dot(wi, normal);
    p.flux *= weight / survival;
    p.origin = shared::originOnSide(v.surface, side);
    p.direction = wi;
    p.medium = shared::mediumBeyond(p.medium, v, side);
    return shared::maxComponent(p.flux) > 0;
}

}  // namespace core::many_lights
