// The surface model: glTF 2.0 metallic-roughness with KHR ior, specular, transmission, volume and
// clearcoat, on the microfacets of microfacet.h. What differs from the glTF appendix, and why:
// - Fresnel of dielectrics is the exact curve, remapped: t = (F - r0) / (1 - r0), then f0 -> f90.
//   It agrees with Schlick's at both ends, and with glass. Opaque surfaces use indices 1 to 3.5.
// - Diffuse is c/pi (1-R(o)) (1-R(i)) / (1-Ravg), R the albedo of the interface, for c/pi (1-F(h))
//   is brighter than white at grazing angles. It is reciprocal, and white under a white surface: to
//   0.2 % over a smooth interface, 1 to 2 % over a rough one. R and its cosine mean Ravg are bounds
//   fitted to quadrature (roughAlbedo), R from above, Ravg from below: no albedo exceeds 1.001.
// - A coat darkens its base by 1 - coat * max(R(o), R(i)): reciprocal, never brighter than one.
// - Light that leaves a facet towards another one is lost (single scattering), as in glTF.
//
// Directions are local, z is the shading normal on wo's side, and both point away from the surface.
// Inside a solid (`backFace`) the index is inverted. Transmission carries radiance: it has 1/eta^2.
#ifndef REKINDLE_SHARED_BSDF_H
#define REKINDLE_SHARED_BSDF_H

#include "lang.h"
#include "layout.h"
#include "microfacet.h"
#include "warp.h"

SHARED_BEGIN

// What sampleBsdf drew.
SHARED_CONST uint kLobeDelta = 1u;
SHARED_CONST uint kLobeTransmission = 2u;
SHARED_CONST uint kLobeSpecular = 4u;

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

/// weight = f |cos| / pdf. Delta lobes: pdf is 0 and weight complete.
struct BsdfSample {
    vec3 wi;
    float pdf;
    vec3 weight;
    uint flags;
};

// --- the main interface and the coat -----------------------------------------------------------

/// Adds the metallic part's reflection at cosine c (Schlick) to `reflected`.
SHARED_FN void addMetal(Bsdf b, float c, INOUT(vec3) reflected)
{
    if (FEATURE(kFeatureMetal)) {
        float m = 1.0f - c;
        float m2 = m * m;
        reflected += b.metal + (vec3(b.metalShare) - b.metal) * (m2 * m2 * m);
    }
}

/// True inside a solid past the critical angle, where everything is reflected whatever the specular
/// factor says.
SHARED_FN bool isTotal(Bsdf b, float exact)
{
    return FEATURE(kFeatureTransmission) && (b.parts & kBsdfSolid) != 0u && exact >= 1.0f;
}

/// Colour that a facet of the main interface reflects at cosine c, and the share (a scalar, so that
/// the complement of a coloured reflection does not tint what lies below) that passes through it.
SHARED_FN void facetFresnel(Bsdf b, float c, OUT(vec3) reflected, OUT(float) through)
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
SHARED_FN void interfaceAlbedo(Bsdf b, float c, OUT(vec3) reflected, OUT(float) through)
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
SHARED_FN float coatAlbedo(Bsdf b, float c)
{
    vec2 xy = roughAlbedo(
        c, fresnelShare(fresnelDielectric(c, kCoatIor), kCoatR0, 1.0f / (1.0f - kCoatR0)),
        b.coatAlpha);
    return b.coat * (kCoatR0 * xy.x + (1.0f - kCoatR0 * xy.x) * xy.y);
}

/// What the coat leaves to its base for light that goes by cosines co and ci (signed). It lies on
/// the outside of a solid and on both sides of anything else. The largest albedo belongs to the
/// smallest cosine.
SHARED_FN float coatThrough(Bsdf b, float co, float ci)
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

/// Neither interface, transmission nor coat: evaluation is one multiplication.
SHARED_FN bool isLambert(Bsdf b)
{
    return !FEATURE(kFeatureSpecular | kFeatureTransmission | kFeatureClearcoat) ||
           (b.parts & ~kBsdfDiffuse) == 0u;
}

/// True when no lobe has a density, so that light sampling is useless.
SHARED_FN bool isDelta(Bsdf b)
{
    return (b.parts & kBsdfDiffuse) == 0u &&
           ((b.parts & kBsdfMicrofacet) == 0u || b.alpha == 0.0f) &&
           ((b.parts & kBsdfCoat) == 0u || b.coatAlpha == 0.0f);
}

