// Dielectric Fresnel and GGX with height-correlated Smith shadowing (Heitz 2014): densities, albedo
// bounds, visible normals by bounded spherical caps (Dupuy & Benyoub 2023, Eto & Tokuyoshi 2023),
// reflection and rough refraction (Walter et al. 2007). Differs from the papers in arrangement
// only: no sum cancels at grazing angles, narrow lobes or index one.
#ifndef REKINDLE_SHARED_MICROFACET_H
#define REKINDLE_SHARED_MICROFACET_H

#include "lang.h"

SHARED_BEGIN

SHARED_CONST float kDeltaAlpha = 1.0e-3f;  // narrower lobes have no density

/// GGX alpha of the main interface: roughness squared, or 0 when a delta lobe stands for it. A
/// solid whose index is almost that of air scatters transmitted light by alpha |ior - 1| only, too
/// narrow for fp32 to evaluate.
SHARED_FN float interfaceAlpha(float roughness, float ior, bool solid)
{
    float alpha = roughness * roughness;
    if (!(alpha >= kDeltaAlpha) || (solid && alpha * abs(ior - 1.0f) < 2.0e-4f)) {
        return 0.0f;
    }
    return min(alpha, 1.0f);
}

// --- Fresnel -----------------------------------------------------------------------------------

/// Reflectance of unpolarised light at a smooth dielectric; eta = far index / near index. 1 past
/// the critical angle. (g-c)/(g+c) is written without the difference, which cancels at eta near
/// one.
SHARED_FN float fresnelDielectric(float c, float eta)
{
    float excess = eta * eta - 1.0f;
    float g2 = excess + c * c;
    if (!(g2 > 0.0f)) {
        return excess == 0.0f ? 0.0f : 1.0f;
    }
    float x = sqrt(g2) + c;
    float a = excess / (x * x);                       // (g - c) / (g + c)
    float b = x * (c * x - 1.0f) / (c * excess + x);  // (c (g + c) - 1) / (c (g - c) + 1)
    return min(0.5f * a * a * (1.0f + b * b), 1.0f);
}

/// Exact Fresnel reflectance as the share t of the way from normal to grazing reflection; inverse =
/// 1 / (1 - r0).
SHARED_FN float fresnelShare(float exact, float r0, float inverse)
{
    return clamp((exact - r0) * inverse, 0.0f, 1.0f);
}

/// Bounds on what single-scattering GGX reflects in all directions, as f0 * x + (f90 - f0 * x) * y:
/// x for a constant reflectance, y of the Fresnel share t at the same cosine. Both are fits from
/// above to quadrature over cosines, alphas and indices 1.05 to 3.5, which they exceed by 0.01 on
/// average and miss by 0.0008 at worst.
SHARED_FN vec2 roughAlbedo(float c, float t, float alpha)
{
    float wide = alpha + 0.29f * (1.0f - alpha) * c;
    float narrow = (1.0f - c) * alpha;
    wide = max(wide * wide, 1.0e-20f);
    float y =
        t * wide / (wide + 15.5f * alpha * narrow * narrow) + 0.004f * min(1.0f, 4.0f * alpha) * c;
    return vec2(1.0f - 0.65f * alpha * alpha * c * (2.0f - c), min(y, 1.0f));
}

/// Cosine means of roughAlbedo, from below: the mean of t by index (a fit), thinned by roughness.
SHARED_FN vec2 roughAlbedoMean(float eta, float alpha)
{
    float d = eta - 1.0f;
    float gloss = 0.296f * d * (1.0f - 0.305f * d) / (1.0f + 2.77f * d);
    return vec2(1.0f - 0.5417f * alpha * alpha,
                gloss / (1.0f + 9.4f * alpha * alpha / (alpha + 0.09f)));
}

// --- microfacets -------------------------------------------------------------------------------

/// How far below the horizon of the stretched space the cap of visibleNormal reaches, over the
/// height of wo: 1 covers all visible normals; less leaves out mirror directions that surely end
/// below the surface (Eto & Tokuyoshi, "Bounded VNDF Sampling for Smith-GGX Reflections", 2023).
SHARED_FN float capDepth(float cosine, float a2, bool refracts)
{
    float sine2 = max(1.0f - cosine * cosine, 0.0f);
    float s = 1.0f + sqrt(sine2);
    float s2 = s * s;
    return refracts ? 1.0f : (1.0f - a2) * s2 / (s2 + a2 * cosine * cosine);
}

