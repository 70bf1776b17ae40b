// What the kernels of sample reuse share: a lane is a pixel, and each kernel adds to what the one before has left for
// it. The estimator is that of shared/reuse_path.h.
#include "traverse.glsl"
#include "shared/reuse_path.h"

layout(constant_id = kSpecializeSampler) const uint kSampler = 0u;

layout(push_constant, scalar) uniform PushBlock
{
    ReuseBatch push;
};

layout(set = kSetKernel, binding = kBindPixelsNow, scalar) buffer PixelsNowBlock
{
    uvec4 pixelsNow[];
};

// What the frame before has left lies in texels: on software devices a fetch is much faster than a load from a buffer.
layout(set = kSetKernel, binding = kBindPixelsBefore) uniform usamplerBuffer pixelsBefore;

bool traceWay(SceneView view, vec3 origin, vec3 direction, uint seed, out Hit hit)
{
    return traceClosest(Ray(origin, 0.0, direction, kInfinity), seed, hit);
}

bool wayIsOpen(SceneView view, ShadowRay shadow, uint seed)
{
    return !traceAny(Ray(shadow.origin, 0.0, shadow.direction, shadow.tMax), seed);
}

/// The pixel of this lane; false where it has none.
bool lanesPixel(out uint lane, out uvec2 pixel)
{
    lane = gl_GlobalInvocationID.x;
    pixel = uvec2(0u);
    if (lane >= push.batch.tileCount * kGroupSize) return false;
    pixel = lanePixel(push.batch, lane);
    return insideImage(pixel);
}

SampleStream pixelStream(uvec2 pixel)
{
    return makeStream(kSampler, frame.settings.seed, pixel, push.batch.firstSample, kPurposePath);
}

/// Of the picture that left the history.
uvec2 sizeBefore()
{
    return uvec2(push.settings.sizeBefore & 0xffffu, push.settings.sizeBefore >> 16u);
}

/// Where record `i` of a pixel lies in a store of a picture of that size: neighbours side by side.
uint recordIndex(uvec2 size, uint pixel, uint i)
{
    return i * size.x * size.y + pixel;
}

/// The first hit of a pixel, and what it sees directly, in L. False where nothing is scattered.
bool firstVertex(uvec2 pixel, SampleStream stream, uvec4 here, out ReuseVertex v, inout vec3 L)
{
    const PathState ray = pixelRay(frame.camera, frame.settings, push.settings, pixel, stream);
    return beginReuse(scene, frame.settings, ray, unpackReusePixel(here), v, L);
}

/// Takes over the history of pixel `source`; false where there is none.
bool lookBack(uint source, SampleStream stream, inout ReuseVertex v)
{
    if (source == kNone) {
        v.rays = raysDue(push.settings, v.history, 0.0);
        v.history.credit = firstCredit(stream);
        return false;
    }
    const ReusePixel before = unpackReusePixel(texelFetch(pixelsBefore, int(source)));
    takeHistory(push.settings, push.cameraBefore, pointOfTriangle(scene, before.slot, before.barycentrics),
                unpackHistory(before.history), v);
    return true;
}
