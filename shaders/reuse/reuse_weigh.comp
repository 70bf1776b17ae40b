// Ends new paths: completes what is kept of each, and takes off what old samples answer for.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_basic : require

#define REKINDLE_READS_CHAINS
#include "reuse_paths.glsl"

layout(local_size_x = 64) in;

layout(set = kSetKernel, binding = kBindTrails) uniform usamplerBuffer trails;

layout(set = kSetKernel, binding = kBindPathGathered, scalar) readonly buffer GatheredBlock
{
    vec4 gatheredNow[];
};

layout(set = kSetKernel, binding = kBindNewSamples, scalar) writeonly buffer NewSamplesBlock
{
    uvec4 newSamples[];
};

layout(set = kSetKernel, binding = kBindWaitingHead, scalar) readonly buffer WaitingHeadBlock
{
    WaitingHead waitingHead;
};

/// What the other kernels have left of a path that has a place, or would have one where nothing is met.
ReuseTrail loadTrail(uint number, inout ReuseNew result)
{
    const int from = int(kReuseTrailWords * number);
    const vec4 direction = uintBitsToFloat(texelFetch(trails, from));
    const vec4 weight = uintBitsToFloat(texelFetch(trails, from + 1));
    const vec4 numbers = uintBitsToFloat(texelFetch(trails, from + 2));
    const uvec4 place = texelFetch(trails, from + 3);
    const uvec4 arriving = texelFetch(trails, from + 4);
    result.lost = numbers.z;
    result.record.slot = place.x;
    result.record.place = place.y;
    result.record.radiance = place.z;
    result.record.lightDirection = arriving.x;
    result.record.lightRadiance = arriving.y;
    result.record.nextDirection = arriving.z;
    return ReuseTrail(direction.xyz, direction.w, weight.xyz, weight.w, numbers.x, numbers.y,
                      unpackVector(texelFetch(trails, from + 5)), unpackVector(texelFetch(trails, from + 6)),
                      unpackVector(texelFetch(trails, from + 7)), uintBitsToFloat(arriving.w), (place.w & 1u) != 0u,
                      (place.w & 2u) != 0u);
}

/// Ends a path from a first hit.
void weigh(uint number, uint which, inout ReuseNew result, inout ReuseTally tally)
{
    const uint lane = laneOfPath(number);
    const uvec2 pixel = lanePixel(push.batch, lane);
    const uvec4 here = pixelsNow[pixelIndex(pixel)];
    const SampleStream stream = pixelStream(pixel);
    PathSettings path = frame.settings;
    ReuseVertex v;
    vec3 towardsBefore;
    vec3 seen = vec3(0.0);
    if (!firstVertex(pixel, lane, stream, here, path, v, towardsBefore, seen)) return;
    lookBack(here, towardsBefore, v);
    ReuseTrail trail = loadTrail(number, result);
    endNewPath(scene, push.settings, v, gatheredNow[number].xyz, pathStream(push.settings, stream, v.rays, which),
               trail, result, tally);
}

void main()
{
    const uint number = gl_GlobalInvocationID.x;
    ReuseTally tally = ReuseTally(0u, 0u);
    if (number < waitingHead.queue.count) {
        ReuseNew result = noReuseNew();
        const uint which = whichOfPath(number);
        if (FEATURE(kFeatureDelta) && which == kRestPath) {
            result.around = gatheredNow[number].xyz;
        } else {
            const vec4 numbers = uintBitsToFloat(texelFetch(trails, int(kReuseTrailWords * number + 2u)));
            result.lost = numbers.z;
            if (numbers.x > 0.0) weigh(number, which, result, tally);
        }
        const uint to = kReuseNewWords * number;
        newSamples[to] = packReusePlace(result.record);
        if (result.record.radiance == kReuseEvaluated) newSamples[to + 1u] = packReuseArriving(result.record);
        newSamples[to + 3u] = floatBitsToUint(vec4(result.around, result.lost));
        newSamples[to + 4u].w = floatBitsToUint(result.scale);
    }
    if (!FEATURE(kFeatureAsksVisibility)) return;
    const uint shadowRays = subgroupAdd(tally.shadowRays);
    if (subgroupElect()) atomicAdd(counters.shadowRays, shadowRays);
}
