// New paths of the pixels that wait for one: the first direction is resampled where old samples leave the most to it;
// with each a new connection to an emitter. A lane is a path; where nothing of them is kept (`full`) it takes all of a
// pixel, and leaves their sums.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_basic : require

#define REKINDLE_READS_CHAINS
#include "reuse.glsl"

layout(local_size_x = 64) in;

layout(set = kSetKernel, binding = kBindNewSamples, scalar) writeonly buffer NewSamplesBlock
{
    uvec4 newSamples[];
};

layout(set = kSetKernel, binding = kBindWaiting, scalar) readonly buffer WaitingBlock
{
    uint waiting[];
};

layout(set = kSetKernel, binding = kBindWaitingHead, scalar) readonly buffer WaitingHeadBlock
{
    WaitingHead waitingHead;
};

void storeNew(uint to, ReuseNew found)
{
    newSamples[to] = packReusePlace(found.record);
    if (found.record.radiance == kReuseEvaluated) newSamples[to + 1u] = packReuseArriving(found.record);
    newSamples[to + 2u] =
        uvec4(found.light.emitter, found.light.numbers, floatBitsToUint(vec2(found.light.v, found.scale)));
    newSamples[to + 3u] = floatBitsToUint(vec4(found.around, found.lost));
    newSamples[to + 4u] = uvec4(floatBitsToUint(found.direct), 0u);
}

void main()
{
    const uint number = gl_GlobalInvocationID.x;
    ReuseTally tally = ReuseTally(0u, 0u);
    if (number < waitingHead.queue.count) {
        const uint lane = waiting[number] & 0xffffu;
        const uint which = waiting[number] >> 16u;
        const uvec2 pixel = lanePixel(push.batch, lane);
        ReuseNew found = noReuseNew();
        ReuseSums sums = noReuseSums();
        ReuseVertex v;
        vec3 seen = vec3(0.0);
        vec3 towardsBefore;
        SampleStream stream = pixelStream(pixel);
        const uvec4 here = pixelsNow[pixelIndex(pixel)];
        PathSettings path = frame.settings;
        bool goes = firstVertex(pixel, lane, stream, here, path, v, towardsBefore, seen);
        PathState ray = pathFromHere(v);
        uint next = which;
        uint end = which + 1u;
        const bool isRest = FEATURE(kFeatureDelta) && which == kRestPath;
        const bool together = push.settings.strategy == kReuseFull && !isRest;
        if (isRest) {
            ray = restOfChain(loadChain(lane));
            path = restSettings(frame.settings);
            stream = purposeStream(stream, kPurposeRest);
            goes = true;
        } else if (goes) {
            lookBack(here, towardsBefore, v);
        }
        if (together) {
            next = 0u;
            end = which;
            sums.beta = v.beta;
            sums.rays = v.rays;
            sums.part = partOfPath(v.rays, which);
        }
        // One call for all: compilers make a copy of what it does for each.
        for (; goes && next < end; ++next) {
            const SampleStream its = isRest ? stream : pathStream(push.settings, stream, v.rays, next);
            found = takePath(scene, path, push.settings, v, ray, its, tally);
            if (!together) continue;
            countAsPart(sums.part, found);
            addReuseNew(sums, found);
        }
        const uint to = kReuseNewWords * number;
        if (together) {
            for (uint i = 0u; i < kReuseNewWords; ++i) newSamples[to + i] = packPathSums(sums, i);
        } else {
            storeNew(to, found);
        }
    }
    const uint closestRays = subgroupAdd(tally.closestRays);
    const uint shadowRays = subgroupAdd(tally.shadowRays);
    if (subgroupElect()) {
        atomicAdd(counters.closestRays, closestRays);
        atomicAdd(counters.shadowRays, shadowRays);
    }
}
