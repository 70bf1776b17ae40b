// First hits of the pixels of some tiles, and backprojection: which pixel of the frame before has the history of each.
// The pixel's last word holds that pixel (kNoSource: there is none) until reuse_old puts its history there. Mirrors and
// glass are looked through.
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
    WaitingHead waitingHead;
};

layout(set = kSetKernel, binding = kBindFirstNew, scalar) writeonly buffer FirstNewBlock
{
    uvec2 firstNew[];
};

layout(set = kSetKernel, binding = kBindMeansBefore) uniform samplerBuffer meansBefore;

layout(set = kSetKernel, binding = kBindChainsNow, scalar) writeonly buffer ChainsNowBlock
{
    uvec4 chainsNow[];
};

/// The first of nine pixels whose first hit belongs to the surface at s; kNoSource where there is none.
/// What is seen through curved glass is not where a camera would see it without: it may be far away on the same
/// surface. `piece`: the moved one that the surface belongs to.
uint findSource(CameraData cameraBefore, ReuseChain chain, SurfacePoint s, uint piece, SampleStream stream)
{
    const ivec2 size = ivec2(sizeBefore());
    vec2 film;
    if (!projectToFilm(cameraBefore, vec2(size), s.position, film)) return kNoSource;
    const float away = length(s.position - cameraBefore.position);
    float reach = kInfinity;
    if (chain.bounces > 0u) reach = reachOfHistory(cameraBefore, float(size.y), away, chain.direction, s.normal);
    const vec2 xi = tapNumbers(push.settings, stream, magnified());
    const ivec2 middle = historyPixelOf(size, film, xi, magnified());
    if (!isPixelOf(size, middle)) return kNoSource;
    for (uint k = 0u; k < 9u; ++k) {
        const ivec2 at = middle + historyOffset(k);
        if (!isPixelOf(size, at)) continue;
        const uint source = uint(at.y * size.x + at.x);
        if (historyFits(scene, push.settings, cameraBefore, loadPixelBefore(source), s, piece, away, reach))
            return source;
    }
    return kNoSource;
}

/// Mean deviation of the pixels around one of the frame before.
float deviationAround(uint source)
{
    const ivec2 size = ivec2(sizeBefore());
    const ivec2 middle = ivec2(int(source) % size.x, int(source) / size.x);
    float sum = 0.0;
    float count = 0.0;
    for (uint k = 0u; k < 9u; ++k) {
        const ivec2 at = middle + historyOffset(k);
        if (!isPixelOf(size, at)) continue;
        const vec4 map = texelFetch(meansBefore, at.y * size.x + at.x);
        const float deviation = unpackReuseMap(map, push.settings.strategy).deviation;
        if (!(deviation >= 0.0)) continue;
        sum += deviation;
        count += 1.0;
    }
    return count > 0.0 ? sum / count : kNoDeviation;
}

/// How many new paths the pixel takes that sees a surface in `direction`; `credit` becomes what it keeps.
uint pathsOf(uint source, vec3 direction, vec3 towardsBefore, SampleStream stream, out float credit)
{
    ReuseHistory h = noHistory();
    h.credit = firstCredit(stream);
    float turned = 0.0;
    float part = 1.0;
    if (source != kNoSource) {
        h = unpackHistory(texelFetch(pixelsBefore, int(source)).w);
        turned = length(-direction - towardsBefore);
        if (allocatesPaths(push.settings)) {
            const float deviation = deviationAround(source);
            part = allocatedPart(push.settings, waitingHead.perDeviation, deviation);
            if (deviation >= 0.0) atomicAdd(counters.deviations[deviationBin(deviation)], 1u);
        }
    }
    const uint taken = takeRays(push.settings, raysDue(push.settings, h, turned) * part, h);
    credit = h.credit;
    return taken;
}

/// Lets a pixel wait for `count` new paths and, perhaps, one more for a way not taken; returns the number of the first.
uint waitForPaths(uint lane, uint count, bool rest)
{
    const uint places = placesFor(count);
    const uint its = places + (rest ? 1u : 0u);
    const uint before = subgroupExclusiveAdd(its);
    const uint all = subgroupAdd(its);
    uint base = 0u;
    if (subgroupElect()) {
        base = atomicAdd(waitingHead.queue.count, all);
        atomicMax(waitingHead.queue.groupsX, (base + all + kGroupSize - 1u) / kGroupSize);
    }
    const uint first = subgroupBroadcastFirst(base) + before;
    for (uint i = 0u; i < places; ++i) waiting[first + i] = packWaiting(lane, i);
    if (rest) waiting[first + places] = packWaiting(lane, kRestPath);
    return first;
}

void main()
{
    uint lane;
    uvec2 pixel;
    const bool inside = lanesPixel(lane, pixel);
    uint count = 0u;  // of new paths
    bool rest = false;
    float credit = 0.0;
    ReuseTally tally = ReuseTally(inside ? 1u : 0u, 0u);
    if (inside) {
        const SampleStream stream = pixelStream(pixel);
        const PathState ray = pixelRay(frame.camera, frame.settings, push.settings, pixel, stream);
        Hit hit;
        if (!traceWay(scene, ray.origin, ray.direction, alphaSeed(stream, 0u, 0u), hit)) hit = Hit(0.0, vec2(0.0), kNone);
        ReusePixel here = firstHitAt(scene, hit);
        CameraData cameraBefore = push.cameraBefore;
        ReuseChain chain = noChain(ray.direction);
        if (FEATURE(kFeatureDelta)) {
            chain = followChain(scene, frame.settings, push.settings, ray, hit.t, stream, here, cameraBefore, tally);
            if (chain.bounces > 0u) {
                for (uint i = 0u; i < kReuseChainWords; ++i)
                    chainsNow[kReuseChainWords * lane + i] = packChain(chain, i);
            }
            rest = chain.restBounces > 0u;
        }
        uvec4 words = packReusePixel(here);
        words.w = kNoSource;
        if (here.slot != kNone) {
            const SurfacePoint s = makeSurfacePoint(scene, Hit(0.0, here.barycentrics, here.slot), chain.direction);
            const SurfaceMotion motion = motionOf(here);
            if (chain.bounces == 0u) {
                cameraBefore = movedCamera(cameraBefore, motion);
                chain.towardsBefore = towardsCamera(cameraBefore, s.position);
            }
            if (cameraBefore.tanHalfHeight > 0.0) words.w = findSource(cameraBefore, chain, s, motion.piece, stream);
            count = pathsOf(words.w, chain.direction, chain.towardsBefore, stream, credit);
        }
        if (chain.bounces > 0u) words.w |= kChained;
        pixelsNow[pixelIndex(pixel)] = words;
    }
    const uint first = waitForPaths(lane, count, rest);
    if (inside) firstNew[lane] = uvec2(first | (rest ? 0x80000000u : 0u), count | (packCredit(credit) << 16u));
    const uint rays = subgroupAdd(tally.closestRays);
    if (subgroupElect()) atomicAdd(counters.closestRays, rays);
}