/// A visible normal of GGX from a point of the unit disk. In the space where GGX is a hemisphere,
/// mirror directions are uniform on a spherical cap, and h is halfway (Dupuy & Benyoub 2023). Sums
/// are arranged so that nothing cancels at grazing angles.
SHARED_FN vec3 visibleNormal(vec3 wo, float alpha, float depth, vec2 disk)
{
    vec3 w = normalize(vec3(alpha * wo.x, alpha * wo.y, wo.z));
    float bottom = depth * w.z;
    float k = 1.0f + bottom;
    float z = (1.0f - dot(disk, disk)) * k;  // height above the bottom of the cap
    float stretch = sqrt(k * max((1.0f - bottom) + z, 0.0f));
    return normalize(vec3(alpha * (disk.x * stretch + w.x), alpha * (disk.y * stretch + w.y),
                          max(z + (w.z - bottom), 1.0e-12f)));
}

/// sqrt(alpha^2 sin^2 + cos^2): Smith's G1 is 2 cos / (cos + this).
SHARED_FN float smithRoot(float cosine, float a2)
{
    return sqrt(a2 + (1.0f - a2) * cosine * cosine);
}

/// GGX density of normals at a direction h of any length; l2 is its squared length.
SHARED_FN float ggxDensity(vec3 h, float l2, float a2)
{
    float d = h.x * h.x + h.y * h.y + a2 * h.z * h.z;
    float ratio = l2 / d;
    return a2 * kInvPi * ratio * ratio;
}

/// What of a microfacet lobe does not depend on colours. `value` is D G2 (times Jacobian parts) /
/// (4 cos cos) or its refracting counterpart, `pdf` the density of the direction under
/// visible-normal sampling, cosine that of wo with h. All zero where the lobe is.
struct Facet {
    float value;
    float pdf;
    float cosine;
};

/// depth: that of visibleNormal.
SHARED_FN Facet reflectFacet(vec3 wo, vec3 wi, float alpha, float depth)
{
    Facet r;
    float a2 = alpha * alpha;
    vec3 h = wo + wi;
    float l2 = dot(h, h);
    float d = ggxDensity(h, max(l2, 1.0e-30f), a2);
    float rootO = smithRoot(wo.z, a2);
    r.pdf = 0.5f * d / (depth * wo.z + rootO);
    r.value = 0.5f * d / (wi.z * rootO + wo.z * smithRoot(wi.z, a2));
    r.cosine = min(0.5f * sqrt(l2), 1.0f);
    return r;
}

SHARED_FN Facet refractFacet(vec3 wo, vec3 wi, float alpha, float eta)
{
    Facet r;
    r.value = 0.0f;
    r.pdf = 0.0f;
    r.cosine = 1.0f;
    vec3 h = wo + eta * wi;
    h = h.z < 0.0f ? -h : h;
    float l2 = dot(h, h);
    float oh = dot(wo, h);
    float ih = -dot(wi, h);
    if (!(l2 > 1.0e-12f) || !(oh > 0.0f) || !(ih > 0.0f)) {
        return r;
    }
    float a2 = alpha * alpha;
    float rootO = smithRoot(wo.z, a2);
    // |wo + eta wi| is Walter's denominator; oh and ih carry one length of h each.
    float shape = ggxDensity(h, l2, a2) * 2.0f * oh * ih / (l2 * l2);
    r.pdf = shape * eta * eta / (wo.z + rootO);
    r.value = shape / (-wi.z * rootO + wo.z * smithRoot(wi.z, a2));
    r.cosine = min(oh / sqrt(l2), 1.0f);
    return r;
}

/// wo reflected about h, or refracted through it; wi.z tells whether it worked.
SHARED_FN vec3 mirrorAbout(vec3 wo, vec3 h)
{
    return 2.0f * dot(wo, h) * h - wo;
}

SHARED_FN vec3 refractAbout(vec3 wo, vec3 h, float eta)
{
    float inverse = 1.0f / eta;
    float c = dot(wo, h);
    float cosine2 = 1.0f - (1.0f - c * c) * inverse * inverse;
    return (c * inverse - sqrt(max(cosine2, 0.0f))) * h - inverse * wo;
}

SHARED_END

#endif
