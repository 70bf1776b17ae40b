// What the kernels of sample reuse share: a lane is a pixel, or one of its new paths (reuse_paths.glsl), and each
// kernel adds to what the one before has left for it. The estimator is that of shared/reuse_new.h.
#include "panes.glsl"
#include "shared/reuse_new.h"

layout(constant_id = kSpecializeSampler) const uint kSampler = 0u;

layout(push_constant, scalar) uniform PushBlock
{
#ifdef REKINDLE_BOUNCES
    ReuseBounceBatch push;
#else
    ReuseBatch push;
#endif
};

layout(set = kSetKernel, binding = kBindPixelsNow, scalar) buffer PixelsNowBlock
{
    uvec4 pixelsNow[];
};

// What the frame before has left lies in texels: on software devices a fetch is much faster than a load from a buffer.
layout(set = kSetKernel, binding = kBindPixelsBefore) uniform usamplerBuffer pixelsBefore;

// Pieces that have moved (shared/motion.h), where the triangles of the hierarchy's moving part were, and the slot in
// which each of these lies now: a part that is built anew has others.
layout(set = kSetKernel, binding = kBindMovedPieces) uniform usamplerBuffer movedPieceWords;
layout(set = kSetKernel, binding = kBindTrianglesBefore) uniform samplerBuffer trianglesBefore;
layout(set = kSetKernel, binding = kBindSlotsNow) uniform usamplerBuffer slotsNow;

MovedPiece fetchMovedPiece(SceneView view, uint i)
{
    const uvec4 low = texelFetch(movedPieceWords, int(kMovedPieceWords * i));
    const uvec4 high = texelFetch(movedPieceWords, int(kMovedPieceWords * i + 1u));
    return MovedPiece(uintBitsToFloat(low.xyz), low.w, uintBitsToFloat(high.xyz), high.w);
}

Triangle fetchTriangleBefore(SceneView view, uint slot)
{
    const int at = int(3u * slot);
    return Triangle(texelFetch(trianglesBefore, at), texelFetch(trianglesBefore, at + 1),
                    texelFetch(trianglesBefore, at + 2));
}

/// The slot of a triangle that was in `slot` in the frame before.
uint slotNow(uint slot)
{
    if (movedPieces(push.settings) == 0u || slot >= uint(textureSize(slotsNow))) return slot;
    return texelFetch(slotsNow, int(slot)).x;
}

ReusePixel loadPixelBefore(uint source)
{
    ReusePixel before = unpackReusePixel(texelFetch(pixelsBefore, int(source)));
    before.slot = slotNow(before.slot);
    return before;
}

bool traceWay(SceneView view, vec3 origin, vec3 direction, uint seed, out Hit hit)
{
    return traceClosest(Ray(origin, 0.0, direction, kInfinity), seed, hit);
}

bool wayIsOpen(SceneView view, inout ShadowRay shadow, uint seed, inout ReuseTally tally)
{
    ++tally.shadowRays;
    Hit hit;
    if (!traceAnyHit(Ray(shadow.origin, 0.0, shadow.direction, shadow.tMax), seed, hit)) return true;
#ifdef REKINDLE_PANES
    return shadow.passes > 0u && comesThrough(hit.slot, seed, shadow, tally.shadowRays);
#else
    return false;
#endif
}

/// The pixel of this lane; false where it has none.
bool lanesPixel(out uint lane, out uvec2 pixel)
{
    lane = gl_GlobalInvocationID.x;
    pixel = uvec2(0u);
    if (lane >= push.batch.tileCount * kGroupSize) return false;
    pixel = lanePixel(push.batch, lane);
    return insideImage(pixel);
}

SampleStream pixelStream(uvec2 pixel)
{
    return makeStream(kSampler, frame.settings.seed, pixel, push.batch.firstSample, kPurposePath);
}

/// How the surface at a first hit has moved since the frame before.
SurfaceMotion motionOf(ReusePixel here)
{
    return motionAt(scene, movedPieces(push.settings), here.slot, here.barycentrics);
}

/// Of the picture that left the history.
uvec2 sizeBefore()
{
    return uvec2((push.settings.sizeBefore & 0xffffu) + 1u, (push.settings.sizeBefore >> 16u) + 1u);
}

/// Pixels of this picture for each of the one that left the history.
float magnified()
{
    const vec2 before = vec2(sizeBefore());
    return float(frame.settings.imageWidth) * float(frame.settings.imageHeight) / (before.x * before.y);
}

/// Where record `i` of a pixel lies in a store of a picture of that size: neighbours side by side.
uint recordIndex(uvec2 size, uint pixel, uint i)
{
    return i * size.x * size.y + pixel;
}

// The last word of a pixel, while a pass runs: the pixel of the frame before that has its history.
const uint kNoSource = 0x7fffffffu;
const uint kChained = 0x80000000u;  // its first hit is seen over mirrors or through glass

// The number of a path that follows a way which mirrors and glass have not taken.
const uint kRestPath = 0xffffu;

/// Places in `waiting` for so many new paths of a pixel: of `full` one for each chunk of them.
uint placesFor(uint paths)
{
    const uint chunk = push.settings.strategy == kReuseFull ? pathsOfChunk(push.settings) : 1u;
    return (paths + chunk - 1u) / chunk;
}

/// What waits for new paths: its lane, and the number of the path; of `full` that of the chunk, whose paths are taken
/// one after the other.
uint packWaiting(uint lane, uint which)
{
    return lane | (which << 16u);
}

#ifdef REKINDLE_READS_CHAINS
layout(set = kSetKernel, binding = kBindChains) uniform usamplerBuffer chains;

ReuseChain loadChain(uint lane)
{
    const int at = int(kReuseChainWords * lane);
    return unpackChain(texelFetch(chains, at), texelFetch(chains, at + 1), texelFetch(chains, at + 2),
                       texelFetch(chains, at + 3), texelFetch(chains, at + 4));
}

/// The first hit of a pixel, the way to it, and what is seen on it, in L. False where nothing is scattered. `path`
/// becomes what paths from there may do.
bool firstVertex(uvec2 pixel, uint lane, SampleStream stream, uvec4 here, inout PathSettings path, out ReuseVertex v,
                 out vec3 towardsBefore, inout vec3 L)
{
    PathState ray = pixelRay(frame.camera, path, push.settings, pixel, stream);
    const ReusePixel found = unpackReusePixel(here);
    uint bounces = 0u;
    towardsBefore = vec3(0.0);
    if (FEATURE(kFeatureDelta) && (here.w & kChained) != 0u) {
        const ReuseChain chain = loadChain(lane);
        ray = rayOfChain(scene, chain, found);
        towardsBefore = chain.towardsBefore;
        bounces = chain.bounces;
        L += chain.seen;
    }
    const bool scatters = beginReuse(scene, path, ray, found, v, L);
    if (bounces == 0u && found.slot != kNone) {
        const CameraData cameraBefore = movedCamera(push.cameraBefore, motionOf(found));
        towardsBefore = towardsCamera(cameraBefore, v.vertex.surface.position);
    }
    path = settingsAfter(path, bounces);
    return scatters;
}

/// Takes over the history of the pixel that the last word of `here` names, but for its credit; false where there is
/// none.
bool lookBack(uvec4 here, vec3 towardsBefore, inout ReuseVertex v)
{
    const uint source = here.w & ~kChained;
    if (source == kNoSource) {
        v.rays = raysDue(push.settings, v.history, 0.0);
        return false;
    }
    takeHistory(scene, push.settings, towardsBefore, loadPixelBefore(source), motionOf(unpackReusePixel(here)), v);
    return true;
}
#endif
