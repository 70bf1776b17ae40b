// Reweighting-Augmentation at the first hits of a moving camera, one text for GPU and CPU. A pixel
// keeps samples of the light that comes to its first hit. When the camera has moved, each old one
// is looked at from the new first hit (reuse_shift.h) and answers for the share alpha of the new
// integral; the rest comes from new paths (reuse_new.h), whose first direction is resampled with
// weight 1 - alpha. After S. Wang, "Efficient Sample Usage in Photo-Realistic Rendering" (2022),
// chapter 8. What differs: in the fast mode samples that end at nothing that shines keep their
// direction and radiance alone, mirrors and glass included (keepDirection); elsewhere what arrives
// at the far end is stored as radiance by direction, so that a shiny far surface is seen from the
// new side; samples carry absolute weights (shared/reuse.h); visibility of old samples is asked for
// again as far as the settings say (reuse_visibility.h): where it is not, the picture is too bright
// where something has come in between.
#ifndef REKINDLE_SHARED_REUSE_PATH_H
#define REKINDLE_SHARED_REUSE_PATH_H

#include "reuse_allocation.h"
#include "reuse_chain.h"

SHARED_BEGIN

/// The ray of a pixel: through its centre, or anywhere in it and through the lens.
SHARED_FN PathState pixelRay(CameraData camera, PathSettings path, ReuseSettings settings,
                             uvec2 pixel, SampleStream stream)
{
    if ((settings.flags & kReuseJitters) != 0u || camera.apertureRadius > 0.0f)
        return beginPath(camera, path, pixel, stream);
    vec3 origin;
    vec3 direction;
    cameraRay(camera, vec2(float(pixel.x) + 0.5f, float(pixel.y) + 0.5f),
              vec2(float(path.imageWidth), float(path.imageHeight)), vec2(0.5f), origin, direction);
    return pathAlong(origin, direction);
}

/// What the ray of a pixel has met (kNone: nothing), for later passes; without history yet.
SHARED_FN ReusePixel firstHitAt(IN(SceneView) scene, Hit hit)
{
    ReusePixel pixel;
    pixel.slot = hit.slot;
    pixel.barycentrics = vec2(0.0f);
    pixel.history = packHistory(noHistory());
    if (hit.slot != kNone)
        pixel.barycentrics = insideTriangle(triangleInSlot(scene, hit.slot), hit.barycentrics);
    return pixel;
}

/// The stream of a pixel's new path number `which` in a pass. Where few paths are taken, or now
/// few and now many, the index is scrambled: every fourth point of a sequence lies in the same
/// quarter of its domain.
SHARED_FN SampleStream pathStream(ReuseSettings settings, SampleStream stream, float rays,
                                  uint which)
{
    const bool more = takesAllAnew(settings) && rays > max(settings.rays, 1.0f);
    if (more || allocatesPaths(settings)) {
        stream.index = hashUint(stream.index) * kReuseMostFresh + which;
    } else {
        stream.index = rays < 1.0f ? hashUint(stream.index) : stream.index + which;
    }
    return stream;
}

/// Which of four pixels histories are taken from in this pass: the same numbers for all pixels, so
/// that neighbours do not take the same one, and well spread over passes (multiples of irrational
/// numbers, of which every second to fourth are, too), so that no place wanders from its surface.
/// While the camera rests a pixel is its own history, wherever in it its first hits lie. Nearly 0
/// and 1 are left out: there what has not moved at all would lose its pixel by rounding. In a
/// picture that magnifies that before by 2 and more (`magnified`: its pixels for each of that),
/// many take the same one anyway: each its own of the four, so that no blocks are seen.
SHARED_FN vec2 tapNumbers(ReuseSettings settings, SampleStream stream, float magnified)
{
    if ((settings.flags & kReuseFollows) != 0u) return vec2(0.5f);
    if (magnified >= 2.0f) return streamVec2(decisionStream(stream, kPurposeResampling), 64u);
    const uint x = stream.index * 0x9e3779b9u + 0x80000000u;  // the golden ratio
    const uint y = stream.index * 0x6a09e667u + 0x80000000u;  // the root of two
    const vec2 unit = vec2(float(x >> 8u), float(y >> 8u)) * (1.0f / 16777216.0f);
    return 0.001f + 0.998f * unit;
}

/// By what chance old sample `i` survives rejection.
SHARED_FN float rejectionNumber(SampleStream stream, uint i)
{
    return streamFloat(decisionStream(stream, kPurposeResampling), 3u + i);
}

/// A history's credit where there is none yet.
SHARED_FN float firstCredit(SampleStream stream)
{
    // As it is stored: a number nearer to 1 than that would be a path too many.
    return unpackCredit(packCredit(streamFloat(decisionStream(stream, kPurposeResampling), 2u)));
}

SHARED_END

#endif
