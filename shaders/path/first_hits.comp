// First hits at the pixel centres of some tiles.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "traverse.glsl"
#include "shared/camera.h"
#include "shared/first_hit.h"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform PushBlock
{
    TileRange tiles;
};

layout(set = kSetKernel, binding = kBindFirstHits, scalar) writeonly buffer FirstHitBlock
{
    FirstHit firstHits[];
};

void main()
{
    const uint lane = gl_GlobalInvocationID.x;
    const uvec2 pixel = tilePixel(tiles.firstTile + lane / kGroupSize, lane % kGroupSize);
    if (lane >= tiles.tileCount * kGroupSize || !insideImage(pixel)) return;
    const vec2 size = vec2(frame.settings.imageWidth, frame.settings.imageHeight);
    vec3 origin;
    vec3 direction;
    cameraRay(frame.camera, vec2(pixel) + 0.5, size, vec2(0.5), origin, direction);
    FirstHit found;
    Hit hit;
    if (traceClosest(Ray(origin, 0.0, direction, kInfinity), kAlphaByHalf, hit))
        found = makeFirstHit(scene, hit, direction);
    else
        found = noFirstHit(scene, frame.settings, direction);
    firstHits[pixelIndex(pixel) - tiles.firstPixel] = found;
}
