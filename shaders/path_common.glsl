// What the path-tracing kernels share: buffers of paths, lanes to pixels, the tracing of one vertex.
#include "scene.glsl"
#include "shared/path.h"

layout(constant_id = 1) const uint kSampler = 0u;  // kSpecializeSampler

#define BVH_FETCH_NODE(i) texelFetch(nodeWords, int(i))
#define BVH_FETCH_VERTEX(i) uintBitsToFloat(texelFetch(triangleWords, int(i)))
#define BVH_GRID_LOW frame.gridLow
#define BVH_GRID_SCALE frame.gridScale
#include "traverse.glsl"

layout(push_constant, scalar) uniform BatchBlock
{
    Batch batch;
};

layout(set = 0, binding = kBindRadiance, scalar) buffer RadianceBlock
{
    vec4 radiance[];
};

layout(set = 0, binding = kBindCounters, scalar) buffer CounterBlock
{
    Counters counters;
};

uint everyOtherBit(uint x)
{
    x &= 0x55u;
    x = (x | (x >> 1u)) & 0x33u;
    return (x | (x >> 2u)) & 0x0fu;
}

uint laneCount()
{
    return batch.tileCount * batch.sampleCount * kGroupSize;
}

/// The pixel of a lane; may lie outside the image at its right and lower borders.
uvec2 lanePixel(uint lane)
{
    const uint tile = batch.firstTile + (lane / kGroupSize) % batch.tileCount;
    const uint morton = lane % kGroupSize;
    const uvec2 corner = 8u * uvec2(tile % frame.tilesPerRow, tile / frame.tilesPerRow);
    return corner + uvec2(everyOtherBit(morton), everyOtherBit(morton >> 1u));
}

bool insideImage(uvec2 pixel)
{
    return pixel.x < frame.settings.imageWidth && pixel.y < frame.settings.imageHeight;
}

SampleStream laneStream(uint lane, uvec2 pixel)
{
    const uint index = batch.firstSample + lane / (kGroupSize * batch.tileCount);
    return makeStream(kSampler, frame.settings.seed, pixel, index, kPurposePath);
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
