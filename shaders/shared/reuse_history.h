// Backprojection: which pixel of the frame before saw the surface that a pixel sees now, and
// whether what is kept there may be used here. The tests are those of temporal accumulation (C.
// Schied et al., "Spatiotemporal Variance-Guided Filtering", 2017) without scales of their own: the
// same material, normals that agree, a distance between the two planes that is small beside the
// distance of the camera. All of it depends on geometry alone, which keeps what is made of the
// history unbiased.
#ifndef REKINDLE_SHARED_REUSE_HISTORY_H
#define REKINDLE_SHARED_REUSE_HISTORY_H

#include "layout.h"
#include "motion.h"
#include "reuse_records.h"
#include "surface.h"

SHARED_BEGIN

SHARED_CONST float kHistoryLeastCosine = 0.9f;      // between geometric normals
SHARED_CONST float kHistoryPlaneDistance = 0.005f;  // of the distance to the camera
SHARED_CONST float kHistoryPixels = 4.0f;  // across, where it is not known which pixel it should be

/// Where a point lies on the film of a camera, in pixels from the upper left corner. False where it
/// lies outside by more than two pixels, or behind a pinhole.
SHARED_FN bool projectToFilm(CameraData camera, vec2 size, vec3 position, OUT(vec2) film)
{
    const vec3 d = position - camera.position;
    const float ahead = camera.orthographic != 0u ? 1.0f : dot(d, camera.forward);
    const float scale = 1.0f / (ahead * camera.tanHalfHeight);
    film = vec2((dot(d, camera.right) * scale / camera.aspect + 1.0f) * 0.5f * size.x,
                (1.0f - dot(d, camera.up) * scale) * 0.5f * size.y);
    return ahead > 0.0f && film.x > -2.0f && film.y > -2.0f && film.x < size.x + 2.0f &&
           film.y < size.y + 2.0f;
}

SHARED_FN vec3 mirrored(vec3 v, vec3 n)
{
    return v - 2.0f * dot(v, n) * n;
}

/// The camera as a mirror through `position`, of normal n, shows it.
SHARED_FN CameraData mirroredCamera(CameraData camera, vec3 position, vec3 n)
{
    camera.position = position + mirrored(camera.position - position, n);
    camera.right = mirrored(camera.right, n);
    camera.up = mirrored(camera.up, n);
    camera.forward = mirrored(camera.forward, n);
    return camera;
}

/// Unit direction from a point to where the camera is.
SHARED_FN vec3 towardsCamera(CameraData camera, vec3 position)
{
    return camera.orthographic != 0u ? -camera.forward : normalize(camera.position - position);
}

/// The pixel to look at first for the history of what was at `film`: one of the four around, each
/// as often over passes as bilinear interpolation weighs it (`xi`: tapNumbers). The nearest loses
/// every motion by less than half a pixel a frame, and in the end what is kept belongs to a place
/// many pixels away: means are too dark (.6 % after an arc of 1 degree a view), samples are not
/// asked again what lies between, and shadows stay behind (at the foot of the boxes of a Cornell
/// box .7 of the squared error).
SHARED_FN ivec2 historyPixel(vec2 film, vec2 xi)
{
    return ivec2(int(floor(film.x + xi.x - 0.5f)), int(floor(film.y + xi.y - 0.5f)));
}

/// Whether it is a pixel of a picture. What has come in over the border, where that of historyPixel
/// is none, has no history: from one frame to the next it would be handed on by the pixels at the
/// border, ever farther from the place that it belongs to (a wall in sharp sunlight was .87 as
/// bright as it should be after 24 views).
SHARED_FN bool isPixelOf(ivec2 size, ivec2 at)
{
    return at.x >= 0 && at.y >= 0 && at.x < size.x && at.y < size.y;
}

/// The same where `magnified` (tapNumbers) is the picture over that before, of `size`: in a block
/// of pixels that were one, those at the border of the picture were in it, too. Each draws a pixel
/// of its own, so that none is handed on by all.
SHARED_FN ivec2 historyPixelOf(ivec2 size, vec2 film, vec2 xi, float magnified)
{
    const ivec2 at = historyPixel(film, xi);
    const bool inside = isPixelOf(size, ivec2(int(floor(film.x)), int(floor(film.y))));
    if (magnified < 2.0f || !inside) {
        return at;
    }
    return ivec2(min(max(at.x, 0), size.x - 1), min(max(at.y, 0), size.y - 1));
}

/// Pixels that are looked at for a history, one after the other, k < 9: that of historyPixel, then
/// those around it. The first alone would be right where something comes out from behind an edge,
/// too, but edges lose their histories then: after 30 views 1.6 times the error in a Cornell box,
/// 1.3 times in a kitchen.
SHARED_FN ivec2 historyOffset(uint k)
{
    const uint at = k == 0u ? 4u : (k <= 4u ? k - 1u : k);
    return ivec2(int(at % 3u) - 1, int(at / 3u) - 1);
}

/// Tap k < 4 of bilinear interpolation at a point of the film: its pixel and weight.
SHARED_FN float historyTap(vec2 film, uint k, OUT(ivec2) at)
{
    const vec2 low = vec2(floor(film.x - 0.5f), floor(film.y - 0.5f));
    const vec2 f = film - vec2(0.5f) - low;
    at = ivec2(int(low.x) + int(k & 1u), int(low.y) + int(k >> 1u));
    return ((k & 1u) != 0u ? f.x : 1.0f - f.x) * ((k >> 1u) != 0u ? f.y : 1.0f - f.y);
}

/// How far from each other two first hits of neighbouring pixels may be, of which one was met in
/// `direction` at some distance from the camera.
SHARED_FN float reachOfHistory(CameraData camera, float height, float distance, vec3 direction,
                               vec3 normal)
{
    const float pixel = 2.0f * camera.tanHalfHeight / height;
    const float footprint = camera.orthographic != 0u ? pixel : pixel * distance;
    return kHistoryPixels * footprint / max(abs(dot(direction, normal)), 0.1f);
}

/// Whether the first hit `before` of a camera belongs to the surface at `s` and is on the same side
/// of it, no farther away than `reach`; `distance` is that of the camera, which has moved along
/// with `piece`, the moved one that the surface belongs to (motion.h). All of it as it lies now.
SHARED_FN bool historyFits(IN(SceneView) scene, ReuseSettings settings, CameraData cameraBefore,
                           ReusePixel before, IN(SurfacePoint) s, uint piece, float distance,
                           float reach)
{
    if (before.slot == kNone || !(unpackHistory(before.history).nominal > 0.0f)) return false;
    const Triangle t = triangleInSlot(scene, before.slot);
    const vec3 position = pointOn(t, before.barycentrics);
    const uint material = floatAsUint(t.v1.w) & ~kTriangleAlphaBit;
    const vec3 n = normalize(cross(xyz(t.v1) - xyz(t.v0), xyz(t.v2) - xyz(t.v0)));
    const bool behind = dot(n, towardsCamera(cameraBefore, position)) < 0.0f;
    return material == s.material && length(position - s.position) <= reach &&
           behind == (s.backFace != 0u) && dot(n, s.normal) >= kHistoryLeastCosine &&
           abs(dot(position - s.position, s.normal)) <= kHistoryPlaneDistance * distance &&
           movedPieceOf(scene, movedPieces(settings), floatAsUint(t.v0.w)) == piece;
}

SHARED_END

#endif