// --- lobes -------------------------------------------------------------------------------------

/// Probabilities of the three ways to sample, from estimated albedos, and the interface's Fresnel
/// terms at wo.
struct LobeChoice {
    float coat;
    float facet;
    float diffuse;
    float through;  // to the diffuse part, at wo
};

SHARED_FN LobeChoice chooseLobes(Bsdf b, vec3 wo)
{
    LobeChoice c;
    vec3 reflected = vec3(0.0f);
    c.through = 1.0f;
    if ((b.parts & kBsdfMicrofacet) != 0u) {
        interfaceAlbedo(b, wo.z, reflected, c.through);
    }
    c.facet = maxComponent(reflected) + maxComponent(b.transmit) * c.through;
    c.diffuse = maxComponent(b.diffuse) * c.through;
    c.coat = 0.0f;
    if (FEATURE(kFeatureClearcoat) && (b.parts & (kBsdfCoat | kBsdfInside)) == kBsdfCoat) {
        c.coat = coatAlbedo(b, wo.z);
        c.facet *= 1.0f - c.coat;
        c.diffuse *= 1.0f - c.coat;
    }
    float sum = c.coat + c.facet + c.diffuse;
    float inverse = sum > 0.0f ? 1.0f / sum : 0.0f;
    c.coat *= inverse;
    c.facet *= inverse;
    c.diffuse *= inverse;
    return c;
}

/// Probability that a sampled normal reflects rather than transmits.
SHARED_FN float reflectShare(Bsdf b, vec3 reflected, float through)
{
    if (!FEATURE(kFeatureTransmission) || (b.parts & kBsdfTransmission) == 0u) {
        return 1.0f;
    }
    float r = maxComponent(reflected);
    float t = maxComponent(b.transmit) * through;
    return r + t > 0.0f ? r / (r + t) : 1.0f;
}

/// True when normals whose mirror direction ends below the surface are of use, to refraction.
SHARED_FN bool refractsBelow(Bsdf b)
{
    return FEATURE(kFeatureTransmission) && (b.parts & kBsdfSolid) != 0u;
}

/// Adds the main interface's lobe with density to f and pdf.
SHARED_FN void addFacet(Bsdf b, float probability, vec3 wo, vec3 wi, INOUT(vec3) f,
                        INOUT(float) pdf)
{
    bool up = wi.z > 0.0f;
    if (!up && !(FEATURE(kFeatureTransmission) && (b.parts & kBsdfTransmission) != 0u)) {
        return;
    }
    Facet facet;
    if (FEATURE(kFeatureTransmission) && !up && (b.parts & kBsdfSolid) != 0u) {
        facet = refractFacet(wo, wi, b.alpha, b.eta);
    } else {
        facet = reflectFacet(wo, vec3(wi.x, wi.y, abs(wi.z)), b.alpha,
                             capDepth(wo.z, b.alpha * b.alpha,
                                      refractsBelow(b)));  // a thin wall mirrors its reflection
    }
    vec3 reflected;
    float through;
    facetFresnel(b, facet.cosine, reflected, through);
    float share = reflectShare(b, reflected, through);
    f += (up ? reflected : b.transmit * through) * facet.value;
    pdf += probability * (up ? share : 1.0f - share) * facet.pdf;
}

/// evalPdfBsdf of what is not plain Lambert, both directions being off the horizon.
SHARED_FN void evalLobes(Bsdf b, LobeChoice c, vec3 wo, vec3 wi, OUT(vec3) f, OUT(float) pdf)
{
    f = vec3(0.0f);
    pdf = 0.0f;
    if (wi.z < 0.0f && (b.parts & kBsdfTransmission) == 0u) {
        return;
    }
    if (wi.z > 0.0f && (b.parts & kBsdfDiffuse) != 0u) {
        float through = 1.0f;
        if ((b.parts & kBsdfMicrofacet) != 0u) {
            vec3 unused;
            interfaceAlbedo(b, wi.z, unused, through);
        }
        f = b.diffuse * (c.through * through * b.diffuseNorm * kInvPi);
        pdf = c.diffuse * wi.z * kInvPi;
    }
    if ((b.parts & kBsdfMicrofacet) != 0u && b.alpha > 0.0f) {
        addFacet(b, c.facet, wo, wi, f, pdf);
    }
    if (FEATURE(kFeatureClearcoat) && (b.parts & kBsdfCoat) != 0u) {
        f *= coatThrough(b, wo.z, wi.z);
        if (b.coatAlpha > 0.0f && wi.z > 0.0f && (b.parts & kBsdfInside) == 0u) {
            float depth = capDepth(wo.z, b.coatAlpha * b.coatAlpha, false);
            Facet facet = reflectFacet(wo, wi, b.coatAlpha, depth);
            f += vec3(b.coat * fresnelDielectric(facet.cosine, kCoatIor) * facet.value);
            pdf += c.coat * facet.pdf;
        }
    }
    if (!(pdf + f.x + f.y + f.z < 1.0e30f)) {
        f = vec3(0.0f);
        pdf = 0.0f;
    }
}

