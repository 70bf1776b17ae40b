// Mirrors and glass before the first hit. A surface without a density has nothing to reweight; the
// way from the camera is followed to the first surface that has one, by reflection or transmission,
// whichever brings more, and that surface is the pixel's first hit. Of the ways not taken one is
// chosen in proportion to what it may bring, and traced anew in every pass. The camera of the frame
// before is mirrored along: seen from behind flat mirrors and panes the place where it appears to
// be is exact; curved glass bends it, and often finds no history.
#ifndef REKINDLE_SHARED_REUSE_CHAIN_H
#define REKINDLE_SHARED_REUSE_CHAIN_H

#include "delta.h"
#include "reuse_visibility.h"

SHARED_BEGIN

SHARED_CONST uint kReuseMostChain = 8u;

/// The way from the camera to the first hit, and a way not taken.
struct ReuseChain {
    vec3 direction;      // in which the first hit is reached
    vec3 towardsBefore;  // from there to where the camera of the frame before appears to be
    vec3 beta;           // what its light counts
    vec3 seen;           // emission on the way
    uint bounces;        // surfaces on the way; 0: the camera sees the first hit
    uint restBounces;    // the same of the way not taken; 0: there is none
    vec3 restOrigin;
    vec3 restDirection;
    vec3 restBeta;
    uint medium;  // through which the first hit is reached
    uint restMedium;
};
SHARED_CONST uint kReuseChainWords = 5u;

SHARED_FN ReuseChain noChain(vec3 direction)
{
    ReuseChain chain;
    chain.direction = direction;
    chain.towardsBefore = vec3(0.0f);
    chain.beta = vec3(1.0f);
    chain.seen = vec3(0.0f);
    chain.bounces = 0u;
    chain.restBounces = 0u;
    chain.restOrigin = vec3(0.0f);
    chain.restDirection = vec3(0.0f);
    chain.restBeta = vec3(0.0f);
    chain.medium = kNone;
    chain.restMedium = kNone;
    return chain;
}

/// Word `i` of a chain as one kernel leaves it to the next.
SHARED_FN uvec4 packChain(ReuseChain c, uint i)
{
    if (i == 0u)
        return uvec4(packOct(c.direction), packOct(c.towardsBefore), c.bounces, c.restBounces);
    vec3 v = c.beta;
    uint word = c.medium;
    if (i == 2u) {
        v = c.seen;
        word = c.restMedium;
    } else if (i == 3u) {
        v = c.restOrigin;
        word = packOct(c.restDirection);
    } else if (i == 4u) {
        v = c.restBeta;
        word = 0u;
    }
    return packVector(v, word);
}

SHARED_FN ReuseChain unpackChain(uvec4 word0, uvec4 word1, uvec4 word2, uvec4 word3, uvec4 word4)
{
    ReuseChain c;
    c.direction = unpackOct(word0.x);
    c.towardsBefore = unpackOct(word0.y);
    c.bounces = word0.z;
    c.restBounces = word0.w;
    c.beta = unpackVector(word1);
    c.medium = word1.w;
    c.seen = unpackVector(word2);
    c.restMedium = word2.w;
    c.restOrigin = unpackVector(word3);
    c.restDirection = unpackOct(word3.w);
    c.restBeta = unpackVector(word4);
    return c;
}

/// A way that leaves a vertex without density.
struct ReuseWay {
    vec3 direction;
    vec3 beta;  // zero: there is none
    float side;
};

SHARED_FN ReuseWay wayOf(IN(Vertex) vertex, vec3 wi, vec3 beta)
{
    ReuseWay way;
    way.direction = toWorld(vertex.surface.frame, wi);
    way.beta = sideOf(vertex.surface, way.direction, wi.z, way.side) ? beta : vec3(0.0f);
    return way;
}

