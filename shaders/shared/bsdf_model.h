// What a surface is: glTF 2.0 metallic-roughness with KHR ior, specular, transmission, volume and
// clearcoat, on the microfacets of microfacet.h. What differs from the glTF appendix, and why:
// - Fresnel of dielectrics is the exact curve, remapped: t = (F - r0) / (1 - r0), then f0 -> f90.
//   It agrees with Schlick's at both ends, and with glass. Opaque surfaces use indices 1 to 3.5.
// - Diffuse is c/pi (1-R(o)) (1-R(i)) / (1-Ravg), R the albedo of the interface, for c/pi (1-F(h))
//   is brighter than white at grazing angles. It is reciprocal, and white under a white surface: to
//   0.2 % over a smooth interface, 1 to 2 % over a rough one. R and its cosine mean Ravg are bounds
//   fitted to quadrature (roughAlbedo), R from above, Ravg from below: no albedo exceeds 1.001.
// - A coat darkens its base by 1 - coat * max(R(o), R(i)): reciprocal, never brighter than one.
//   What shines below it, by 1 - coat * F(o), rough or smooth, as KHR_materials_clearcoat has it.
// - Light that leaves a facet towards another one is lost (single scattering), as in glTF.
//
// Directions are local, z is the shading normal on wo's side, and both point away from the surface.
// Inside a solid (`backFace`) the index is inverted. Transmission carries radiance: it has 1/eta^2.
#ifndef REKINDLE_SHARED_BSDF_MODEL_H
#define REKINDLE_SHARED_BSDF_MODEL_H

#include "lang.h"
#include "layout.h"
#include "microfacet.h"

SHARED_BEGIN

// What a Bsdf has.
SHARED_CONST uint kBsdfDiffuse = 1u;
SHARED_CONST uint kBsdfMicrofacet = 2u;
SHARED_CONST uint kBsdfTransmission = 4u;
SHARED_CONST uint kBsdfSolid = 8u;    // transmission refracts; otherwise it is that of a thin wall
SHARED_CONST uint kBsdfInside = 16u;  // wo is inside the solid
SHARED_CONST uint kBsdfCoat = 32u;

SHARED_CONST float kMinCosine = 1.0e-6f;
SHARED_CONST float kCoatIor = 1.5f;
SHARED_CONST float kCoatR0 = 0.04f;

/// A material at a point, textures applied. flags: of Material. backFace: 1 when wo is on the
/// geometric back.
struct BsdfInputs {
    vec3 baseColor;
    float metallic;
    float roughness;
    float ior;
    float transmission;
    vec3 specularColor;
    float specular;
    float clearcoat;
    float clearcoatRoughness;
    uint flags;
    uint backFace;
};

/// Prepared for any pair of directions.
struct Bsdf {
    vec3 diffuse;       // albedo of the Lambertian part under a perfect window
    float diffuseNorm;  // 1 / (1 - Ravg)
    vec3 f0;            // reflection of the dielectric part at normal incidence, times its share
    float f90;          // and at grazing, times its share
    vec3 metal;         // the same of the metallic part: base colour times its share
    float metalShare;
    vec3 transmit;     // tint of the transmitted part, times its share
    float alpha;       // GGX width; 0 = delta
    float eta;         // refraction index of the far side over the near side
    float r0;          // exact reflectance at normal incidence
    float shareScale;  // 1 / (1 - r0)
    float strength0;   // what the interface takes from what lies below at normal incidence,
    float strength90;  // and at grazing
    float coat;
    float coatAlpha;  // 0 = delta
    uint parts;
};

// --- the main interface and the coat -----------------------------------------------------------

/// Adds the metallic part's reflection at cosine c (Schlick) to `reflected`.
SHARED_FN void addMetal(IN(Bsdf) b, float c, INOUT(vec3) reflected)
{
    if (FEATURE(kFeatureMetal)) {
        float m = 1.0f - c;
        float m2 = m * m;
        reflected += b.metal + (vec3(b.metalShare) - b.metal) * (m2 * m2 * m);
    }
}

