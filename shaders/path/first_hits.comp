// First hits at the pixel centres of some tiles, or what is seen there.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "traverse.glsl"
#include "shared/camera.h"
#include "shared/seen.h"

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
    SeenWay way = seenAlong(origin, direction);
    FirstHit found;
    Hit hit;
    bool goesOn = true;
    while (goesOn) {
        if (traceClosest(Ray(way.origin, 0.0, way.direction, kInfinity), kAlphaByHalf, hit)) {
            goesOn = see(scene, hit, way, found) && tiles.looksThrough != 0u;
        } else {
            found = seenNothing(scene, frame.settings, way);
            goesOn = false;
        }
    }
    firstHits[pixelIndex(pixel) - tiles.firstPixel] = found;
}
