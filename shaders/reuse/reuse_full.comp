// New paths where nothing of them is kept (`full`): a lane takes a chunk of a pixel's, and leaves their sums. With all of
// them in one lane a software device would cut rays short (traverse.glsl), and any other would be held for long. Ways
// that mirrors and glass have not taken are followed here, too.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_basic : require

#define REKINDLE_READS_CHAINS
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

layout(set = kSetKernel, binding = kBindFirstNew) uniform usamplerBuffer firstNew;

/// The paths of a chunk, in one loop: a lane whose path has ended begins its next one while others go on. (With two
/// loops, one within the other, this kernel comes out wrong on NVIDIA 580.159: of the paths after the first, those
/// through glass brought half of their light or less. Mesa's devices took it as it is written, and so did that driver
/// without the passes of cmake/kernel.cmake, or with -O.)
ReuseSums takePaths(uvec2 pixel, uint lane, uint which, inout ReuseTally tally)
{
    ReuseSums sums = noReuseSums();
    const uvec4 here = pixelsNow[pixelIndex(pixel)];
    const SampleStream stream = pixelStream(pixel);
    PathSettings path = frame.settings;
    ReuseVertex v;
    vec3 towardsBefore;
    vec3 seen = vec3(0.0);
    if (!firstVertex(pixel, lane, stream, here, path, v, towardsBefore, seen)) return sums;
    lookBack(here, towardsBefore, v);
    sums.beta = v.beta;
    sums.rays = v.rays;
    const uint all = texelFetch(firstNew, int(lane)).y & 0xffffu;  // as reuse_hits has packed them
    sums.part = partOfPath(v.rays, all);
    ReuseNew found = noReuseNew();
    ReuseTrail trail = noReuseTrail();
    PathState ray = pathFromHere(v);
    vec3 gathered = vec3(0.0);
    SampleStream streamOfPath = stream;
    bool goes = false;
    uint begun = pathsOfChunk(push.settings) * which;
    const uint end = min(begun + pathsOfChunk(push.settings), all);
    while (goes || begun < end) {
        if (!goes) {
            found = noReuseNew();
            trail = noReuseTrail();
            ray = pathFromHere(v);
            gathered = vec3(0.0);
            streamOfPath = pathStream(push.settings, stream, v.rays, begun);
            ++begun;
            goes = beginTracedPath(scene, path, push.settings, v, streamOfPath, ray, trail, found, tally);
        }
        if (goes) {
            goes = traceNewPath(scene, path, push.settings, maxComponent(trail.weight), streamOfPath, ray, gathered,
                                trail, found.record, tally);
            if (!goes) endNewPath(scene, push.settings, v, gathered, streamOfPath, trail, found, tally);
        }
        if (!goes) {
            countAsPart(sums.part, found);
            addReuseNew(sums, found);
        }
    }
    if (goes || begun < end) atomicAdd(counters.cutRays, 1u);  // a device may leave any loop: traverse.glsl
    return sums;
}

void main()
{
    const uint number = gl_GlobalInvocationID.x;
    ReuseTally tally = ReuseTally(0u, 0u);
    if (number < waitingHead.queue.count) {
        const uint lane = laneOfPath(number);
        const uint which = whichOfPath(number);
        const uvec2 pixel = lanePixel(push.batch, lane);
        const uint to = kReuseNewWords * number;
        if (FEATURE(kFeatureDelta) && which == kRestPath) {
            const SampleStream stream = purposeStream(pixelStream(pixel), kPurposeRest);
            const vec3 L = takeRest(scene, restSettings(frame.settings), push.settings, restOfChain(loadChain(lane)),
                                    stream, tally);
            newSamples[to + 3u] = uvec4(floatBitsToUint(L), 0u);
        } else {
            const ReuseSums sums = takePaths(pixel, lane, which, tally);
            for (uint i = 0u; i < kReuseNewWords; ++i) newSamples[to + i] = packPathSums(sums, i);
        }
    }
    const uint closestRays = subgroupAdd(tally.closestRays);
    const uint shadowRays = subgroupAdd(tally.shadowRays);
    if (subgroupElect()) {
        atomicAdd(counters.closestRays, closestRays);
        atomicAdd(counters.shadowRays, shadowRays);
    }
}