/// True inside a solid past the critical angle, where everything is reflected whatever the specular
/// factor says.
SHARED_FN bool isTotal(IN(Bsdf) b, float exact)
{
    return FEATURE(kFeatureTransmission) && (b.parts & kBsdfSolid) != 0u && exact >= 1.0f;
}

/// Colour that a facet of the main interface reflects at cosine c, and the share (a scalar, so that
/// the complement of a coloured reflection does not tint what lies below) that passes through it.
SHARED_FN void facetFresnel(IN(Bsdf) b, float c, OUT(vec3) reflected, OUT(float) through)
{
    float exact = fresnelDielectric(c, b.eta);
    float t = fresnelShare(exact, b.r0, b.shareScale);
    reflected = b.f0 + (vec3(b.f90) - b.f0) * t;
    through = 1.0f - b.strength0 - (b.strength90 - b.strength0) * t;
    if (isTotal(b, exact)) {
        reflected = vec3(1.0f - b.metalShare);
        through = 0.0f;
    }
    addMetal(b, c, reflected);
}

/// The same for the whole rough interface seen at cosine c: its albedo, and what reaches the
/// diffuse part below.
SHARED_FN void interfaceAlbedo(IN(Bsdf) b, float c, OUT(vec3) reflected, OUT(float) through)
{
    float exact = fresnelDielectric(c, b.eta);
    float t = fresnelShare(exact, b.r0, b.shareScale);
    // From the dense side the fits do not hold; there diffuse goes without its gain instead
    // (makeBsdf).
    vec2 xy = b.eta >= 1.0f ? roughAlbedo(c, t, b.alpha) : vec2(1.0f, t);
    reflected = b.f0 * xy.x + (vec3(b.f90) - b.f0 * xy.x) * xy.y;
    through = 1.0f - b.strength0 * xy.x - (b.strength90 - b.strength0 * xy.x) * xy.y;
    if (isTotal(b, exact)) {
        reflected = vec3(1.0f - b.metalShare);
        through = 0.0f;
    }
    addMetal(b, c, reflected);
}

/// Albedo of the coat at cosine c.
SHARED_FN float coatAlbedo(IN(Bsdf) b, float c)
{
    vec2 xy = roughAlbedo(
        c, fresnelShare(fresnelDielectric(c, kCoatIor), kCoatR0, 1.0f / (1.0f - kCoatR0)),
        b.coatAlpha);
    return b.coat * (kCoatR0 * xy.x + (1.0f - kCoatR0 * xy.x) * xy.y);
}

/// What the coat leaves to its base for light that goes by cosines co and ci (signed). It lies on
/// the outside of a solid and on both sides of anything else. The largest albedo belongs to the
/// smallest cosine.
SHARED_FN float coatThrough(IN(Bsdf) b, float co, float ci)
{
    bool inside = (b.parts & kBsdfInside) != 0u;
    bool solid = (b.parts & kBsdfSolid) != 0u;
    float lowest = inside ? 2.0f : co;
    if (!solid || (ci > 0.0f) != inside) {
        lowest = min(lowest, abs(ci));
    }
    return lowest > 1.5f ? 1.0f : 1.0f - coatAlbedo(b, lowest);
}

// --- construction ------------------------------------------------------------------------------

/// [0,1], and 0 for what is not a number: by the order of the arguments.
SHARED_FN vec3 saturated(vec3 v)
{
    return min(max(vec3(0.0f), v), vec3(1.0f));
}

SHARED_FN float saturated(float x)
{
    return min(max(0.0f, x), 1.0f);
}