// --- public evaluation -------------------------------------------------------------------------

/// How the lobes share directions at wo, for many evaluations there; of a Lambert surface nothing
/// needs to be known.
SHARED_FN LobeChoice lobesAt(Bsdf b, vec3 wo)
{
    LobeChoice c;
    c.coat = 0.0f;
    c.facet = 0.0f;
    c.diffuse = 0.0f;
    c.through = 1.0f;
    if (!isLambert(b)) c = chooseLobes(b, wo);
    return c;
}

/// f (no cosine) and the solid-angle density of sampleBsdf, delta lobes excluded from both; `lobes`
/// are those at wo.
SHARED_FN void evalPdfLobes(Bsdf b, LobeChoice lobes, vec3 wo, vec3 wi, OUT(vec3) f, OUT(float) pdf)
{
    f = vec3(0.0f);
    pdf = 0.0f;
    if (!(wo.z > kMinCosine) || !(abs(wi.z) > kMinCosine)) {
        return;
    }
    if (isLambert(b)) {
        if (wi.z > 0.0f) {
            f = b.diffuse * kInvPi;
            pdf = (b.parts & kBsdfDiffuse) != 0u ? wi.z * kInvPi : 0.0f;
        }
        return;
    }
    evalLobes(b, lobes, wo, wi, f, pdf);
}

SHARED_FN void evalPdfBsdf(Bsdf b, vec3 wo, vec3 wi, OUT(vec3) f, OUT(float) pdf)
{
    evalPdfLobes(b, lobesAt(b, wo), wo, wi, f, pdf);
}

SHARED_FN vec3 evalBsdf(Bsdf b, vec3 wo, vec3 wi)
{
    vec3 f;
    float pdf;
    evalPdfBsdf(b, wo, wi, f, pdf);
    return f;
}

SHARED_FN float pdfBsdf(Bsdf b, vec3 wo, vec3 wi)
{
    vec3 f;
    float pdf;
    evalPdfBsdf(b, wo, wi, f, pdf);
    return pdf;
}

// --- public sampling ---------------------------------------------------------------------------

/// Reflects or transmits at the normal h of the main interface, by u in [0, c.facet); sets wi and
/// flags, and the complete weight of a delta lobe.
SHARED_FN void sampleInterface(Bsdf b, LobeChoice c, vec3 wo, vec3 h, float u, INOUT(BsdfSample) s)
{
    vec3 reflected;
    float through;
    facetFresnel(b, min(dot(wo, h), 1.0f), reflected, through);
    float share = reflectShare(b, reflected, through);
    bool up = u < share * c.facet;
    bool refracts = !up && (b.parts & kBsdfSolid) != 0u;
    s.wi = mirrorAbout(wo, h);
    if (!up) {
        s.flags |= kLobeTransmission;
        s.wi = refracts ? refractAbout(wo, h, b.eta) : vec3(s.wi.x, s.wi.y, -s.wi.z);
    }
    if ((s.flags & kLobeDelta) != 0u) {
        float probability = c.facet * (up ? share : 1.0f - share);
        float radiance = refracts ? 1.0f / (b.eta * b.eta) : 1.0f;
        s.weight =
            (up ? reflected : b.transmit * through) * (radiance / max(probability, 1.0e-20f));
        if (FEATURE(kFeatureClearcoat) && (b.parts & kBsdfCoat) != 0u) {
            s.weight *= coatThrough(b, wo.z, s.wi.z);
        }
    }
}

/// Whether light goes through as through a pane: straight on, along -wo.
SHARED_FN bool isPane(Bsdf b)
{
    return FEATURE(kFeaturePanes) && b.alpha == 0.0f &&
           (b.parts & (kBsdfTransmission | kBsdfSolid)) == kBsdfTransmission;
}

