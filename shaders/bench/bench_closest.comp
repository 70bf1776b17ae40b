// Nearest hits of an array of rays, for measuring and testing the traversal alone: t, barycentrics, triangle (kNone: miss).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "traverse.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform PushBlock
{
    ItemRange range;
};

// Two words per ray: origin | tMin, direction | tMax.
layout(set = kSetKernel, binding = kBindRays) uniform usamplerBuffer rayWords;

layout(set = kSetKernel, binding = kBindHits, scalar) writeonly buffer HitBlock
{
    vec4 words[];
};

void main()
{
    const uint lane = rowsLane(gl_GlobalInvocationID, gl_NumWorkGroups);
    if (lane >= range.count) return;
    const vec4 a = uintBitsToFloat(texelFetch(rayWords, int(2u * lane)));
    const vec4 b = uintBitsToFloat(texelFetch(rayWords, int(2u * lane + 1u)));
    Hit hit;
    uint triangle = kNone;
    if (traceClosest(Ray(a.xyz, a.w, b.xyz, b.w), lane, hit)) {
        triangle = floatBitsToUint(fetchTriangleVertex(scene, findTriangle(scene, hit.slot).slot, 0u).w);
    }
    words[lane] = vec4(hit.t, hit.barycentrics, uintBitsToFloat(triangle));
}
