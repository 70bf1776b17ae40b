// One lane, one sample of ambient occlusion: a camera ray, and a ray from what it hits.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_basic : require

#include "radiance.glsl"
#include "traverse.glsl"
#include "shared/ao.h"

layout(local_size_x = 64) in;

layout(constant_id = kSpecializeSampler) const uint kSampler = 0u;

layout(push_constant, scalar) uniform PushBlock
{
    OcclusionBatch push;
};

/// 1 where the direction of the sample is open, 0 where it is not; counts the rays.
float openness(SampleStream stream, uvec2 pixel, inout uint shadowRays)
{
    const PathState path = beginPath(frame.camera, frame.settings, pixel, stream);
    Hit hit;
    const Ray ray = Ray(path.origin, 0.0, path.direction, kInfinity);
    if (!traceClosest(ray, alphaSeed(stream, 0u, 0u), hit)) return 1.0;
    OcclusionRay asked;
    if (!occlusionRay(scene, stream, hit, path.direction, push.reach, asked)) return 0.0;
    ++shadowRays;
    const Ray way = Ray(asked.origin, 0.0, asked.direction, asked.tMax);
    return traceAny(way, alphaSeed(stream, 0u, 1u)) ? 0.0 : 1.0;
}

void main()
{
    const uint lane = gl_GlobalInvocationID.x;
    const uvec2 pixel = lanePixel(push.batch, lane);
    const bool inside = lane < laneCount(push.batch) && insideImage(pixel);
    uint shadowRays = 0u;
    if (inside) {
        const SampleStream stream = makeStream(kSampler, frame.settings.seed, pixel,
                                               laneSample(push.batch, lane), kPurposeOcclusion);
        radiance[lane] = vec4(vec3(openness(stream, pixel, shadowRays)), 0.0);
    }
    const uint closestRays = subgroupAdd(inside ? 1u : 0u);
    shadowRays = subgroupAdd(shadowRays);
    if (subgroupElect()) {
        atomicAdd(counters.closestRays, closestRays);
        atomicAdd(counters.shadowRays, shadowRays);
    }
}
