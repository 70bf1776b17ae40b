// What the ray through a pixel's centre meets first: depth, normal, albedo, emission and the ids of
// what is there. Ids are whole numbers up to here: as floats they would be wrong above 2^24.
#ifndef REKINDLE_SHARED_FIRST_HIT_H
#define REKINDLE_SHARED_FIRST_HIT_H

#include "lights.h"
#include "surface.h"

SHARED_BEGIN

/// Depth counts along the ray in units of the world; 0 and kNone where nothing was hit. The normal
/// is that of shading, on the side of the camera. Emission is radiance towards the camera, without
/// the sun.
struct FirstHit {
    float depth;
    vec3 normal;
    vec3 albedo;
    vec3 emission;
    uint triangle;
    uint material;
    uint emitter;
};

/// Of a ray in that direction (unit) that has left the scene.
SHARED_FN FirstHit noFirstHit(IN(SceneView) scene, PathSettings settings, vec3 direction)
{
    FirstHit f;
    f.depth = 0.0f;
    f.normal = vec3(0.0f);
    f.albedo = vec3(0.0f);
    f.emission = vec3(0.0f);
    if (FEATURE(kFeatureEnvironment) && settings.environmentEmitter != kNone)
        f.emission = environmentRadiance(scene, settings, direction);
    f.triangle = kNone;
    f.material = kNone;
    f.emitter = kNone;
    return f;
}

/// Of a point of a surface, as it is seen from `wo` in its frame; the depth is not known here.
SHARED_FN FirstHit firstHitOf(IN(SurfacePoint) s, IN(Shading) shading, IN(Bsdf) bsdf, vec3 wo)
{
    FirstHit f;
    f.depth = 0.0f;
    f.normal = s.frame[2];
    f.albedo = albedoBsdf(bsdf, wo);
    f.emission = shading.emission;
    f.triangle = s.triangle;
    f.material = s.material;
    f.emitter = s.emitter;
    return f;
}

#ifdef __cplusplus
static_assert(sizeof(FirstHit) == 52);
#endif

SHARED_END

#endif
