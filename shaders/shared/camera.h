// Rays of a pinhole or thin-lens camera, perspective or orthographic.
#ifndef REKINDLE_SHARED_CAMERA_H
#define REKINDLE_SHARED_CAMERA_H

#include "layout.h"
#include "warp.h"

SHARED_BEGIN

/// The ray through `film` (pixels from the upper left corner, fractional) of an image of `size`
/// pixels. `lens` in [0,1)^2 picks the point of the aperture. The direction has unit length.
SHARED_FN void cameraRay(CameraData camera, vec2 film, vec2 size, vec2 lens, OUT(vec3) origin,
                         OUT(vec3) direction)
{
    const float x = (2.0f * film.x / size.x - 1.0f) * camera.tanHalfHeight * camera.aspect;
    const float y = (1.0f - 2.0f * film.y / size.y) * camera.tanHalfHeight;
    const vec3 offset = x * camera.right + y * camera.up;
    if (camera.orthographic != 0u) {
        origin = camera.position + offset;
        direction = camera.forward;
        return;
    }
    origin = camera.position;
    const vec3 towards = camera.forward + offset;
    direction = normalize(towards);
    if (FEATURE(kFeatureThinLens) && camera.apertureRadius > 0.0f) {
        const vec2 disk = sampleDisk(lens) * camera.apertureRadius;
        const vec3 focus = camera.focusDistance * towards;  // the plane of focus is flat
        const vec3 shift = disk.x * camera.right + disk.y * camera.up;
        origin = camera.position + shift;
        direction = normalize(focus - shift);
    }
}

SHARED_END

#endif
