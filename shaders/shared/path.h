// The path tracer's estimator, one text for GPU and CPU: unidirectional paths, next-event
// estimation, multiple importance sampling with the power heuristic (Veach 1997), Russian roulette.
// Devices only trace rays in between:
//   beginPath; loop { hit? shadeSurface : shadeMiss; trace the shadow ray; } until the path ends.
// Absorption is applied where a ray reaches the inner side of a solid; a shadow ray wholly inside
// one is not absorbed.
#ifndef REKINDLE_SHARED_PATH_H
#define REKINDLE_SHARED_PATH_H

#include "camera.h"
#include "lights.h"
#include "mis.h"
#include "sampler.h"

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
};

/// The connection to an emitter. `contribution` is what it adds if nothing is between; zero: no
/// need to trace. `direction` is not of unit length: `tMax` counts in its lengths.
struct ShadowRay {
    vec3 origin;
    vec3 direction;
    float tMax;
    vec3 contribution;
};

/// The random numbers of a path's vertex. Drawn before the vertex is shaded, so that a CPU can draw
/// those of many paths together.
struct VertexNumbers {
    vec2 bsdf;
    vec2 lobe;  // x which lobe, y roulette
    vec2 light;
    float choice;  // of the emitter
};

SHARED_FN VertexNumbers drawVertexNumbers(SampleStream stream, uint depth)
{
    const uint dimension = kDimensionPath + depth * kDimensionsPerVertex;
    VertexNumbers n;
    n.bsdf = streamVec2(stream, dimension + kDimensionBsdf);
    n.lobe = streamVec2(stream, dimension + kDimensionLobe);
    n.light = streamVec2(stream, dimension + kDimensionLight);
    n.choice = FEATURE(kFeatureManyEmitters)
                   ? streamFloat(stream, dimension + kDimensionLightChoice)
                   : 0.0f;
    return n;
}

/// Seed of the alpha test for the rays that leave a vertex; `shadow` 1 for the connection to an
/// emitter.
SHARED_FN uint alphaSeed(SampleStream stream, uint depth, uint shadow)
{
    return hashUint(stream.pixel ^
                    hashUint(stream.index * 2u + shadow + 0x9e3779b9u * depth + stream.seed));
}

SHARED_FN PathState beginPath(CameraData camera, PathSettings settings, uvec2 pixel,
                              SampleStream stream)
{
    PathState path;
    const vec2 film = vec2(float(pixel.x), float(pixel.y)) + streamVec2(stream, kDimensionPixel);
    vec2 lens = vec2(0.5f, 0.5f);
    if (FEATURE(kFeatureThinLens) && camera.apertureRadius > 0.0f)
        lens = streamVec2(stream, kDimensionLens);
    cameraRay(camera, film, vec2(float(settings.imageWidth), float(settings.imageHeight)), lens,
              path.origin, path.direction);
    path.beta = vec3(1.0f, 1.0f, 1.0f);
    path.pdf = 0.0f;
    path.depth = 0u;
    return path;
}

/// Weight of emission that was met by following a sampled direction; `emitterPdf` is the density
/// with which next-event estimation would have found the same point, choice among emitters
/// included.
SHARED_FN float emissionWeight(PathSettings settings, float pdf, float emitterPdf)
{
    if (pdf == 0.0f || settings.strategy == kStrategyBsdf) return 1.0f;
    if (settings.strategy == kStrategyLight) return emitterPdf > 0.0f ? 0.0f : 1.0f;
    return powerHeuristic(pdf, emitterPdf);
}

/// Limits what an indirect connection may add; biased, off (0) unless asked for.
SHARED_FN vec3 clampIndirect(PathSettings settings, uint depth, vec3 contribution)
{
    if (!(settings.clampIndirect > 0.0f) || depth < 2u) return contribution;
    const float largest = maxComponent(contribution);
    return largest > settings.clampIndirect ? contribution * (settings.clampIndirect / largest)
                                            : contribution;
}

/// Radiance that a ray which hit nothing brings home.
SHARED_FN vec3 shadeMiss(SCENE_PARAM PathSettings settings, PathState path)
{
    vec3 L = vec3(0.0f, 0.0f, 0.0f);
    if (FEATURE(kFeatureEnvironment) && settings.environmentEmitter != kNone) {
        float density = 0.0f;
        if (path.pdf > 0.0f && settings.strategy != kStrategyBsdf) {
            density = pmfEmitter(SCENE_ARG settings.environmentEmitter) *
                      pdfEnvironment(SCENE_ARG settings, path.direction);
        }
        L += emissionWeight(settings, path.pdf, density) *
             environmentRadiance(SCENE_ARG settings, path.direction);
    }
    if (FEATURE(kFeatureSun) && settings.sunEmitter != kNone) {
        const Emitter sun = fetchEmitter(SCENE_ARG settings.sunEmitter);
        const float density = pdfSun(sun, path.direction);
        if (density > 0.0f) {
            L += emissionWeight(settings, path.pdf,
                                pmfEmitter(SCENE_ARG settings.sunEmitter) * density) *
                 sun.radiance;
        }
    }
    return clampIndirect(settings, path.depth, path.beta * L);
}

/// Emission of the surface at `s`, weighted against next-event estimation from the path's previous
/// vertex.
SHARED_FN vec3 shadeEmission(SCENE_PARAM PathSettings settings, PathState path, Hit hit,
                             SurfacePoint s, vec3 emission)
{
    float density = 0.0f;
    if (path.pdf > 0.0f && s.emitter != kNone && settings.strategy != kStrategyBsdf) {
        const vec3 a = xyz(fetchTriangleVertex(SCENE_ARG hit.slot, 0u));
        const vec3 b = xyz(fetchTriangleVertex(SCENE_ARG hit.slot, 1u));
        const vec3 c = xyz(fetchTriangleVertex(SCENE_ARG hit.slot, 2u));
        density = pmfEmitter(SCENE_ARG s.emitter) *
                  pdfTriangleEmitter(a, b, c, path.origin, path.direction, hit.t);
    }
    return clampIndirect(settings, path.depth,
                         emissionWeight(settings, path.pdf, density) * path.beta * emission);
}

