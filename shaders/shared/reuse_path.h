// Reweighting-Augmentation at the first hits of a moving camera, one text for GPU and CPU. A pixel
// keeps samples of the light that comes to its first hit. When the camera has moved, each old one
// is aimed anew from the new first hit at the place where it came from (reconnection; Kettunen et
// al., "Gradient-Domain Path Tracing", 2015) and answers for the share alpha of the new integral;
// the rest comes from new paths, whose first direction is resampled with weight 1 - alpha. After S.
// Wang, "Efficient Sample Usage in Photo-Realistic Rendering" (2022), chapter 8. What differs: what
// arrives at the far end is stored as radiance by direction, so that a shiny far surface is seen
// from the new side; samples carry absolute weights (shared/reuse.h); visibility of old samples is
// not asked for again, which is the one bias (too bright where something has come in between).
//
// A device includes this after it has said how rays are traced:
//   bool traceWay(SceneView, vec3 origin, vec3 direction, uint seed, out Hit)
//   bool wayIsOpen(SceneView, ShadowRay, uint seed)
#ifndef REKINDLE_SHARED_REUSE_PATH_H
#define REKINDLE_SHARED_REUSE_PATH_H

#include "reuse_view.h"

SHARED_BEGIN

#ifdef __cplusplus
bool traceWay(const SceneView& scene, vec3 origin, vec3 direction, uint seed, Hit& hit);
bool wayIsOpen(const SceneView& scene, const ShadowRay& shadow, uint seed);
#else
bool traceWay(SceneView scene, vec3 origin, vec3 direction, uint seed, out Hit hit);
bool wayIsOpen(SceneView scene, ShadowRay shadow, uint seed);
#endif

/// Rays that a pass has cost.
struct ReuseTally {
    uint closestRays;
    uint shadowRays;
};

/// The ray of a pixel: through its centre, or anywhere in it and through the lens.
SHARED_FN PathState pixelRay(CameraData camera, PathSettings path, ReuseSettings settings,
                             uvec2 pixel, SampleStream stream)
{
    if ((settings.flags & kReuseJitters) != 0u || camera.apertureRadius > 0.0f)
        return beginPath(camera, path, pixel, stream);
    PathState ray;
    cameraRay(camera, vec2(float(pixel.x) + 0.5f, float(pixel.y) + 0.5f),
              vec2(float(path.imageWidth), float(path.imageHeight)), vec2(0.5f), ray.origin,
              ray.direction);
    ray.beta = vec3(1.0f);
    ray.pdf = 0.0f;
    ray.depth = 0u;
    return ray;
}

/// What the ray of a pixel meets, for later passes; without history yet.
SHARED_FN ReusePixel findFirstHit(IN(SceneView) scene, PathState ray, SampleStream stream)
{
    ReusePixel pixel;
    pixel.slot = kNone;
    pixel.barycentrics = vec2(0.0f);
    pixel.nominal = 0.0f;
    Hit hit;
    if (traceWay(scene, ray.origin, ray.direction, alphaSeed(stream, 0u, 0u), hit)) {
        pixel.slot = hit.slot;
        pixel.barycentrics = hit.barycentrics;
    }
    return pixel;
}

/// The rest of a path from its second vertex on, everything that it brings home.
SHARED_FN vec3 followPath(IN(SceneView) scene, PathSettings settings, SampleStream stream,
                          PathState path, INOUT(ReuseTally) tally)
{
    vec3 L = vec3(0.0f);
    bool goesOn = true;
    while (goesOn) {
        Hit hit;
        ++tally.closestRays;
        if (!traceWay(scene, path.origin, path.direction, alphaSeed(stream, path.depth, 0u), hit)) {
            L += shadeMiss(scene, settings, path);
            break;
        }
        const uint depth = path.depth;
        const VertexNumbers numbers = drawVertexNumbers(stream, depth);
        ShadowRay shadow;
        goesOn = shadeSurface(scene, settings, numbers, hit, path, shadow, L);
        if (maxComponent(shadow.contribution) > 0.0f) {
            ++tally.shadowRays;
            if (wayIsOpen(scene, shadow, alphaSeed(stream, depth, 1u))) L += shadow.contribution;
        }
    }
    return L;
}

/// The stream of another purpose at the same sample of a path.
SHARED_FN SampleStream purposeStream(SampleStream stream, uint purpose)
{
    stream.seed ^= purpose * 0x9e3779b9u;  // as makeStream
    return stream;
}

/// The same for decisions that follow upon earlier ones:
/// its numbers do not know those of the frames before. A sequence that is well spread over frames
/// would be biased here, since what it gives depends on what it gave to the samples that are there.
SHARED_FN SampleStream decisionStream(SampleStream stream, uint purpose)
{
    stream.kind = kSamplerIndependent;
    return purposeStream(stream, purpose);
}

