// One lane, one whole path: least traffic, but lanes wait for the longest path of their group.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_basic : require

#include "path.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform PushBlock
{
    Batch batch;
};

void main()
{
    const uint lane = gl_GlobalInvocationID.x;
    const uvec2 pixel = lanePixel(batch, lane);
    uint closestRays = 0u;
    uint shadowRays = 0u;
    if (lane < laneCount(batch) && insideImage(pixel)) {
        const SampleStream stream = laneStream(batch, lane, pixel);
        PathState path = beginPath(frame.camera, frame.settings, pixel, stream);
        vec3 L = vec3(0.0);
        do {
            ++closestRays;
        } while (extendPath(stream, path, L, shadowRays));
        radiance[lane] = vec4(L, 0.0);
    }
    closestRays = subgroupAdd(closestRays);
    shadowRays = subgroupAdd(shadowRays);
    if (subgroupElect()) {
        atomicAdd(counters.closestRays, closestRays);
        atomicAdd(counters.shadowRays, shadowRays);
    }
}
