// Begins the new paths of the pixels that wait for one: the first direction is resampled where old samples leave the
// most to it; with each a new connection to an emitter. A lane is a path.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_basic : require

#define REKINDLE_READS_CHAINS
#define REKINDLE_WRITES_PATHS
#include "reuse_paths.glsl"

layout(local_size_x = 64) in;

layout(set = kSetKernel, binding = kBindNewSamples, scalar) writeonly buffer NewSamplesBlock
{
    uvec4 newSamples[];
};

layout(set = kSetKernel, binding = kBindWaitingHead, scalar) readonly buffer WaitingHeadBlock
{
    WaitingHead waitingHead;
};

void main()
{
    const uint number = gl_GlobalInvocationID.x;
    ReuseTally tally = ReuseTally(0u, 0u);
    PathUnderWay path;
    bool goes = number < waitingHead.queue.count;
    if (goes) {
        const uint lane = laneOfPath(number);
        const uint which = whichOfPath(number);
        path.number = number;
        path.importance = 1.0;
        if (FEATURE(kFeatureDelta) && which == kRestPath) {
            path.ray = restOfChain(loadChain(lane));
            path.settings = kRestSettings;
            path.index = push.batch.firstSample;
        } else {
            const uvec2 pixel = lanePixel(push.batch, lane);
            const uvec4 here = pixelsNow[pixelIndex(pixel)];
            SampleStream stream = pixelStream(pixel);
            PathSettings settings = frame.settings;
            ReuseNew result = noReuseNew();
            ReuseTrail trail = noReuseTrail();
            ReuseVertex v;
            vec3 towardsBefore;
            vec3 seen = vec3(0.0);
            goes = firstVertex(pixel, lane, stream, here, settings, v, towardsBefore, seen);
            path.settings = frame.settings.maxDepth - settings.maxDepth;
            if (goes) {
                lookBack(here, towardsBefore, v);
                stream = pathStream(push.settings, stream, v.rays, which);
                path.index = stream.index;
                path.ray = pathFromHere(v);
                goes = beginTracedPath(scene, settings, push.settings, v, stream, path.ray, trail, result, tally);
                path.importance = maxComponent(trail.weight);
            }
            storeBeginning(number, trail, result.lost);
            const uint to = kReuseNewWords * number;
            newSamples[to + 2u] = packLightRecord(result.light);
            newSamples[to + 4u] = uvec4(floatBitsToUint(result.direct), 0u);
        }
    }
    queuePath(goes, 0u, path);
    const uint shadowRays = subgroupAdd(tally.shadowRays);
    if (subgroupElect()) atomicAdd(counters.shadowRays, shadowRays);
}
