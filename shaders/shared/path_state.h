// A path between two vertices, and what leaves one, path or connection: to which side, from where,
// through which medium.
#ifndef REKINDLE_SHARED_PATH_STATE_H
#define REKINDLE_SHARED_PATH_STATE_H

#include "camera.h"
#include "lights.h"
#include "medium.h"
#include "vertex.h"

SHARED_BEGIN

/// A path between two vertices. `pdf` is the density of `direction` in solid angle, 0 where
/// emitters cannot be sampled against it (camera, delta lobes). `depth` counts scattering events so
/// far.
struct PathState {
    vec3 origin;
    vec3 direction;
    vec3 beta;
    float pdf;
    uint depth;
    uint departure;  // from its last vertex: departure.h
    float passed;    // how far back that is, behind panes
    uint skyRegion;  // that vertex's
    uint medium;     // that it goes through: mediumBeyond
};

/// Whether connections go straight through panes: nothing of them is in the code of other scenes.
SHARED_FN bool passesPanes(PathSettings settings)
{
    return FEATURE(kFeaturePanes) && settings.passesPanes != kPanesBlock;
}

/// How many panes a connection may go through from a vertex of that depth to an emitter of density
/// `pdf`: each counts as a scattering event.
SHARED_FN uint mostPanes(PathSettings settings, uint depth, float pdf)
{
    if (!passesPanes(settings)) return 0u;
    if (settings.passesPanes == kPanesPassPunctual && pdf > 0.0f) return 0u;
    return settings.maxDepth - 1u - depth;
}

/// The vertex from which the path came here, straight through panes or not.
SHARED_FN vec3 lastVertex(PathState path)
{
    return FEATURE(kFeaturePanes) ? path.origin - path.passed * path.direction : path.origin;
}

/// Seed of the alpha test for the rays that leave a vertex; `shadow` 1 for the connection to an
/// emitter.
SHARED_FN uint alphaSeed(SampleStream stream, uint depth, uint shadow)
{
    // A dimension that no pattern of the sampler has.
    const uint dimension = 0xa511e9b3u + 2u * depth + shadow;
    return pcg4d(uvec4(stream.pixel, dimension, stream.seed, stream.index)).x;
}

/// A path that goes along a ray, whatever it came from.
SHARED_FN PathState pathAlong(vec3 origin, vec3 direction)
{
    PathState path;
    path.origin = origin;
    path.direction = direction;
    path.beta = vec3(1.0f, 1.0f, 1.0f);
    path.pdf = 0.0f;
    path.depth = 0u;
    path.departure = noDeparture();
    path.passed = 0.0f;
    path.skyRegion = 0u;
    path.medium = kNone;
    return path;
}

SHARED_FN PathState beginPath(CameraData camera, PathSettings settings, uvec2 pixel,
                              SampleStream stream)
{
    const vec2 offset =
        camera.centred != 0u ? vec2(0.5f, 0.5f) : streamVec2(stream, kDimensionPixel);
    const vec2 film = vec2(float(pixel.x), float(pixel.y)) + offset;
    vec2 lens = vec2(0.5f, 0.5f);
    if (FEATURE(kFeatureThinLens) && camera.apertureRadius > 0.0f)
        lens = streamVec2(stream, kDimensionLens);
    vec3 origin;
    vec3 direction;
    cameraRay(camera, film, vec2(float(settings.imageWidth), float(settings.imageHeight)), lens,
              origin, direction);
    return pathAlong(origin, direction);
}

/// Cosine of `wi` (world) to the geometric normal on the side of wo: positive for reflection.
/// `cosine` is that to the shading normal. Where the two differ in sign no light goes through the
/// surface: false.
SHARED_FN bool sideOf(IN(SurfacePoint) s, vec3 wi, float cosine, OUT(float) side)
{
    side = dot(wi, s.normal) * (s.backFace != 0u ? -1.0f : 1.0f);
    return side * cosine > 0.0f;
}

/// Where a ray starts that leaves to the given side of the surface (see sideOf).
SHARED_FN vec3 originOnSide(IN(SurfacePoint) s, float side)
{
    const vec3 outside = s.backFace != 0u ? -s.normal : s.normal;
    return offsetRay(s.position, side > 0.0f ? outside : -outside, s.offset);
}

/// The medium on the given side (see sideOf) of a vertex that was reached through `medium`.
SHARED_FN uint mediumBeyond(uint medium, IN(Vertex) vertex, float side)
{
    return side > 0.0f ? medium : mediumBehind(medium, vertex.surface, vertex.bsdf);
}

/// What is left of light (transmittance) on the way to a surface, whose material has those flags:
/// the inner side of a solid tells what it is seen through, wherever the way began.
SHARED_FN vec3 transmittanceTo(IN(SceneView) scene, IN(SurfacePoint) s, uint flags, float distance,
                               INOUT(uint) medium)
{
    if (s.backFace != 0u && (flags & kMaterialVolume) != 0u) medium = s.material;
    return transmittance(scene, medium, distance);
}

/// Limits what an indirect connection may add; biased, off (0) unless asked for.
SHARED_FN vec3 clampIndirect(PathSettings settings, uint depth, vec3 contribution)
{
    if (!(settings.clampIndirect > 0.0f) || depth < 2u) return contribution;
    const float largest = maxComponent(contribution);
    return largest > settings.clampIndirect ? contribution * (settings.clampIndirect / largest)
                                            : contribution;
}

SHARED_END

#endif
