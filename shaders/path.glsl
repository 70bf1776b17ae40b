// What the path-tracing kernels share: the stream of a lane, and the tracing of one vertex.
#include "radiance.glsl"
#include "panes.glsl"
#include "shared/path.h"

layout(constant_id = kSpecializeSampler) const uint kSampler = 0u;

SampleStream laneStream(Batch batch, uint lane, uvec2 pixel)
{
    return makeStream(kSampler, frame.settings.seed, pixel, laneSample(batch, lane), kPurposePath);
}

/// Adds what a connection brings if it is open, through panes or not; counts its rays.
void addConnection(ShadowRay shadow, uint seed, inout vec3 L, inout uint rays)
{
    if (!any(notEqual(shadow.contribution, vec3(0.0)))) return;
    ++rays;
    Hit hit;
    bool open = !traceAnyHit(Ray(shadow.origin, 0.0, shadow.direction, shadow.tMax), seed, hit);
    if (!open && passesPanes(frame.settings)) open = comesThrough(hit.slot, seed, shadow, rays);
    if (open) L += shadow.contribution;
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
    addConnection(shadow, alphaSeed(stream, depth, 1u), L, shadowRays);
    return goesOn;
}