/// Sets what makeBsdf leaves to the main interface. body: share of the dielectric part.
SHARED_FN void setInterface(BsdfInputs m, float body, INOUT(Bsdf) b)
{
    bool transmits = maxComponent(b.transmit) > 0.0f;
    bool solid = transmits && (m.flags & kMaterialVolume) != 0u;
    bool inside = solid && m.backFace != 0u;
    float ior = clamp(m.ior > 0.0f ? m.ior : 1.0e3f, 1.0e-2f, 1.0e3f);  // 0 stands for infinity
    float root = (ior - 1.0f) / (ior + 1.0f);
    float specular = saturated(m.specular);
    vec3 f0 = saturated(root * root * m.specularColor) * specular;
    b.f0 = f0 * body;
    b.f90 = specular * body;
    b.strength0 = maxComponent(f0);
    b.strength90 = specular;
    b.alpha = interfaceAlpha(m.roughness, ior, solid);
    b.eta = inside ? 1.0f / ior : ior;
    if (!solid) {
        b.eta = min(max(ior, 1.0f / ior), 3.5f);  // no critical angle, and no dip below r0
        root = (b.eta - 1.0f) / (b.eta + 1.0f);
    }
    b.r0 = root * root;
    b.shareScale = 1.0f / (1.0f - b.r0);
    if (b.eta >= 1.0f && b.eta <= 3.5f) {  // where the fits hold
        vec2 xy = roughAlbedoMean(b.eta, b.alpha);
        float taken = b.strength0 * xy.x + (specular - b.strength0 * xy.x) * xy.y;
        b.diffuseNorm = 1.0f / max(1.0f - taken, 1.0e-2f);
    }
    b.parts |= kBsdfMicrofacet | (transmits ? kBsdfTransmission : 0u) | (solid ? kBsdfSolid : 0u) |
               (inside ? kBsdfInside : 0u);
}

/// The model of a material at a point. Inputs out of range are clamped, what is not a number is 0.
SHARED_FN Bsdf makeBsdf(BsdfInputs m)
{
    float metallic = FEATURE(kFeatureMetal) ? saturated(m.metallic) : 0.0f;
    float transmission = FEATURE(kFeatureTransmission) ? saturated(m.transmission) : 0.0f;
    float body = 1.0f - metallic;
    vec3 color = saturated(m.baseColor);
    Bsdf b;
    b.diffuse = color * (body * (1.0f - transmission));
    b.diffuseNorm = 1.0f;
    b.f0 = vec3(0.0f);
    b.f90 = 0.0f;
    b.metal = color * metallic;
    b.metalShare = metallic;
    b.transmit = color * (body * transmission);
    b.alpha = 0.0f;
    b.eta = 1.5f;
    b.r0 = 0.04f;
    b.shareScale = 1.0f / 0.96f;
    b.strength0 = 0.0f;
    b.strength90 = 0.0f;
    b.coat = 0.0f;
    b.coatAlpha = 0.0f;
    b.parts = maxComponent(b.diffuse) > 0.0f ? kBsdfDiffuse : 0u;
    if (FEATURE(kFeatureSpecular | kFeatureTransmission) &&
        (m.specular > 0.0f || metallic > 0.0f || transmission > 0.0f)) {
        setInterface(m, body, b);
    }
    if (FEATURE(kFeatureClearcoat) && m.clearcoat > 0.0f) {
        b.coat = saturated(m.clearcoat);
        b.coatAlpha = interfaceAlpha(m.clearcoatRoughness, kCoatIor, false);
        b.parts |= kBsdfCoat;
    }
    if (!FEATURE(kFeatureDelta)) {
        b.alpha = max(b.alpha, kDeltaAlpha);
        b.coatAlpha = max(b.coatAlpha, kDeltaAlpha);
    }
    return b;
}

/// What a coat leaves of emission below it that goes by cosine c.
SHARED_FN float emissionThroughCoat(float clearcoat, float c)
{
    return 1.0f - saturated(clearcoat) * fresnelDielectric(c, kCoatIor);
}

/// Neither interface, transmission nor coat: evaluation is one multiplication.
SHARED_FN bool isLambert(IN(Bsdf) b)
{
    return !FEATURE(kFeatureSpecular | kFeatureTransmission | kFeatureClearcoat) ||
           (b.parts & ~kBsdfDiffuse) == 0u;
}

/// True when no lobe has a density, so that light sampling is useless.
SHARED_FN bool isDelta(IN(Bsdf) b)
{
    return (b.parts & kBsdfDiffuse) == 0u &&
           ((b.parts & kBsdfMicrofacet) == 0u || b.alpha == 0.0f) &&
           ((b.parts & kBsdfCoat) == 0u || b.coatAlpha == 0.0f);
}

SHARED_END

#endif
