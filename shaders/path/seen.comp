// What is seen in panes and mirrors, at the pixels that first_hits.comp has left to look at again.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "first_hits.glsl"

layout(set = kSetKernel, binding = kBindLookingLanes, scalar) readonly buffer LookingBlock
{
    uint lookingLanes[];
};

layout(set = kSetKernel, binding = kBindLookingHead, scalar) readonly buffer HeadBlock
{
    QueueHead queues[];
};

void main()
{
    if (gl_GlobalInvocationID.x >= queues[0].count) return;
    uvec2 pixel;
    isLaneOfImage(lookingLanes[gl_GlobalInvocationID.x], pixel);
    SeenWay way = wayThrough(pixel);
    FirstHit found;
    bool onward = true;
    while (onward) {
        Hit hit;
        Arrival at;
        if (traceClosest(Ray(way.origin, 0.0, way.direction, kInfinity), kAlphaByHalf, hit)) {
            found = arriveAt(scene, hit, way, at);
            onward = goesOn(at, way);
        } else {
            found = seenNothing(scene, frame.settings, way);
            onward = false;
        }
    }
    firstHits[pixelIndex(pixel) - tiles.firstPixel] = found;
}