/// Numbers for the stochastic rounding of what is stored.
SHARED_FN vec3 roundingNumbers(SampleStream stream, uint which)
{
    stream = decisionStream(stream, kPurposeRounding);
    const vec2 a = streamVec2(stream, 2u * which);
    return vec3(a.x, a.y, streamVec2(stream, 2u * which + 1u).x);
}

/// Radiance that comes to a first hit along a sampled direction, and what is to be kept of it.
/// `importance` is what the first hit makes of it, for roulette only.
SHARED_FN vec3 traceNewSample(IN(SceneView) scene, PathSettings settings, SampleStream stream,
                              PathState path, float importance, OUT(ReuseSample) record,
                              OUT(vec3) toPlace, OUT(vec3) normal, INOUT(ReuseTally) tally)
{
    record = noReuseSample();
    toPlace = path.direction;
    normal = path.direction;
    Hit hit;
    ++tally.closestRays;
    if (!traceWay(scene, path.origin, path.direction, alphaSeed(stream, 0u, 0u), hit)) {
        record.place = octEncode(path.direction);
        return shadeMiss(scene, settings, path);
    }
    record.slot = hit.slot;
    record.place = hit.barycentrics;
    vec3 L = vec3(0.0f);
    Vertex far;
    const bool scatters = prepareVertex(scene, settings, hit, path, far, L);
    toPlace = far.surface.position;
    normal = far.surface.normal;
    if (!scatters) return L;
    const VertexNumbers numbers = drawVertexNumbers(stream, path.depth);
    if (connects(settings, far)) {
        const ShadowRay shadow = connect(scene, settings, numbers, path, far);
        if (maxComponent(shadow.contribution) > 0.0f) {
            ++tally.shadowRays;
            if (wayIsOpen(scene, shadow, alphaSeed(stream, path.depth, 1u))) {
                L += shadow.contribution;
                record.lightDirection = packOct(shadow.wi);
                record.lightRadiance = packRgbe(shadow.incident, roundingNumbers(stream, 0u));
            }
        }
    }
    BsdfSample next;
    PathState onward = path;
    onward.beta *= importance;
    if (!sampleDirection(scene, far, numbers, next)) return L;
    const float entering = maxComponent(onward.beta * next.weight);
    if (!follow(settings, numbers, far, next, onward)) return L;
    // Grey from here on, so that what arrives can be told from what the surface makes of it.
    const vec3 throughput = onward.beta / importance;
    const float grey = maxComponent(onward.beta);
    onward.beta = vec3(grey);
    const vec3 arriving = followPath(scene, settings, stream, onward, tally) / grey;
    L += throughput * arriving;
    if (maxComponent(arriving) > 0.0f) {
        const vec3 xi = roundingNumbers(stream, 1u);
        const bool frozen = next.pdf == 0.0f;
        record.nextDirection = frozen ? kFrozenRadiance : packOct(onward.direction);
        // grey / entering is one over the chance to survive
        record.nextRadiance = packRgbe(
            frozen ? throughput * arriving : arriving * (grey / (entering * next.pdf)), xi);
    }
    return L;
}

/// A direction for a new path: the pick of resampling among k candidates.
struct ReuseDraw {
    BsdfSample next;
    float omega;  // the weight that it was picked with
    float mean;   // of the weights of all candidates; 0: nothing to trace
    float alpha;  // before it is known where the ray ends
};

// A chance for every candidate: whether a sample may be reused is only known once its ray has been
// traced, and what may not is not left to old samples.
SHARED_CONST float kReuseLeastOmega = 0.05f;

SHARED_FN ReuseDraw drawNewDirection(IN(SceneView) scene, ReuseSettings settings, IN(ReuseVertex) v,
                                     SampleStream stream, uint candidates)
{
    ReuseDraw draw;
    draw.omega = 0.0f;
    draw.mean = 0.0f;
    draw.alpha = 0.0f;
    float sum = 0.0f;
    const SampleStream proposals = purposeStream(stream, kPurposeCandidates);
    const SampleStream selection = decisionStream(stream, kPurposeSelection);
    for (uint t = 0u; t < candidates; ++t) {
        VertexNumbers numbers;
        numbers.light = vec2(0.0f);
        numbers.choice = 0.0f;
        // A single candidate is the path's own direction, as where nothing is reused.
        numbers.bsdf = candidates == 1u ? streamVec2(stream, kDimensionPath + kDimensionBsdf)
                                        : streamVec2(proposals, 2u * t);
        numbers.lobe = candidates == 1u ? streamVec2(stream, kDimensionPath + kDimensionLobe)
                                        : streamVec2(proposals, 2u * t + 1u);
        BsdfSample z;
        if (!sampleDirection(scene, v.vertex, numbers, z)) continue;
        float alpha = 0.0f;
        if (v.nominal > 0.0f && z.pdf > 0.0f)
            alpha = reuseShare(settings, v.c, densityBefore(v, z.wi), z.pdf);
        const float omega = max(1.0f - alpha, kReuseLeastOmega);
        sum += omega;
        const float xi = candidates == 1u ? 0.0f : streamFloat(selection, t);
        if (xi * sum < omega) {
            draw.next = z;
            draw.omega = omega;
            draw.alpha = alpha;
        }
    }
    draw.mean = sum / float(candidates);
    return draw;
}

