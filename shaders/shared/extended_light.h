// Virtual lights with extent, one text for GPU and CPU: light that would come from a point comes
// from all directions in which a sphere or a disc around it is seen, so that near lights do not end
// in bright spots. Spheres: Hasan, Krivanek, Walter, Bala, "Virtual Spherical Lights for
// Many-Light Rendering of Glossy Scenes" (2009). Discs, which always face the receiver: Wang,
// "Efficient Sample Usage in Photo-Realistic Rendering" (2022), 5.7.1; what differs from there:
// directions are drawn with the density that the weights say. Both blur, which is a bias. What is
// seen of such a light is told by its centre, and so is whether both ends face each other.
#ifndef REKINDLE_SHARED_EXTENDED_LIGHT_H
#define REKINDLE_SHARED_EXTENDED_LIGHT_H

#include "rng.h"
#include "virtual_light.h"

SHARED_BEGIN

SHARED_CONST uint kLightShapePoint = 0u;
SHARED_CONST uint kLightShapeSphere = 1u;
SHARED_CONST uint kLightShapeDisc = 2u;

// Pairs of directions for a cone as wide as a hemisphere; narrow cones have few.
SHARED_CONST float kLightSamples = 100.0f;
SHARED_CONST uint kMostLightSamples = 142u;  // of a sphere around the receiver
#ifdef __cplusplus
static_assert(kMostExtendedColumns * (kMostLightSamples + 2u) < 65535u);
#endif

/// 1 - cos of half the angle at which the light is seen: up to 1 for discs, 2 within a sphere.
SHARED_FN float lightCone(uint shape, float radius, float distance)
{
    if (shape == kLightShapeSphere) {
        const float sine = min(radius / distance, 1.0f);
        const float narrow = sine * sine / (1.0f + sqrt(max(0.0f, 1.0f - sine * sine)));
        return distance <= radius ? 2.0f : narrow;
    }
    const float slant = sqrt(distance * distance + radius * radius);
    return radius * radius / (slant * (slant + distance));
}

/// What comes to the receiver from direction `wi` of a light, times the cosine there; `pdf` is that
/// of sampling the receiver's BSDF.
SHARED_FN vec3 lightFrom(IN(LightReceiver) r, IN(LightDetails) details, IN(LightRecord) light,
                         vec3 wi, OUT(float) pdf)
{
    vec3 f;
    evalPdfLobes(r.bsdf, r.lobes, r.wo, toLocal(r.frame, wi), f, pdf);
    const float cosine = dot(wi, r.frame[2]);
    const bool passes = cosine * dot(wi, r.side) > 0.0f;
    float leaves = 1.0f;
    if ((light.kind & kVirtualKindMask) == kVirtualSurface) {
        const float facing = -dot(wi, light.normal);
        const bool bothSides = (light.kind & kVirtualBothSides) != 0u;
        leaves = max(facing, bothSides ? -facing : 0.0f);
    }
    const vec3 value = f * lightLeaving(details, light, wi) * (abs(cosine) * leaves);
    return passes && leaves > 0.0f ? value : vec3(0.0f);
}

/// Numbers 0 to 4 of sample i: a Kronecker sequence in five dimensions (powers of the positive root
/// of x^6 = x + 1), shifted.
struct LightNumbers {
    vec2 cone;
    vec2 bsdf;
    float lobe;
};
SHARED_FN LightNumbers drawLightNumbers(uint seed, uint i)
{
    const float scale = 1.0f / 16777216.0f;
    const uvec4 shift = pcg4d(uvec4(seed, 0x9e3779b9u, 0x7f4a7c15u, 0xf39cc060u));
    const uint fifth = hashUint(seed ^ 0x5851f42du);
    // In whole numbers: exact, however many samples.
    LightNumbers n;
    n.cone.x = float((shift.x + i * 3785032107u) >> 8u) * scale;
    n.cone.y = float((shift.y + i * 3335640777u) >> 8u) * scale;
    n.bsdf.x = float((shift.z + i * 2939605023u) >> 8u) * scale;
    n.bsdf.y = float((shift.w + i * 2590590015u) >> 8u) * scale;
    n.lobe = float((fifth + i * 2283013049u) >> 8u) * scale;
    return n;
}

/// As lightContribution, of a light of that shape and of its radius: an unbiased estimate of the
/// integral over its cone. Directions that are uniform in the cone and directions of the receiver's
/// BSDF come in pairs, weighted by the balance heuristic.
SHARED_FN vec3 extendedContribution(IN(LightReceiver) r, IN(LightDetails) details,
                                    IN(LightRecord) light, GatherRules rules, uint shape)
{
    if (light.radius == 0.0f) {
        return lightContribution(r, details, light, rules);
    }
    vec3 towards;
    if (!(lightWeight(r, light, rules, towards) > 0.0f)) {
        return vec3(0.0f);
    }
    const float distance = length(towards);
    const vec3 axis = towards / distance;
    const mat3 around = makeFrame(axis);
    const float cone = lightCone(shape, light.radius, distance);
    const float pdfUniform = pdfCone(cone);
    const uint seed = hashUint(
        r.seed ^ hashUint(floatAsUint(light.position.x) ^
                          hashUint(floatAsUint(light.position.y) ^ floatAsUint(light.position.z))));
    const uint count = max(uint(kLightSamples * sqrt(cone)), 1u);
    vec3 sum = vec3(0.0f);
    uint i = 0u;
    do {
        const LightNumbers u = drawLightNumbers(seed, i);
        float pdf;
        const vec3 inCone = toWorld(around, sampleCone(u.cone, cone));
        const vec3 one = lightFrom(r, details, light, inCone, pdf);
        sum += one / (pdfUniform + pdf);
        BsdfSample drawn;
        const bool goes = sampleLobes(r.bsdf, r.lobes, r.wo, u.lobe, u.bsdf, drawn);
        const vec3 wi = toWorld(r.frame, drawn.wi);
        const vec3 off = wi - axis;
        // 1 - cos without cancellation: half the squared distance of unit vectors.
        if (goes && (drawn.flags & kLobeDelta) == 0u && 0.5f * dot(off, off) <= cone) {
            const vec3 other = lightFrom(r, details, light, wi, pdf);
            sum += other / (pdfUniform + pdf);
        }
        ++i;
    } while (i < count);
    return sum * dimming(r, light, towards) / (kPi * light.radius * light.radius * float(count));
}

SHARED_END

#endif
