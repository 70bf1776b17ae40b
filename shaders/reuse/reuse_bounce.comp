// One bounce of every new path that is under way: the first brings it to its place, of which it is stored what a sample
// keeps. Survivors are closed up, so that no lane waits for the longest path of its group.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_basic : require

#define REKINDLE_BOUNCES
#define REKINDLE_WRITES_PATHS
#include "reuse_paths.glsl"

layout(local_size_x = 64) in;

layout(set = kSetKernel, binding = kBindPathTexels) uniform usamplerBuffer stateWords;

layout(set = kSetKernel, binding = kBindPathGathered, scalar) buffer GatheredBlock
{
    vec4 gatheredNow[];
};

PathUnderWay loadPath(uint index)
{
    const int from = int(kReuseStateWords * index);
    const uvec4 a = texelFetch(stateWords, from);
    const uvec4 b = texelFetch(stateWords, from + 1);
    const uvec4 c = texelFetch(stateWords, from + 2);
    const uvec4 d = texelFetch(stateWords, from + 3);
    const uint depth = (a.w >> kNumberBits) & ((1u << kDepthBits) - 1u);
    const PathState ray = PathState(uintBitsToFloat(a.xyz), uintBitsToFloat(b.xyz), uintBitsToFloat(c.xyz),
                                    uintBitsToFloat(b.w), depth, c.w, 0.0, 0u, d.z);
    return PathUnderWay(a.w & ((1u << kNumberBits) - 1u), a.w >> (kNumberBits + kDepthBits), d.x, uintBitsToFloat(d.y),
                        ray);
}

/// The settings that a path follows, and its stream.
PathSettings settingsOf(PathUnderWay path, out SampleStream stream)
{
    const uvec2 pixel = lanePixel(push.batch, laneOfPath(path.number));
    stream = makeStream(kSampler, frame.settings.seed, pixel, path.index, kPurposePath);
    if (!FEATURE(kFeatureDelta)) return frame.settings;
    if (path.settings != kRestSettings) return settingsAfter(frame.settings, path.settings);
    stream = purposeStream(stream, kPurposeRest);
    return restSettings(frame.settings);
}

void main()
{
    const uint index = gl_GlobalInvocationID.x;
    ReuseTally tally = ReuseTally(0u, 0u);
    PathUnderWay path;
    bool alive = index < queues[push.queue].count;
    if (alive) {
        path = loadPath(index);
        SampleStream stream;
        const PathSettings settings = settingsOf(path, stream);
        ReuseTrail trail = noReuseTrail();
        ReuseSample record = noReuseSample();
        const bool atPlace = path.ray.depth == 1u;
        const bool first = push.queue == 0u;
        vec3 gathered = first ? vec3(0.0) : gatheredNow[path.number].xyz;
        const vec3 before = gathered;
        alive = traceNewPath(scene, settings, push.settings, path.importance, stream, path.ray, gathered, trail,
                             record, tally);
        if (first || any(notEqual(gathered, before))) gatheredNow[path.number] = vec4(gathered, 0.0);
        if (atPlace) storePlace(path.number, trail, record);
    }
    queuePath(alive, push.queue + 1u, path);
    const uint closestRays = subgroupAdd(tally.closestRays);
    const uint shadowRays = subgroupAdd(tally.shadowRays);
    if (subgroupElect()) {
        atomicAdd(counters.closestRays, closestRays);
        atomicAdd(counters.shadowRays, shadowRays);
    }
}
