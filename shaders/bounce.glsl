// One bounce of every path that is still alive: read its state, extend it, and append the survivors to the next queue,
// closed up so that no lane idles. Bounce 0 begins the paths. States are three words: kStateWords in bindings.h.
// Whoever includes this says before how a path is extended (plain.glsl, guided.glsl).
layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform PushBlock
{
    BounceBatch push;
};

layout(set = kSetKernel, binding = kBindStateTexels) uniform usamplerBuffer stateWords;

layout(set = kSetKernel, binding = kBindStates, scalar) writeonly buffer StateBlock
{
    uvec4 nextStates[];
};

layout(set = kSetKernel, binding = kBindQueues, scalar) buffer QueueBlock
{
    QueueHead queues[];
};

#include "queue.glsl"

/// Words of a path's state.
uint stateSize()
{
    return FEATURE(kFeaturePanes | kFeatureSkyRegions | kFeatureVolume) ? kStateWords : 3u;
}

void main()
{
    const uint index = gl_GlobalInvocationID.x;
    const bool first = push.begins != 0u;
    const uint waiting = first ? laneCount(push.batch) : queues[push.queue].count;
    bool alive = index < waiting;
    uint lane = index;
    PathState path;
    SampleStream stream;
    PathExtra extra;
    if (alive) {
        if (first) {
            const uvec2 pixel = lanePixel(push.batch, lane);
            alive = insideImage(pixel);
            stream = laneStream(push.batch, lane, pixel);
            path = beginPath(frame.camera, frame.settings, pixel, stream);
            extra = beginExtra(stream.pixel);
        } else {
            const uvec4 a = texelFetch(stateWords, int(stateSize() * index));
            const uvec4 b = texelFetch(stateWords, int(stateSize() * index + 1u));
            const uvec4 c = texelFetch(stateWords, int(stateSize() * index + 2u));
            lane = a.w & ((1u << kStateLaneBits) - 1u);
            stream = laneStream(push.batch, lane, lanePixel(push.batch, lane));
            path = PathState(uintBitsToFloat(a.xyz), uintBitsToFloat(b.xyz), uintBitsToFloat(c.xyz),
                             uintBitsToFloat(b.w), a.w >> kStateLaneBits, c.w, 0.0, 0u, kNone);
            if (stateSize() > 3u) {
                const uvec4 d = texelFetch(stateWords, int(stateSize() * index + 3u));
                path.passed = uintBitsToFloat(d.x);
                path.skyRegion = d.y;
                path.medium = d.z;
            }
            extra = loadExtra(lane);
        }
    }
    const uint closestRays = subgroupAdd(alive ? 1u : 0u);
    uint shadowRays = 0u;
    if (alive) {
        // A path's sum starts at zero in its first bounce and is touched again only by what brings light. It goes
        // on from the stored value so that the order of additions is that of the megakernel.
        vec3 L = first ? vec3(0.0) : radiance[lane].xyz;
        const vec3 before = L;
        alive = extendLane(lane, stream, path, extra, L, shadowRays);
        if (first || any(notEqual(L, before))) radiance[lane] = vec4(L, 0.0);
    }
    const uint slot = queueSlot(alive, push.queue + 1u);
    if (alive) {
        nextStates[stateSize() * slot] =
            uvec4(floatBitsToUint(path.origin), lane | (path.depth << kStateLaneBits));
        nextStates[stateSize() * slot + 1u] = uvec4(floatBitsToUint(path.direction), floatBitsToUint(path.pdf));
        nextStates[stateSize() * slot + 2u] = uvec4(floatBitsToUint(path.beta), path.departure);
        if (stateSize() > 3u)
            nextStates[stateSize() * slot + 3u] = uvec4(floatBitsToUint(path.passed), path.skyRegion, path.medium, 0u);
        storeExtra(lane, extra);
    }
    shadowRays = subgroupAdd(shadowRays);
    if (subgroupElect()) {
        atomicAdd(counters.closestRays, closestRays);
        atomicAdd(counters.shadowRays, shadowRays);
    }
}
