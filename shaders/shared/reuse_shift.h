// How an old sample that has a place (keepsDirections) is carried along when its first hit has
// moved. It slides: the direction that it came from stays, and its place is where that now meets
// the plane of the same triangle, or of its surroundings about as large. The move is what is left
// of rounding to pixels, so places do not wander, and nothing changes of what decides over noise:
// the density of the direction at the first hit, and the direction in which the place is left. Or
// it is reconnected, where it would slide farther and where nothing may be approximated: the place
// stays (Kettunen et al., "Gradient-Domain Path Tracing", 2015), which is exact, but from a corner
// of a room each place is seen under quite another solid angle than before, and a narrow lobe at
// either end is left at another point of it.
//
// Measured, squared error over that of Discard, reconnection alone against this, boxes at 1 degree
// a frame: .067 and .045 (diffuse), .139 and .07 to .08 (moderate), 1.2 and .30 (glossy,
// fireflies); in the corners of the room a third to a quarter, and less of a bias. A kitchen of
// 10^6 triangles, without fireflies: .26 and .17; where places had to stay on their triangles, as
// without.
#ifndef REKINDLE_SHARED_REUSE_SHIFT_H
#define REKINDLE_SHARED_REUSE_SHIFT_H

#include "instances.h"
#include "reuse_records.h"

SHARED_BEGIN

// Where an old sample may be reconnected: no nearer than this part of the way that the first hit
// has gone, and where its place does not all but vanish. What fails is left to new samples, on both
// sides alike.
SHARED_CONST float kReuseNearest = 0.5f;
SHARED_CONST float kReuseMostStretch = 11.0f;

/// How much an old sample whose place has normal n may count when it is looked at from `position`
/// instead of `positionBefore`: 0 where it may not, and less than 1 where its place fills a larger
/// solid angle now, so that no weight grows by the change.
SHARED_FN float reconnection(vec3 toPlace, vec3 n, vec3 position, vec3 positionBefore)
{
    const vec3 moved = position - positionBefore;
    const vec3 toPlaceBefore = toPlace + moved;
    const float d2 = dot(toPlace, toPlace);
    const float before2 = dot(toPlaceBefore, toPlaceBefore);
    if (!(min(d2, before2) > kReuseNearest * kReuseNearest * dot(moved, moved))) return 0.0f;
    // cos' / d'^2 over cos / d^2; the signs must agree, too: the other side is another surface
    const float now = dot(toPlace, n) * before2 * sqrt(before2);
    const float then = dot(toPlaceBefore, n) * d2 * sqrt(d2);
    if (!(now * then > 0.0f) || abs(then) > kReuseMostStretch * abs(now)) return 0.0f;
    return min(abs(then) / abs(now), 1.0f);
}

/// Where a ray from `origin` meets the plane of a triangle: after how many lengths of `direction`,
/// and at which barycentrics. False where that is farther beyond the triangle than can be stored.
SHARED_FN bool meetsPlane(Triangle t, vec3 origin, vec3 direction, OUT(float) distance,
                          OUT(vec2) barycentrics)
{
    const vec3 e1 = xyz(t.v1) - xyz(t.v0);
    const vec3 e2 = xyz(t.v2) - xyz(t.v0);
    const vec3 s = origin - xyz(t.v0);
    const vec3 p = cross(direction, e2);
    const vec3 q = cross(s, e1);
    const float determinant = dot(e1, p);
    distance = 0.0f;
    barycentrics = vec2(0.0f);
    if (!(abs(determinant) > 1.0e-30f)) return false;
    const float scale = 1.0f / determinant;
    distance = dot(e2, q) * scale;
    barycentrics = vec2(dot(s, p), dot(direction, q)) * scale;
    return min(barycentrics.x, barycentrics.y) >= kPlaceLow &&
           max(barycentrics.x, barycentrics.y) < kPlaceLow + kPlaceRange && distance > 0.0f &&
           distance < kInfinity;
}

/// Lets a sample slide whose place is `way` from the first hit's new position, on triangle t: moves
/// the place and `way` to where they are seen in the old direction; the weight per solid angle
/// stays. False where nothing has moved or the place would be too far beyond its triangle.
SHARED_FN bool slidePlace(Triangle t, vec3 position, vec3 positionBefore, INOUT(vec3) way,
                          INOUT(ReuseSample) r)
{
    const vec3 moved = position - positionBefore;
    if (!(dot(moved, moved) > 0.0f)) return false;
    float lengths;
    vec2 barycentrics;
    if (!meetsPlane(t, position, way + moved, lengths, barycentrics)) return false;
    r.place = packPlace(barycentrics);
    r.u *= lengths * lengths;  // per area: what it is per solid angle stays
    way = lengths * (way + moved);
    return true;
}

/// Whether a sample whose place is `way` from the first hit's new position, on triangle t, is one
/// that has slid there; `wayBefore` becomes its way from the old position.
SHARED_FN bool hasSlid(Triangle t, vec3 position, vec3 positionBefore, vec3 way,
                       INOUT(vec3) wayBefore)
{
    const vec3 moved = position - positionBefore;
    if (!(dot(moved, moved) > 0.0f)) return false;
    float lengths;
    vec2 barycentrics;
    if (!meetsPlane(t, positionBefore, way, lengths, barycentrics)) return false;
    wayBefore = lengths * way;
    return true;
}

SHARED_END

#endif
