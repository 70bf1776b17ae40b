// Both ways in which a surface without a density sends light on, reflection and transmission, for
// methods that follow one and trace the other apart. sampleBsdf chooses between the same two.
#ifndef REKINDLE_SHARED_DELTA_H
#define REKINDLE_SHARED_DELTA_H

#include "bsdf.h"

SHARED_BEGIN

/// True when any lobe has no density.
SHARED_FN bool hasDelta(IN(Bsdf) b)
{
    return FEATURE(kFeatureDelta) && (((b.parts & kBsdfMicrofacet) != 0u && b.alpha == 0.0f) ||
                                      ((b.parts & kBsdfCoat) != 0u && b.coatAlpha == 0.0f));
}

/// What light from the two directions wi counts; nothing where there is no such way.
struct DeltaWays {
    vec3 reflected;
    vec3 through;
    vec3 wiReflected;
    vec3 wiThrough;
};

/// The ways of light towards wo, of a model of which isDelta is true.
SHARED_FN DeltaWays deltaWays(IN(Bsdf) b, vec3 wo)
{
    DeltaWays ways;
    ways.reflected = vec3(0.0f);
    ways.through = vec3(0.0f);
    ways.wiReflected = vec3(-wo.x, -wo.y, wo.z);
    ways.wiThrough = -wo;
    if (!(wo.z > kMinCosine)) return ways;
    if ((b.parts & kBsdfMicrofacet) != 0u) {
        float share;
        facetFresnel(b, min(wo.z, 1.0f), ways.reflected, share);
        if (FEATURE(kFeatureTransmission) && (b.parts & kBsdfTransmission) != 0u) {
            ways.through = b.transmit * share;
            if ((b.parts & kBsdfSolid) != 0u) {
                ways.wiThrough = refractAbout(wo, vec3(0.0f, 0.0f, 1.0f), b.eta);
                ways.through *= 1.0f / (b.eta * b.eta);
            }
        }
    }
    if (FEATURE(kFeatureClearcoat) && (b.parts & kBsdfCoat) != 0u) {
        ways.reflected *= coatThrough(b, wo.z, wo.z);
        ways.through *= coatThrough(b, wo.z, ways.wiThrough.z);
        if ((b.parts & kBsdfInside) == 0u)
            ways.reflected += vec3(b.coat * fresnelDielectric(wo.z, kCoatIor));
    }
    // also where nothing is refracted, and the direction is no number
    if (!(-ways.wiThrough.z > kMinCosine)) ways.through = vec3(0.0f);
    return ways;
}

SHARED_END

#endif
