// Ambient occlusion, one text for GPU and CPU: the cosine-weighted share of directions at the first
// hit along which nothing lies within a distance (Zhukov, Iones, Kronin, "An Ambient Light
// Illumination Model", 1998). A sample is one direction: 1 if it is open, 0 if not. Devices only
// trace rays in between: beginPath; hit? { occlusionRay; trace it }.
#ifndef REKINDLE_SHARED_AO_H
#define REKINDLE_SHARED_AO_H

#include "bindings.h"
#include "path.h"

SHARED_BEGIN

// Beside those of the pixel and the lens.
SHARED_CONST uint kDimensionOcclusion = 2u;

/// Push constants of its kernel.
struct OcclusionBatch {
    Batch batch;
    float reach;
};

/// A ray whose way is to be asked for.
struct OcclusionRay {
    vec3 origin;
    vec3 direction;
    float tMax;
};

/// A direction around the shading normal at `hit`, with density cos / pi, and the reach of its ray:
/// `reach` metres, 0 for as far as there is anything. False where the direction goes into the
/// surface (shading and geometric normal differ), which counts as blocked. `direction` is that of
/// the ray that hit.
SHARED_FN bool occlusionRay(IN(SceneView) scene, SampleStream stream, Hit hit, vec3 direction,
                            float reach, OUT(OcclusionRay) ray)
{
    SurfacePoint s = makeSurfacePoint(scene, hit, direction);
    evaluateMaterial(scene, s, direction);  // for the normal map
    const vec3 local = sampleCosineHemisphere(streamVec2(stream, kDimensionOcclusion));
    ray.direction = toWorld(s.frame, local);
    float side;
    const bool leaves = sideOf(s, ray.direction, local.z, side);
    ray.origin = originOnSide(s, side);
    ray.tMax = reach > 0.0f ? reach : kInfinity;
    return leaves;
}

SHARED_END

#endif