/// What of the light along -wo a pane lets through: the weight of its delta lobe of transmission
/// times the probability that it is drawn.
SHARED_FN vec3 straightThrough(Bsdf b, vec3 wo)
{
    if (!(wo.z > kMinCosine)) return vec3(0.0f);
    vec3 reflected;
    float through;
    facetFresnel(b, min(wo.z, 1.0f), reflected, through);
    vec3 passed = b.transmit * through;
    if (FEATURE(kFeatureClearcoat) && (b.parts & kBsdfCoat) != 0u)
        passed *= coatThrough(b, wo.z, -wo.z);
    return passed;
}

/// Draws wi for wo. False when the path ends here (absorbed, or below the horizon): that share of
/// the density is missing from the integral of pdfBsdf. uLobe chooses the lobe and is reused inside
/// it; `c` are the lobes at wo.
SHARED_FN bool sampleLobes(Bsdf b, LobeChoice c, vec3 wo, float uLobe, vec2 u, OUT(BsdfSample) s)
{
    s.wi = vec3(0.0f, 0.0f, 1.0f);
    s.pdf = 0.0f;
    s.weight = vec3(0.0f);
    s.flags = 0u;
    if (!(wo.z > kMinCosine)) {
        return false;
    }
    vec2 disk = sampleDisk(u);
    if (isLambert(b)) {
        s.wi = cosineHemisphereFromDisk(disk);
        s.pdf = s.wi.z * kInvPi;
        s.weight = b.diffuse;
        return s.wi.z > kMinCosine && (b.parts & kBsdfDiffuse) != 0u;
    }
    bool inCoat = uLobe < c.coat;
    if (inCoat || uLobe < c.coat + c.facet) {
        float alpha = inCoat ? b.coatAlpha : b.alpha;
        bool delta = FEATURE(kFeatureDelta) && alpha == 0.0f;
        float depth = capDepth(wo.z, alpha * alpha, !inCoat && refractsBelow(b));
        vec3 h = delta ? vec3(0.0f, 0.0f, 1.0f) : visibleNormal(wo, alpha, depth, disk);
        s.flags = delta ? kLobeSpecular | kLobeDelta : kLobeSpecular;
        if (inCoat) {
            s.wi = mirrorAbout(wo, h);
            s.weight = vec3(b.coat * fresnelDielectric(wo.z, kCoatIor) / c.coat);
        } else {
            sampleInterface(b, c, wo, h, uLobe - c.coat, s);
        }
    } else {
        s.wi = cosineHemisphereFromDisk(disk);
    }
    if (!(((s.flags & kLobeTransmission) != 0u ? -s.wi.z : s.wi.z) > kMinCosine)) {
        return false;  // the facet sends it to the wrong side: lost between facets
    }
    if ((s.flags & kLobeDelta) == 0u) {
        vec3 f;
        evalLobes(b, c, wo, s.wi, f, s.pdf);
        if (!(s.pdf > 0.0f)) {
            return false;
        }
        s.weight = f * (abs(s.wi.z) / s.pdf);
    }
    return maxComponent(s.weight) > 0.0f && maxComponent(s.weight) < 1.0e30f;
}

SHARED_FN bool sampleBsdf(Bsdf b, vec3 wo, float uLobe, vec2 u, OUT(BsdfSample) s)
{
    return sampleLobes(b, lobesAt(b, wo), wo, uLobe, u, s);
}

/// Estimate of the share of light from all sides that goes towards wo: what denoisers call albedo.
SHARED_FN vec3 albedoBsdf(Bsdf b, vec3 wo)
{
    if (isLambert(b)) {
        return b.diffuse;
    }
    vec3 reflected = vec3(0.0f);
    float through = 1.0f;
    float c = clamp(wo.z, 0.0f, 1.0f);
    if ((b.parts & kBsdfMicrofacet) != 0u) {
        interfaceAlbedo(b, c, reflected, through);
    }
    vec3 base = reflected + (b.diffuse + b.transmit) * through;
    if (!FEATURE(kFeatureClearcoat) || (b.parts & (kBsdfCoat | kBsdfInside)) != kBsdfCoat) {
        return base;
    }
    float coat = coatAlbedo(b, c);
    return base * (1.0f - coat) + vec3(coat);
}

SHARED_END

#endif
