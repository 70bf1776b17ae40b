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

/// `direction` is that of the ray, unit.
SHARED_FN FirstHit makeFirstHit(IN(SceneView) scene, Hit hit, vec3 direction)
{
    SurfacePoint s = makeSurfacePoint(scene, hit, direction);
    const Shading shading = evaluateMaterial(scene, s, direction);
    FirstHit f;
    f.depth = hit.t;
    f.normal = s.frame[2];
    f.albedo = albedoBsdf(makeBsdf(shading.inputs), toLocal(s.frame, -direction));
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
