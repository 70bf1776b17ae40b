// What has moved since the frame before, for methods that keep samples from frame to frame. A place
// on a moved mesh looks back to where the mesh was, as if the camera of the frame before had moved
// along with it. What a moved mesh may have changed is asked of the box that it has swept: ways
// that lead through it are not what they were.
#ifndef REKINDLE_SHARED_MOTION_H
#define REKINDLE_SHARED_MOTION_H

#include "instances.h"
#include "layout.h"

SHARED_BEGIN

SHARED_CONST uint kMostMovedPieces = 16u;
SHARED_CONST uint kMovedPieceWords = 2u;
SHARED_CONST uint kMovedSeveral = 0x80000000u;

/// A mesh that has moved, or a light without triangles: the box around where it was and is, and its
/// triangles, `count` from `first` on in the scene's own numbering. kMovedSeveral in `count`: there
/// are several in one box, each of which may have changed what the others see.
struct MovedPiece {
    vec3 low;
    uint first;
    vec3 high;
    uint count;
};

#ifdef __cplusplus
MovedPiece fetchMovedPiece(const SceneView& scene, uint i);
Triangle fetchTriangleBefore(const SceneView& scene, uint slot);
#else
MovedPiece fetchMovedPiece(SceneView scene, uint i);
/// The triangle of a moved piece where it was in the frame before.
Triangle fetchTriangleBefore(SceneView scene, uint slot);
#endif

/// The first of `pieces` moved ones that a triangle belongs to; kNone: it rests.
SHARED_FN uint movedPieceOf(IN(SceneView) scene, uint pieces, uint triangle)
{
    uint found = kNone;
    for (uint i = 0u; i < pieces; ++i) {
        const MovedPiece piece = fetchMovedPiece(scene, i);
        if (triangle - piece.first < (piece.count & ~kMovedSeveral)) found = min(found, i);
    }
    return found;
}

SHARED_FN vec3 pointOn(Triangle t, vec2 barycentrics)
{
    const vec3 a = xyz(t.v0);
    return a + barycentrics.x * (xyz(t.v1) - a) + barycentrics.y * (xyz(t.v2) - a);
}

/// A point of a triangle.
SHARED_FN vec3 pointOfTriangle(IN(SceneView) scene, uint slot, vec2 barycentrics)
{
    return pointOn(triangleInSlot(scene, slot), barycentrics);
}

/// Along the first edge, across it, along the normal.
SHARED_FN mat3 frameOfTriangle(Triangle t)
{
    const vec3 e1 = xyz(t.v1) - xyz(t.v0);
    const vec3 x = normalize(e1);
    const vec3 z = normalize(cross(e1, xyz(t.v2) - xyz(t.v0)));
    return mat3(x, cross(z, x), z);
}

/// How the surface around a place has moved: what was at `before + d` is at `now + turn * d`. Exact
/// for rigid meshes and for the place itself.
struct SurfaceMotion {
    uint piece;  // kNone: it rests, and the rest is not to be looked at
    vec3 before;
    vec3 now;
    mat3 turn;
};

SHARED_FN SurfaceMotion noMotion()
{
    SurfaceMotion m;
    m.piece = kNone;
    m.before = vec3(0.0f);
    m.now = vec3(0.0f);
    m.turn = mat3(1.0f);
    return m;
}

/// The same at a place of a triangle, where `pieces` have moved.
SHARED_FN SurfaceMotion motionAt(IN(SceneView) scene, uint pieces, uint slot, vec2 barycentrics)
{
    SurfaceMotion m = noMotion();
    if (pieces == 0u) return m;
    const Triangle now = triangleInSlot(scene, slot);
    m.piece = movedPieceOf(scene, pieces, floatAsUint(now.v0.w));
    if (m.piece == kNone) return m;
    const Triangle before = fetchTriangleBefore(scene, slot);
    m.before = pointOn(before, barycentrics);
    m.now = pointOn(now, barycentrics);
    m.turn = frameOfTriangle(now) * transpose(frameOfTriangle(before));
    return m;
}

/// The camera of the frame before as it lies to the surface now.
SHARED_FN CameraData movedCamera(CameraData camera, SurfaceMotion m)
{
    if (m.piece == kNone) return camera;
    camera.position = m.now + m.turn * (camera.position - m.before);
    camera.right = m.turn * camera.right;
    camera.up = m.turn * camera.up;
    camera.forward = m.turn * camera.forward;
    return camera;
}

/// What may be divided by, and is as good as x.
SHARED_FN float awayFromZero(float x)
{
    return abs(x) < 1.0e-20f ? 1.0e-20f : x;
}

/// Whether origin + t way, 0 <= t <= tMax, meets a box.
SHARED_FN bool meetsBox(vec3 origin, vec3 way, float tMax, vec3 low, vec3 high)
{
    const vec3 d = vec3(awayFromZero(way.x), awayFromZero(way.y), awayFromZero(way.z));
    const vec3 a = (low - origin) / d;
    const vec3 b = (high - origin) / d;
    const vec3 near = min(a, b);
    const vec3 far = max(a, b);
    return max(max(near.x, near.y), max(near.z, 0.0f)) <= min(min(far.x, far.y), min(far.z, tMax));
}

/// Whether a way leads through the box of something that has moved: from `origin` to its end at
/// `origin + way`, or (ends false) on for ever. `own` does not count (kNone: all do), unless it is
/// one of several.
SHARED_FN bool passesMoved(IN(SceneView) scene, uint pieces, vec3 origin, vec3 way, bool ends,
                           uint own)
{
    bool passes = false;
    for (uint i = 0u; i < pieces; ++i) {
        const MovedPiece piece = fetchMovedPiece(scene, i);
        const bool counts = i != own || (piece.count & kMovedSeveral) != 0u;
        passes = passes ||
                 (counts && meetsBox(origin, way, ends ? 1.0f : kInfinity, piece.low, piece.high));
    }
    return passes;
}

SHARED_END

#endif