/// Connects the vertex to one emitter; contribution zero when nothing can come of it.
SHARED_FN ShadowRay connectToEmitter(SCENE_PARAM PathSettings settings, VertexNumbers numbers,
                                     PathState path, SurfacePoint s, Bsdf bsdf, vec3 wo)
{
    ShadowRay shadow;
    shadow.origin = s.position;
    shadow.direction = vec3(0.0f, 0.0f, 1.0f);
    shadow.tMax = 0.0f;
    shadow.contribution = vec3(0.0f, 0.0f, 0.0f);
    if (settings.emitterCount == 0u || isDelta(bsdf)) return shadow;

    float pmf = 1.0f;
    uint emitter = 0u;
    if (FEATURE(kFeatureManyEmitters)) {
        emitter = chooseEmitter(SCENE_ARG settings.emitterCount, numbers.choice, pmf);
    }
    EmitterSample e;
    if (!sampleEmitter(SCENE_ARG settings, emitter, s.position, numbers.light, e)) return shadow;
    if (settings.strategy == kStrategyBsdf && e.pdf > 0.0f) return shadow;

    const vec3 wi = toLocal(s.frame, e.wi);
    const float side = dot(e.wi, s.normal) * (s.backFace != 0u ? -1.0f : 1.0f);
    // Where the two normals disagree, no light goes through the surface.
    if (!(side * wi.z > 0.0f)) return shadow;
    vec3 f;
    float pdf;
    evalPdfBsdf(bsdf, wo, wi, f, pdf);
    float weight = 1.0f / pmf;
    if (e.pdf > 0.0f) {
        weight /= e.pdf;
        if (settings.strategy == kStrategyMis) weight *= powerHeuristic(pmf * e.pdf, pdf);
    }
    shadow.contribution =
        clampIndirect(settings, path.depth + 1u, path.beta * f * e.radiance * (abs(wi.z) * weight));
    const vec3 outside = s.backFace != 0u ? -s.normal : s.normal;
    shadow.origin = offsetRay(s.position, side > 0.0f ? outside : -outside);
    shadow.direction = e.wi;
    shadow.tMax = kDistant;
    if (e.distance < 0.5f * kDistant) {
        // Aimed anew from the shifted origin: along the old direction an emitter seen edge-on would
        // block itself.
        shadow.direction = (s.position - shadow.origin) + e.distance * e.wi;
        shadow.tMax = 0.9999f;
    }
    return shadow;
}

/// One vertex of a path. Adds emission to L, sets the connection to an emitter, and moves `path` on
/// to the next ray; returns false when the path ends here (the shadow ray still counts).
SHARED_FN bool shadeSurface(SCENE_PARAM PathSettings settings, VertexNumbers numbers, Hit hit,
                            INOUT(PathState) path, OUT(ShadowRay) shadow, INOUT(vec3) L)
{
    SurfacePoint s = makeSurfacePoint(SCENE_ARG hit, path.direction);
    const Shading shading = evaluateMaterial(SCENE_ARG s, path.direction);
    shadow.origin = s.position;
    shadow.direction = vec3(0.0f, 0.0f, 1.0f);
    shadow.tMax = 0.0f;
    shadow.contribution = vec3(0.0f, 0.0f, 0.0f);

    if (FEATURE(kFeatureVolume) && s.backFace != 0u &&
        (shading.inputs.flags & kMaterialVolume) != 0u) {
        path.beta *= exp(-hit.t * shading.absorption);
    }
    if (FEATURE(kFeatureEmissiveTriangles) && maxComponent(shading.emission) > 0.0f) {
        L += shadeEmission(SCENE_ARG settings, path, hit, s, shading.emission);
    }
    if (path.depth >= settings.maxDepth || (shading.inputs.flags & kMaterialUnlit) != 0u)
        return false;

    const Bsdf bsdf = makeBsdf(shading.inputs);
    const vec3 wo = toLocal(s.frame, -path.direction);
    shadow = connectToEmitter(SCENE_ARG settings, numbers, path, s, bsdf, wo);

    BsdfSample next;
    if (!sampleBsdf(bsdf, wo, numbers.lobe.x, numbers.bsdf, next)) return false;
    const vec3 wi = toWorld(s.frame, next.wi);
    const float side = dot(wi, s.normal) * (s.backFace != 0u ? -1.0f : 1.0f);
    if (!(side * next.wi.z > 0.0f)) return false;
    path.beta *= next.weight;
    const vec3 outside = s.backFace != 0u ? -s.normal : s.normal;
    path.origin = offsetRay(s.position, side > 0.0f ? outside : -outside);
    path.direction = wi;
    path.pdf = next.pdf;
    path.depth += 1u;
    if (path.depth >= settings.rouletteDepth) {
        // The root keeps more of the dim paths than the throughput itself would: measured, error^2
        // times time falls by 6 % in a Cornell box and by 15 to 25 % in a white stairwell.
        const float survival = min(sqrt(maxComponent(path.beta)), 1.0f);
        if (!(numbers.lobe.y < survival)) return false;
        path.beta *= 1.0f / survival;
    }
    return maxComponent(path.beta) > 0.0f;
}

SHARED_END

#endif
