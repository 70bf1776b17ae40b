// First hits of the pixels of some tiles, and backprojection: which pixel of the frame before has the history of each.
// The pixel's last word holds that pixel (kNone: there is none) until reuse_old puts the history's length there.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_basic : require

#include "reuse.glsl"

layout(local_size_x = 64) in;

layout(set = kSetKernel, binding = kBindWaiting, scalar) writeonly buffer WaitingBlock
{
    uint waiting[];
};

layout(set = kSetKernel, binding = kBindWaitingHead, scalar) buffer WaitingHeadBlock
{
    QueueHead waitingHead;
};

layout(set = kSetKernel, binding = kBindFirstNew, scalar) writeonly buffer FirstNewBlock
{
    uint firstNew[];
};

/// The first of nine pixels whose first hit belongs to the surface at s; kNone where there is none.
uint findSource(SurfacePoint s, SampleStream stream)
{
    const ivec2 size = ivec2(sizeBefore());
    vec2 film;
    if (!projectToFilm(push.cameraBefore, vec2(size), s.position, film)) return kNone;
    const float away = length(s.position - push.cameraBefore.position);
    const ivec2 middle = historyPixel(push.settings.strategy, film, tapNumbers(stream));
    for (uint k = 0u; k < 9u; ++k) {
        const ivec2 at = middle + historyOffset(k);
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) continue;
        const uint source = uint(at.y * size.x + at.x);
        vec3 position;
        const ReusePixel before = unpackReusePixel(texelFetch(pixelsBefore, int(source)));
        if (historyFits(scene, push.cameraBefore, before, s, away, position)) return source;
    }
    return kNone;
}

/// How many new paths the pixel takes that sees the surface at s.
uint pathsOf(uint source, SurfacePoint s, SampleStream stream)
{
    ReuseHistory h = noHistory();
    h.credit = firstCredit(stream);
    float turned = 0.0;
    if (source != kNone) {
        h = unpackHistory(texelFetch(pixelsBefore, int(source)).w);
        turned = length(towardsCamera(frame.camera, s.position) - towardsCamera(push.cameraBefore, s.position));
    }
    return raysTaken(h, raysDue(push.settings, h, turned));
}

/// Lets a pixel wait for `count` new paths; returns the number of the first.
uint waitForPaths(uint pixel, uint count)
{
    const uint before = subgroupExclusiveAdd(count);
    const uint all = subgroupAdd(count);
    uint base = 0u;
    if (subgroupElect()) {
        base = atomicAdd(waitingHead.count, all);
        atomicMax(waitingHead.groupsX, (base + all + kGroupSize - 1u) / kGroupSize);
    }
    const uint first = subgroupBroadcastFirst(base) + before;
    for (uint i = 0u; i < count; ++i) waiting[first + i] = pixel | (i << 30u);
    return first;
}

void main()
{
    uint lane;
    uvec2 pixel;
    const bool inside = lanesPixel(lane, pixel);
    uint count = 0u;  // of new paths
    uint alone = 0u;  // a path that meets nothing
    if (inside) {
        const SampleStream stream = pixelStream(pixel);
        const PathState ray = pixelRay(frame.camera, frame.settings, push.settings, pixel, stream);
        const ReusePixel here = findFirstHit(scene, ray, stream);
        uvec4 words = packReusePixel(here);
        words.w = kNone;
        alone = here.slot == kNone ? 1u : 0u;
        if (here.slot != kNone) {
            const SurfacePoint s = makeSurfacePoint(scene, Hit(0.0, here.barycentrics, here.slot), ray.direction);
            if (push.cameraBefore.tanHalfHeight > 0.0) words.w = findSource(s, stream);
            count = pathsOf(words.w, s, stream);
        }
        pixelsNow[pixelIndex(pixel)] = words;
    }
    const uint first = waitForPaths(inside ? pixelIndex(pixel) : 0u, count);
    if (inside) firstNew[lane] = first;
    const uint rays = subgroupAdd(inside ? 1u : 0u);
    const uint paths = subgroupAdd(count + alone);
    if (subgroupElect()) {
        atomicAdd(counters.closestRays, rays);
        atomicAdd(counters.newPaths, paths);
    }
}
