// First hits at the pixel centres of some tiles. Panes and mirrors are left to seen.comp: software devices would run its
// branches for every pixel, which takes up to 1.4 times as long.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require

#include "first_hits.glsl"

layout(set = kSetKernel, binding = kBindLookingLanes, scalar) writeonly buffer LookingBlock
{
    uint lookingLanes[];
};

layout(set = kSetKernel, binding = kBindLookingHead, scalar) buffer HeadBlock
{
    QueueHead queues[];
};

#include "queue.glsl"

void main()
{
    const uint lane = gl_GlobalInvocationID.x;
    uvec2 pixel;
    bool looks = false;
    if (isLaneOfImage(lane, pixel)) {
        SeenWay way = wayThrough(pixel);
        Hit hit;
        FirstHit found;
        if (traceClosest(Ray(way.origin, 0.0, way.direction, kInfinity), kAlphaByHalf, hit)) {
            Arrival at;
            found = arriveAt(scene, hit, way, at);
            looks = tiles.looksThrough != 0u && mayGoOn(at);
        } else {
            found = seenNothing(scene, frame.settings, way);
        }
        firstHits[pixelIndex(pixel) - tiles.firstPixel] = found;
    }
    const uint slot = queueSlot(looks, 0u);
    if (looks) lookingLanes[slot] = lane;
}
