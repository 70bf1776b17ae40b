// What the ray through a pixel's centre shows: its first hit or, where that is clear glass, a pane
// or a mirror, what appears in it. Flat ones show everything where it appears to be, with its
// normals as they appear; curved ones bend it.
#ifndef REKINDLE_SHARED_SEEN_H
#define REKINDLE_SHARED_SEEN_H

#include "delta.h"
#include "first_hit.h"
#include "path_state.h"

SHARED_BEGIN

SHARED_CONST uint kMostSeenThrough = 6u;
// By how many times more light has to come one way than the other: what a pixel shows is then the
// edges and textures of one.
SHARED_CONST float kSeenClearly = 4.0f;

/// The way from the camera to what is seen, as far as it is known.
struct SeenWay {
    vec3 origin;
    vec3 direction;  // unit
    float distance;  // up to the origin
    vec3 beta;       // what light counts that comes this way
    vec3 emission;   // of the surfaces on the way, as the camera sees it
    mat3 turn;       // takes normals to where they appear
    uint surfaces;   // on the way
    uint medium;     // mediumBehind
};

SHARED_FN SeenWay seenAlong(vec3 origin, vec3 direction)
{
    SeenWay way;
    way.origin = origin;
    way.direction = direction;
    way.distance = 0.0f;
    way.beta = vec3(1.0f);
    way.emission = vec3(0.0f);
    way.turn = mat3(1.0f);
    way.surfaces = 0u;
    way.medium = kNone;
    return way;
}

/// Reflection at a plane.
SHARED_FN mat3 mirrorAt(vec3 normal)
{
    return mat3(vec3(1.0f, 0.0f, 0.0f) - 2.0f * normal.x * normal,
                vec3(0.0f, 1.0f, 0.0f) - 2.0f * normal.y * normal,
                vec3(0.0f, 0.0f, 1.0f) - 2.0f * normal.z * normal);
}

/// Of a way that has left the scene.
SHARED_FN FirstHit seenNothing(IN(SceneView) scene, PathSettings settings, IN(SeenWay) way)
{
    FirstHit found = noFirstHit(scene, settings, way.direction);
    found.emission = way.emission + way.beta * found.emission;
    return found;
}

/// Where a way meets a surface.
struct Arrival {
    SurfacePoint surface;
    Bsdf bsdf;
    vec3 wo;  // in its frame
    uint flags;
};

/// The hit of a way's ray as it is seen.
SHARED_FN FirstHit arriveAt(IN(SceneView) scene, Hit hit, INOUT(SeenWay) way, OUT(Arrival) at)
{
    SurfacePoint s = makeSurfacePoint(scene, hit, way.direction);
    const Shading shading = evaluateMaterial(scene, s, way.direction);
    at.surface = s;
    at.bsdf = makeBsdf(shading.inputs);
    at.wo = toLocal(s.frame, -way.direction);
    at.flags = shading.inputs.flags;
    if (FEATURE(kFeatureVolume)) way.beta *= transmittanceTo(scene, s, at.flags, hit.t, way.medium);
    way.distance += hit.t;
    way.emission += way.beta * shading.emission;
    FirstHit found = firstHitOf(s, shading, at.bsdf, at.wo);
    found.depth = way.distance;
    found.normal = way.turn * found.normal;
    found.albedo *= way.beta;
    found.emission = way.emission;
    return found;
}

/// Whether something else may be seen there: the cheap part of goesOn.
SHARED_FN bool mayGoOn(IN(Arrival) at)
{
    return FEATURE(kFeatureDelta) && isDelta(at.bsdf) && (at.flags & kMaterialUnlit) == 0u;
}

/// Whether a way goes on from where it has arrived: then its next ray tells what is seen.
SHARED_FN bool goesOn(IN(Arrival) at, INOUT(SeenWay) way)
{
    if (!mayGoOn(at) || way.surfaces == kMostSeenThrough) return false;
    const SurfacePoint s = at.surface;
    const DeltaWays ways = deltaWays(at.bsdf, at.wo);
    const bool reflects = maxComponent(ways.reflected) > maxComponent(ways.through);
    const vec3 taken = reflects ? ways.reflected : ways.through;
    const vec3 other = reflects ? ways.through : ways.reflected;
    const vec3 wi = reflects ? ways.wiReflected : ways.wiThrough;
    const vec3 direction = toWorld(s.frame, wi);
    float side;
    if (!(maxComponent(taken) > kSeenClearly * maxComponent(other)) ||
        !sideOf(s, direction, wi.z, side))
        return false;
    if (reflects) way.turn = way.turn * mirrorAt(s.frame[2]);
    way.origin = originOnSide(s, side);
    way.direction = direction;
    way.beta *= taken;
    if (!(side > 0.0f)) way.medium = mediumBehind(way.medium, s, at.bsdf);
    ++way.surfaces;
    return true;
}

SHARED_END

#endif
