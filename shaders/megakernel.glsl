// One lane, one whole path: least traffic, but lanes wait for the longest path of their group.
// Whoever includes this says before how a path is extended (plain.glsl, guided.glsl).
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
        PathExtra extra = beginExtra(stream.pixel);
        vec3 L = vec3(0.0);
        bool goesOn;
        do {
            ++closestRays;
            goesOn = extendLane(lane, stream, path, extra, L, shadowRays);
        } while (goesOn);
        if (goesOn) atomicAdd(counters.cutRays, 1u);  // a device may leave any loop: traverse.glsl
        radiance[lane] = vec4(L, 0.0);
    }
    closestRays = subgroupAdd(closestRays);
    shadowRays = subgroupAdd(shadowRays);
    if (subgroupElect()) {
        atomicAdd(counters.closestRays, closestRays);
        atomicAdd(counters.shadowRays, shadowRays);
    }
}
