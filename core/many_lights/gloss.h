// A surface of a diffuse part under one facet lobe that reflects, as most materials are, seen from
// one direction: shared::evalLobes for it (shaders/shared/bsdf.h) without densities and without a
// branch, so that loops over directions or surfaces become vectors.
#pragma once

#include <algorithm>
#include <cmath>

#include "shared/bsdf.h"

namespace core::many_lights {

/// What evalGloss reads. Floats alone, one after the other: loops keep them as arrays.
struct Gloss {
    float woX, woY, woZ;
    float alpha, smith;                     // GGX width; smithRoot at wo
    float excess, r0, shareScale;           // of Fresnel's formula: eta^2 - 1, as in Bsdf
    float strength0, strength90;            // as in Bsdf
    float diffuseR, diffuseG, diffuseB;     // all of the diffuse part that does not depend on wi
    float normalR, normalG, normalB;        // reflection at normal incidence
    float grazingR, grazingG, grazingB;     // what grazing incidence adds: dielectric part
    float metallicR, metallicG, metallicB;  // and metallic part
};
inline constexpr size_t kGlossNumbers = 22;
static_assert(sizeof(Gloss) == kGlossNumbers * sizeof(float));

// By value: references, as std::min takes them, leave branches behind.
inline float lesser(float a, float b)
{
    return a < b ? a : b;
}
inline float greater(float a, float b)
{
    return a > b ? a : b;
}

/// Whether a surface seen along `wo` (local) is one.
inline bool isGloss(const shared::Bsdf& b, const glm::vec3& wo)
{
    return (b.parts & ~shared::kBsdfDiffuse) == shared::kBsdfMicrofacet && b.alpha > 0 &&
           b.eta >= 1 && wo.z > shared::kMinCosine;
}

/// `lobes` are those at `wo`.
inline Gloss glossOf(const shared::Bsdf& b, const shared::LobeChoice& lobes, const glm::vec3& wo)
{
    const bool shines = (b.parts & shared::kBsdfDiffuse) != 0;
    const glm::vec3 diffuse =
        shines ? b.diffuse * (lobes.through * b.diffuseNorm * shared::kInvPi) : glm::vec3(0);
    const glm::vec3 normal = b.f0 + b.metal, grazing = b.f90 - b.f0,
                    metallic = b.metalShare - b.metal;
    return {wo.x,
            wo.y,
            wo.z,
            b.alpha,
            shared::smithRoot(wo.z, b.alpha * b.alpha),
            b.eta * b.eta - 1,
            b.r0,
            b.shareScale,
            b.strength0,
            b.strength90,
            diffuse.x,
            diffuse.y,
            diffuse.z,
            normal.x,
            normal.y,
            normal.z,
            grazing.x,
            grazing.y,
            grazing.z,
            metallic.x,
            metallic.y,
            metallic.z};
}

/// Fresnel's share (shared::fresnelShare) at a cosine above 0.
inline float glossShare(const Gloss& g, float cosine)
{
    // a = excess / x^2 and b = x (cosine x - 1) / (cosine excess + x), by one division
    const float x = std::sqrt(g.excess + cosine * cosine) + cosine, x2 = x * x;
    const float below = cosine * g.excess + x, inverse = 1 / (x2 * below);
    const float a = g.excess * below * inverse;
    const float b = x2 * x * (cosine * x - 1) * inverse;
    const float exact = 0.5f * a * a * (1 + b * b);
    return lesser(greater((exact - g.r0) * g.shareScale, 0.0f), 1.0f);
}

/// The BSDF (no cosine) for light from (x, y, z), unit and local; 0 from below.
inline void evalGloss(const Gloss& g, float x, float y, float z, float& fR, float& fG, float& fB)
{
    const float ci = greater(z, shared::kMinCosine);
    // What passes the interface to the diffuse part: shared::interfaceAlbedo.
    const float wide0 = g.alpha + 0.29f * (1 - g.alpha) * ci;
    const float wide = greater(wide0 * wide0, 1.0e-20f), narrow = (1 - ci) * g.alpha;
    const float flat = 1 - 0.65f * g.alpha * g.alpha * ci * (2 - ci);
    const float steep = glossShare(g, ci) * wide / (wide + 15.5f * g.alpha * narrow * narrow) +
                        0.004f * lesser(1.0f, 4 * g.alpha) * ci;
    const float taken = g.strength0 * flat;
    const float through = 1 - taken - (g.strength90 - taken) * lesser(steep, 1.0f);
    // The facet lobe: shared::reflectFacet.
    const float a2 = g.alpha * g.alpha;
    const float hx = g.woX + x, hy = g.woY + y, hz = g.woZ + ci;
    const float across = hx * hx + hy * hy, l2 = across + hz * hz;
    const float wideness = across + a2 * hz * hz,
                masked = ci * g.smith + g.woZ * std::sqrt(a2 + (1 - a2) * ci * ci);
    const float value = 0.5f * shared::kInvPi * (a2 * l2) * l2 / (wideness * wideness * masked);
    const float cosine = lesser(0.5f * std::sqrt(l2), 1.0f);
    const float t = glossShare(g, cosine), m = 1 - cosine, m5 = m * m * m * m * m;
    const float r = g.diffuseR * through + (g.normalR + g.grazingR * t + g.metallicR * m5) * value;
    const float gr = g.diffuseG * through + (g.normalG + g.grazingG * t + g.metallicG * m5) * value;
    const float b = g.diffuseB * through + (g.normalB + g.grazingB * t + g.metallicB * m5) * value;
    const float counts = static_cast<float>(z > shared::kMinCosine);  // a choice would be a branch
    fR = r * counts;
    fG = gr * counts;
    fB = b * counts;
}

}  // namespace core::many_lights
