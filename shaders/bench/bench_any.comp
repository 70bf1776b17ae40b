// Whether an array of rays is blocked, for measuring and testing the traversal alone: w is 1 or 0.
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
    const bool blocked = traceAny(Ray(a.xyz, a.w, b.xyz, b.w), lane);
    words[lane] = vec4(0.0, 0.0, 0.0, uintBitsToFloat(blocked ? 1u : 0u));
}
