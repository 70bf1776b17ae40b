// What the two kernels of first hits share: the ray through a pixel's centre, and where is written what is found.
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

/// Whether a lane of the tiles has a pixel, and which.
bool isLaneOfImage(uint lane, out uvec2 pixel)
{
    pixel = tilePixel(tiles.firstTile + lane / kGroupSize, lane % kGroupSize);
    return lane < tiles.tileCount * kGroupSize && insideImage(pixel);
}

SeenWay wayThrough(uvec2 pixel)
{
    const vec2 size = vec2(frame.settings.imageWidth, frame.settings.imageHeight);
    vec3 origin;
    vec3 direction;
    cameraRay(frame.camera, vec2(pixel) + 0.5, size, vec2(0.5), origin, direction);
    return seenAlong(origin, direction);
}
