// The surface model at work: which lobes light goes by, their values and densities, and directions
// drawn from them. What the model is, and how directions are given, is said in bsdf_model.h.
#ifndef REKINDLE_SHARED_BSDF_H
#define REKINDLE_SHARED_BSDF_H

#include "bsdf_model.h"
#include "warp.h"

SHARED_BEGIN

// What sampleBsdf drew.
SHARED_CONST uint kLobeDelta = 1u;
SHARED_CONST uint kLobeTransmission = 2u;
SHARED_CONST uint kLobeSpecular = 4u;

/// weight = f |cos| / pdf. Delta lobes: pdf is 0 and weight complete.
struct BsdfSample {
    vec3 wi;
    float pdf;
    vec3 weight;
    uint flags;
};

// --- lobes -------------------------------------------------------------------------------------

/// Probabilities of the three ways to sample, from estimated albedos, and the interface's Fresnel
/// terms at wo.
struct LobeChoice {
    float coat;
    float facet;
    float diffuse;
    float through;  // to the diffuse part, at wo
};

SHARED_FN LobeChoice chooseLobes(IN(Bsdf) b, vec3 wo)
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
SHARED_FN float reflectShare(IN(Bsdf) b, vec3 reflected, float through)
{
    if (!FEATURE(kFeatureTransmission) || (b.parts & kBsdfTransmission) == 0u) {
        return 1.0f;
    }
    float r = maxComponent(reflected);
    float t = maxComponent(b.transmit) * through;
    return r + t > 0.0f ? r / (r + t) : 1.0f;
}

/// True when normals whose mirror direction ends below the surface are of use, to refraction.
SHARED_FN bool refractsBelow(IN(Bsdf) b)
{
    return FEATURE(kFeatureTransmission) && (b.parts & kBsdfSolid) != 0u;
}

/// Adds the main interface's lobe with density to f and pdf.
SHARED_FN void addFacet(IN(Bsdf) b, float probability, vec3 wo, vec3 wi, INOUT(vec3) f,
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
SHARED_FN void evalLobes(IN(Bsdf) b, LobeChoice c, vec3 wo, vec3 wi, OUT(vec3) f, OUT(float) pdf)
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
    // Each by itself: who wants one of them need not know the other.
    if (!(f.x + f.y + f.z < 1.0e30f)) f = vec3(0.0f);
    if (!(pdf < 1.0e30f)) pdf = 0.0f;
}

// --- public evaluation -------------------------------------------------------------------------

/// How the lobes share directions at wo, for many evaluations there; of a Lambert surface nothing
/// needs to be known.
SHARED_FN LobeChoice lobesAt(IN(Bsdf) b, vec3 wo)
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
SHARED_FN void evalPdfLobes(IN(Bsdf) b, LobeChoice lobes, vec3 wo, vec3 wi, OUT(vec3) f,
                            OUT(float) pdf)
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

/// The density alone.
SHARED_FLAT SHARED_FN float pdfLobes(IN(Bsdf) b, LobeChoice lobes, vec3 wo, vec3 wi)
{
    vec3 unused;
    float pdf;
    evalPdfLobes(b, lobes, wo, wi, unused, pdf);
    return pdf;
}

SHARED_FN void evalPdfBsdf(IN(Bsdf) b, vec3 wo, vec3 wi, OUT(vec3) f, OUT(float) pdf)
{
    evalPdfLobes(b, lobesAt(b, wo), wo, wi, f, pdf);
}

SHARED_FN vec3 evalBsdf(IN(Bsdf) b, vec3 wo, vec3 wi)
{
    vec3 f;
    float pdf;
    evalPdfBsdf(b, wo, wi, f, pdf);
    return f;
}

SHARED_FN float pdfBsdf(IN(Bsdf) b, vec3 wo, vec3 wi)
{
    return pdfLobes(b, lobesAt(b, wo), wo, wi);
}

// --- public sampling ---------------------------------------------------------------------------

/// Reflects or transmits at the normal h of the main interface, by u in [0, c.facet); sets wi and
/// flags, and the complete weight of a delta lobe.
SHARED_FN void sampleInterface(IN(Bsdf) b, LobeChoice c, vec3 wo, vec3 h, float u,
                               INOUT(BsdfSample) s)
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
SHARED_FN bool isPane(IN(Bsdf) b)
{
    return FEATURE(kFeaturePanes) && b.alpha == 0.0f &&
           (b.parts & (kBsdfTransmission | kBsdfSolid)) == kBsdfTransmission;
}

/// What of the light along -wo a pane lets through: the weight of its delta lobe of transmission
/// times the probability that it is drawn.
SHARED_FN vec3 straightThrough(IN(Bsdf) b, vec3 wo)
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
SHARED_FN bool sampleLobes(IN(Bsdf) b, LobeChoice c, vec3 wo, float uLobe, vec2 u,
                           OUT(BsdfSample) s)
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

SHARED_FN bool sampleBsdf(IN(Bsdf) b, vec3 wo, float uLobe, vec2 u, OUT(BsdfSample) s)
{
    return sampleLobes(b, lobesAt(b, wo), wo, uLobe, u, s);
}

/// Estimate of the share of light from all sides that goes towards wo: what denoisers call albedo.
SHARED_FN vec3 albedoBsdf(IN(Bsdf) b, vec3 wo)
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