/// Follows the ray of a pixel, whose first hit is `pixel` at distance `t`, to the first surface
/// that has a density: `pixel` becomes the hit there, or none. `cameraBefore` becomes where that
/// of the frame before appears to be from there, and nothing where a mirror or a pane has moved.
SHARED_FN ReuseChain followChain(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                                 PathState ray, float t, SampleStream stream,
                                 INOUT(ReusePixel) pixel, INOUT(CameraData) cameraBefore,
                                 INOUT(ReuseTally) tally)
{
    ReuseChain chain = noChain(ray.direction);
    const SampleStream selection = decisionStream(stream, kPurposeSelection);
    float sum = 0.0f;  // of what the ways not taken may bring
    while (pixel.slot != kNone && chain.bounces < kReuseMostChain) {
        Hit hit;
        hit.slot = pixel.slot;
        hit.barycentrics = pixel.barycentrics;
        hit.t = t;
        Vertex vertex;
        vec3 seen = vec3(0.0f);
        const bool scatters = prepareVertex(scene, path, hit, ray, vertex, seen);
        if (!scatters || !isDelta(vertex.bsdf)) break;
        const DeltaWays ways = deltaWays(vertex.bsdf, vertex.wo);
        const ReuseWay reflected = wayOf(vertex, ways.wiReflected, ray.beta * ways.reflected);
        const ReuseWay through = wayOf(vertex, ways.wiThrough, ray.beta * ways.through);
        const bool reflects = maxComponent(reflected.beta) >= maxComponent(through.beta);
        ReuseWay taken = through;
        ReuseWay other = reflected;
        if (reflects) {
            taken = reflected;
            other = through;
            cameraBefore =
                mirroredCamera(cameraBefore, vertex.surface.position, vertex.surface.frame[2]);
        }
        if (!(maxComponent(taken.beta) > 0.0f)) break;
        chain.seen += seen;
        ++chain.bounces;
        if (movedPieceOf(scene, movedPieces(settings), vertex.surface.triangle) != kNone)
            cameraBefore.tanHalfHeight = 0.0f;
        const float weight = maxComponent(other.beta);
        sum += weight;
        if (weight > 0.0f && streamFloat(selection, 48u + chain.bounces) * sum < weight) {
            chain.restBounces = chain.bounces;
            chain.restOrigin = originOnSide(vertex.surface, other.side);
            chain.restDirection = other.direction;
            chain.restBeta = other.beta / weight;
            chain.restMedium = mediumBeyond(ray.medium, vertex, other.side);
        }
        ray.origin = originOnSide(vertex.surface, taken.side);
        ray.direction = taken.direction;
        ray.beta = taken.beta;
        ray.depth = chain.bounces;
        ray.medium = mediumBeyond(ray.medium, vertex, taken.side);
        ++tally.closestRays;
        pixel.slot = kNone;
        if (traceWay(scene, ray.origin, ray.direction, alphaSeed(stream, 128u + chain.bounces, 0u),
                     hit)) {
            pixel.slot = hit.slot;
            pixel.barycentrics = hit.barycentrics;
            t = hit.t;
        }
    }
    if (chain.bounces == 0u) return chain;
    // The last way of one that is too long has not been looked at.
    if (chain.bounces == kReuseMostChain && pixel.slot != kNone)
        ray.beta *= transmittance(scene, ray.medium, t);
    // as it is packed, for all who look at it
    chain.direction = unpackOct(packOct(ray.direction));
    chain.beta = ray.beta;
    chain.medium = ray.medium;
    chain.restBeta *= sum;
    if (pixel.slot != kNone) {
        const vec3 position = pointOfTriangle(scene, pixel.slot, pixel.barycentrics);
        cameraBefore = movedCamera(
            cameraBefore, motionAt(scene, movedPieces(settings), pixel.slot, pixel.barycentrics));
        chain.towardsBefore = unpackOct(packOct(towardsCamera(cameraBefore, position)));
    }
    return chain;
}

/// The ray that reaches the first hit at the end of a chain. What is absorbed on its last way is in
/// its throughput already: it has no length.
SHARED_FN PathState rayOfChain(IN(SceneView) scene, ReuseChain chain, ReusePixel pixel)
{
    PathState ray = pathAlong(vec3(0.0f), chain.direction);
    if (pixel.slot != kNone) ray.origin = pointOfTriangle(scene, pixel.slot, pixel.barycentrics);
    ray.beta = chain.beta;
    ray.depth = chain.bounces;
    ray.medium = chain.medium;
    return ray;
}

/// What a path may do that has come over so many surfaces to where it counts from zero.
SHARED_FN PathSettings settingsAfter(PathSettings path, uint bounces)
{
    path.maxDepth -= min(bounces, path.maxDepth);
    path.rouletteDepth -= min(bounces, path.rouletteDepth - 1u);
    return path;
}

/// The way not taken, for takeRest: its depth is one more than it is, so that it is not taken for
/// a path from the first hit (restSettings).
SHARED_FN PathState restOfChain(ReuseChain chain)
{
    PathState ray = pathAlong(chain.restOrigin, chain.restDirection);
    ray.beta = chain.restBeta;
    ray.depth = chain.restBounces + 1u;
    ray.medium = chain.restMedium;
    return ray;
}

SHARED_FN PathSettings restSettings(PathSettings path)
{
    ++path.maxDepth;
    ++path.rouletteDepth;
    return path;
}

SHARED_END

#endif
