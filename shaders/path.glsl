// What the path-tracing kernels share: the stream of a lane, and the tracing of one vertex.
#include "radiance.glsl"
#include "traverse.glsl"
#include "shared/path.h"

layout(constant_id = kSpecializeSampler) const uint kSampler = 0u;

SampleStream laneStream(Batch batch, uint lane, uvec2 pixel)
{
    return makeStream(kSampler, frame.settings.seed, pixel, laneSample(batch, lane), kPurposePath);
}

/// Extends a path by one vertex: trace, shade, connect. Returns false when the path has ended.
bool extendPath(SampleStream stream, inout PathState path, inout vec3 L, inout uint shadowRays)
{
    Hit hit;
    const Ray ray = Ray(path.origin, 0.0, path.direction, kInfinity);
    if (!traceClosest(ray, alphaSeed(stream, path.depth, 0u), hit)) {
        L += shadeMiss(scene, frame.settings, path);
        return false;
    }
    ShadowRay shadow;
    const uint depth = path.depth;
    const VertexNumbers numbers = drawVertexNumbers(stream, depth);
    const bool goesOn = shadeSurface(scene, frame.settings, numbers, hit, path, shadow, L);
    if (any(notEqual(shadow.contribution, vec3(0.0)))) {
        ++shadowRays;
        const Ray connection = Ray(shadow.origin, 0.0, shadow.direction, shadow.tMax);
        if (!traceAny(connection, alphaSeed(stream, depth, 1u))) L += shadow.contribution;
    }
    return goesOn;
}