/// Candidates that pay: several only where the lobe has moved by a good part of its width.
SHARED_FN uint candidatesFor(ReuseSettings settings, IN(ReuseVertex) v)
{
    if (settings.strategy != kReuseRa || !(v.nominal > 0.0f)) return 1u;
    if ((v.vertex.bsdf.parts & kBsdfMicrofacet) == 0u) return 1u;
    // Total variation of a microfacet lobe turned by an angle: about a quarter of angle / alpha.
    const float moved = length(v.vertex.wo - v.woBefore);
    return 0.25f * moved > 0.1f * v.vertex.bsdf.alpha ? settings.candidates : 1u;
}

/// One new path from a first hit.
SHARED_FN void takeNewSample(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                             IN(ReuseVertex) v, SampleStream stream, INOUT(ReuseNew) result,
                             INOUT(ReuseTally) tally)
{
    const ReuseDraw draw = drawNewDirection(scene, settings, v, stream, candidatesFor(settings, v));
    if (!(draw.mean > 0.0f)) return;
    PathState ray;
    ray.direction = toWorld(v.vertex.surface.frame, draw.next.wi);
    ray.pdf = draw.next.pdf;
    ray.beta = vec3(1.0f);
    ray.depth = 1u;
    float side;
    if (!sideOf(v.vertex.surface, ray.direction, draw.next.wi.z, side)) return;
    ray.origin = originOnSide(v.vertex.surface, side);
    vec3 toPlace;
    vec3 normal;
    const vec3 L = traceNewSample(scene, path, stream, ray, maxComponent(draw.next.weight),
                                  result.record, toPlace, normal, tally);
    float alpha = draw.alpha;
    float perPlace = 1.0f;
    if (result.record.slot != kNone) {
        toPlace -= v.vertex.surface.position;
        const float d2 = dot(toPlace, toPlace);
        perPlace = d2 * sqrt(d2) / abs(dot(normal, toPlace));
        // What cannot be aimed anew is not left to old samples.
        if (alpha > 0.0f)
            alpha *= reconnection(toPlace, normal, v.vertex.surface.position, v.positionBefore);
    }
    result.scale = draw.mean * (1.0f - alpha) / draw.omega;
    result.around = draw.next.weight * L;
    const float u = result.scale / ray.pdf * perPlace;
    result.record.u = ray.pdf > 0.0f && u < kInfinity ? u : 0.0f;
}

/// A new connection.
SHARED_FN void takeNewLight(IN(SceneView) scene, PathSettings path, IN(ReuseVertex) v,
                            SampleStream stream, INOUT(ReuseNew) result, INOUT(ReuseTally) tally)
{
    if (!connects(path, v.vertex)) return;
    const VertexNumbers numbers = drawVertexNumbers(stream, 0u);
    float pmf;
    if (FEATURE(kFeatureManyEmitters))
        result.light.emitter = chooseEmitter(scene, path.emitterCount, numbers.choice, pmf);
    result.light.numbers = packNumbers(numbers.light);
    const ShadowRay shadow = viewLight(scene, path, v, result.light);
    if (!(maxComponent(shadow.contribution) > 0.0f)) return;
    ++tally.shadowRays;
    if (!wayIsOpen(scene, shadow, alphaSeed(stream, 0u, 1u))) return;
    result.direct = shadow.contribution;
    result.light.v = 1.0f - v.c;
}

/// Takes a new path and a new connection.
SHARED_FN ReuseNew takeNew(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                           IN(ReuseVertex) v, SampleStream stream, INOUT(ReuseTally) tally)
{
    ReuseNew result = noReuseNew();
    ReuseVertex fresh = v;
    if (settings.strategy == kReuseNaive) {
        fresh.nominal = 0.0f;
        fresh.c = 0.0f;
    }
    takeNewSample(scene, path, settings, fresh, stream, result, tally);
    takeNewLight(scene, path, fresh, stream, result, tally);
    return result;
}

SHARED_END

#endif
