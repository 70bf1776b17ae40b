// New paths between the kernels of sample reuse. A path is known by its number in `waiting`; what its beginning leaves
// to its end (ReuseTrail) lies there, and what it has gathered. Paths under way are queued, closed up from bounce to
// bounce.
#include "reuse.glsl"

layout(set = kSetKernel, binding = kBindWaiting, scalar) readonly buffer WaitingBlock
{
    uint waiting[];
};

/// The lane of the pixel that a new path is for.
uint laneOfPath(uint number)
{
    return waiting[number] & 0xffffu;
}

/// Which of the pixel's paths it is, or of its chunks; kRestPath: it follows a way that mirrors and glass have not taken.
uint whichOfPath(uint number)
{
    return waiting[number] >> 16u;
}

#ifdef REKINDLE_WRITES_PATHS
layout(set = kSetKernel, binding = kBindTrailsNow, scalar) writeonly buffer TrailBlock
{
    uvec4 trailsNow[];
};

layout(set = kSetKernel, binding = kBindPathStates, scalar) writeonly buffer PathStateBlock
{
    uvec4 nextStates[];
};

layout(set = kSetKernel, binding = kBindPathQueues, scalar) buffer PathQueueBlock
{
    QueueHead queues[];
};

#include "queue.glsl"

const uint kNumberBits = 19u;  // of a path; its depth lies above them
const uint kDepthBits = 6u;    // and above these the settings that it follows
const uint kRestSettings = 31u;  // restSettings; else settingsAfter so many bounces

/// A path under way.
struct PathUnderWay {
    uint number;
    uint settings;
    uint index;        // of its stream
    float importance;  // of its first direction (extendNewPath)
    PathState ray;
};

/// Appends the paths that are `alive` to a queue.
void queuePath(bool alive, uint queue, PathUnderWay path)
{
    const uint to = kReuseStateWords * queueSlot(alive, queue);
    if (!alive) return;
    const PathState ray = path.ray;
    const uint head = path.number | (ray.depth << kNumberBits) | (path.settings << (kNumberBits + kDepthBits));
    nextStates[to] = uvec4(floatBitsToUint(ray.origin), head);
    nextStates[to + 1u] = uvec4(floatBitsToUint(ray.direction), floatBitsToUint(ray.pdf));
    nextStates[to + 2u] = uvec4(floatBitsToUint(ray.beta), ray.departure);
    nextStates[to + 3u] = uvec4(path.index, floatBitsToUint(path.importance), ray.medium, 0u);
}

/// What is known of a path before it has come to its place; `lost` by its connection.
void storeBeginning(uint number, ReuseTrail trail, float lost)
{
    const uint to = kReuseTrailWords * number;
    trailsNow[to] = floatBitsToUint(vec4(trail.direction, trail.pdf));
    trailsNow[to + 1u] = floatBitsToUint(vec4(trail.weight, trail.omega));
    trailsNow[to + 2u] = floatBitsToUint(vec4(trail.mean, trail.alpha, lost, 0.0));
}

/// What the place of a path has left.
void storePlace(uint number, ReuseTrail trail, ReuseSample record)
{
    const uint to = kReuseTrailWords * number + 3u;
    const uint flags = (trail.emits ? 1u : 0u) | (trail.bends ? 2u : 0u);
    trailsNow[to] = uvec4(record.slot, record.place, record.radiance, flags);
    trailsNow[to + 1u] = uvec4(record.lightDirection, record.lightRadiance, record.nextDirection,
                               floatBitsToUint(trail.perGathered));
    trailsNow[to + 2u] = uvec4(floatBitsToUint(trail.emitted), 0u);
    trailsNow[to + 3u] = uvec4(floatBitsToUint(trail.leaving), 0u);
    trailsNow[to + 4u] = uvec4(floatBitsToUint(trail.beyond), 0u);
}
#endif
