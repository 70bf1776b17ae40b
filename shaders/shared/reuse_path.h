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

#include "path.h"
#include "reuse.h"
#include "reuse_history.h"
#include "reuse_records.h"

SHARED_BEGIN

#ifdef __cplusplus
bool traceWay(const SceneView& scene, vec3 origin, vec3 direction, uint seed, Hit& hit);
bool wayIsOpen(const SceneView& scene, const ShadowRay& shadow, uint seed);
#else
bool traceWay(SceneView scene, vec3 origin, vec3 direction, uint seed, out Hit hit);
bool wayIsOpen(SceneView scene, ShadowRay shadow, uint seed);
#endif

// Where an old sample may be aimed anew: far from the surface beside the way the first hit has
// gone, and with a Jacobian that neither blows it up nor lets it vanish. What fails is left to new
// samples, on both sides alike.
SHARED_CONST float kReuseNearest = 0.5f;
SHARED_CONST float kReuseMostStretch = 11.0f;

/// A first hit, and how the samples of the frame before look at it.
struct ReuseVertex {
    Vertex vertex;
    vec3 woBefore;           // towards the camera of the frame before, in the surface's frame
    LobeChoice lobesBefore;  // at woBefore
    vec3 positionBefore;     // of the first hit that the history belongs to
    float nominal;           // N; 0 without history
    float c;                 // N / (N + n)
};

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

/// The first hit as the camera sees it; adds what is seen directly to L. False where nothing is
/// scattered.
SHARED_FN bool beginReuse(IN(SceneView) scene, PathSettings path, PathState ray, ReusePixel pixel,
                          OUT(ReuseVertex) v, INOUT(vec3) L)
{
    v.woBefore = vec3(0.0f);
    v.lobesBefore.coat = 0.0f;
    v.lobesBefore.facet = 0.0f;
    v.lobesBefore.diffuse = 0.0f;
    v.lobesBefore.through = 1.0f;
    v.positionBefore = vec3(0.0f);
    v.nominal = 0.0f;
    v.c = 0.0f;
    if (pixel.slot == kNone) {
        L += shadeMiss(scene, path, ray);
        return false;
    }
    Hit hit;
    hit.slot = pixel.slot;
    hit.barycentrics = pixel.barycentrics;
    hit.t = dot(pointOfTriangle(scene, hit.slot, hit.barycentrics) - ray.origin, ray.direction);
    return prepareVertex(scene, path, hit, ray, v.vertex, L);
}

/// Takes over the history of a pixel of the frame before, which fits.
SHARED_FN void takeHistory(CameraData cameraBefore, vec3 positionBefore, float nominal,
                           INOUT(ReuseVertex) v)
{
    v.woBefore =
        toLocal(v.vertex.surface.frame, towardsCamera(cameraBefore, v.vertex.surface.position));
    v.lobesBefore = lobesAt(v.vertex.bsdf, v.woBefore);
    v.positionBefore = positionBefore;
    v.nominal = nominal;
    v.c = nominal / (nominal + 1.0f);
}

/// The share of the new integral that old samples answer for at a direction of densities q (old)
/// and p (new). One function for old samples and for candidates.
SHARED_FN float reuseShare(ReuseSettings settings, float c, float q, float p)
{
    if (settings.strategy == kReuseRa) return reuseAlpha(c, q, p);
    if (!usableDensity(q) || !usableDensity(p)) return 0.0f;
    if (settings.strategy == kReuseMis) return c * q / (c * q + (1.0f - c) * p);
    return settings.strategy == kReuseReweighting ? c : 0.0f;
}

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

/// The density with which the frame before would have drawn a direction (in the surface's frame).
SHARED_FN float densityBefore(IN(ReuseVertex) v, vec3 wi)
{
    if (!(v.nominal > 0.0f)) return 0.0f;
    vec3 unused;
    float q;
    evalPdfLobes(v.vertex.bsdf, v.lobesBefore, v.woBefore, wi, unused, q);
    return q;
}

/// f |cos| and the densities q and p of a direction (world, unit) at a first hit. False when no
/// light goes that way.
SHARED_FN bool evaluateAt(IN(ReuseVertex) v, vec3 wi, OUT(vec3) response, OUT(float) p,
                          OUT(float) q)
{
    const vec3 local = toLocal(v.vertex.surface.frame, wi);
    evalPdfLobes(v.vertex.bsdf, v.vertex.lobes, v.vertex.wo, local, response, p);
    q = densityBefore(v, local);
    float side;
    const bool goes = sideOf(v.vertex.surface, wi, local.z, side);
    response *= goes ? abs(local.z) : 0.0f;
    return goes;
}

/// Radiance that leaves the vertex towards where it is seen from, of light that comes from one
/// direction.
SHARED_FN vec3 reflectStored(IN(Vertex) vertex, uint direction, uint radiance)
{
    if (radiance == 0u || direction == kFrozenRadiance) return vec3(0.0f);
    const vec3 wi = unpackOct(direction);
    const vec3 local = toLocal(vertex.surface.frame, wi);
    float side;
    if (!sideOf(vertex.surface, wi, local.z, side)) return vec3(0.0f);
    vec3 f;
    float pdf;
    evalPdfLobes(vertex.bsdf, vertex.lobes, vertex.wo, local, f, pdf);
    return f * (abs(local.z) * unpackRgbe(radiance));
}

/// An old sample as the new first hit sees it.
struct ReuseView {
    vec3 F;          // the integrand
    float p;         // the density of its direction
    float u;         // absolute weight per solid angle, alpha included
    float perPlace;  // what it is multiplied by to be stored
};

/// Looks at an old sample from the new first hit. False when it is of no further use.
SHARED_FN bool viewOldSample(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                             IN(ReuseVertex) v, ReuseSample r, OUT(ReuseView) view)
{
    view.F = vec3(0.0f);
    view.p = 0.0f;
    view.u = 0.0f;
    view.perPlace = 1.0f;
    float share = 1.0f;
    if (!(r.u > 0.0f)) return false;
    PathState ray;
    ray.origin = v.vertex.surface.position;
    ray.beta = vec3(1.0f);
    ray.depth = 1u;
    Hit hit;
    hit.slot = r.slot;
    hit.barycentrics = r.place;
    hit.t = kInfinity;
    if (r.slot == kNone) {
        ray.direction = octDecode(r.place);
    } else {
        const vec3 a = xyz(fetchTriangleVertex(scene, r.slot, 0u));
        const vec3 e1 = xyz(fetchTriangleVertex(scene, r.slot, 1u)) - a;
        const vec3 e2 = xyz(fetchTriangleVertex(scene, r.slot, 2u)) - a;
        const vec3 n = normalize(cross(e1, e2));
        const vec3 toPlace = a + r.place.x * e1 + r.place.y * e2 - ray.origin;
        share = reconnection(toPlace, n, ray.origin, v.positionBefore);
        if (!(share > 0.0f)) return false;
        const float d2 = dot(toPlace, toPlace);
        hit.t = sqrt(d2);
        ray.direction = toPlace / hit.t;
        view.perPlace = d2 / abs(dot(n, ray.direction));
    }
    vec3 response;
    float q;
    const bool goes = evaluateAt(v, ray.direction, response, view.p, q);
    view.u = r.u / view.perPlace * (share * reuseShare(settings, v.c, q, view.p));
    if (!(view.u > 0.0f) || !(view.u < kInfinity)) return false;
    if (!goes) return true;  // dark here, but its density is not zero: it may be of use again
    ray.pdf = view.p;
    vec3 L = vec3(0.0f);
    if (r.slot == kNone) {
        L = shadeMiss(scene, path, ray);
    } else {
        Vertex far;
        if (prepareVertex(scene, path, hit, ray, far, L)) {
            L += ray.beta * (reflectStored(far, r.lightDirection, r.lightRadiance) +
                             reflectStored(far, r.nextDirection, r.nextRadiance));
            if (r.nextDirection == kFrozenRadiance) L += unpackRgbe(r.nextRadiance);
        }
    }
    view.F = response * L;
    return true;
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

/// The stream of another purpose at the same sample, for decisions that follow upon earlier ones:
/// its numbers do not know those of the frames before. A sequence that is well spread over frames
/// would be biased here, since what it gives depends on what it gave to the samples that are there.
SHARED_FN SampleStream decisionStream(SampleStream stream, uint purpose)
{
    stream.kind = kSamplerIndependent;
    stream.seed ^= purpose * 0x9e3779b9u;
    return stream;
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
    SampleStream proposals = stream;
    proposals.seed ^= kPurposeCandidates * 0x9e3779b9u;
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

/// A connection of a first hit to an emitter, drawn again from its numbers; its contribution has no
/// weight yet.
SHARED_FN ShadowRay viewLight(IN(SceneView) scene, PathSettings settings, IN(ReuseVertex) v,
                              ReuseLight r)
{
    PathState ray;
    ray.origin = v.vertex.surface.position;
    ray.direction = vec3(0.0f, 0.0f, 1.0f);
    ray.beta = vec3(1.0f);
    ray.pdf = 0.0f;
    ray.depth = 0u;
    return connectTo(scene, settings, r.emitter, pmfEmitter(scene, r.emitter),
                     unpackNumbers(r.numbers), ray, v.vertex);
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

// --- the passes, for one pixel ------------------------------------------------------------------

/// Adds an old sample that viewOldSample has found of use.
SHARED_FN void addOldSample(INOUT(ReuseSums) sums, ReuseView view)
{
    sums.around += view.u * view.F;
    sums.aroundSquares += view.u / view.p * view.F * view.F;
    sums.weightSum += view.u * view.p;
}

/// Adds an old connection, of the vertex's share: `r.v` is changed to what it weighs now.
SHARED_FN float addOldLight(IN(SceneView) scene, PathSettings path, IN(ReuseVertex) v,
                            INOUT(ReuseLight) r, INOUT(ReuseSums) sums)
{
    const vec3 F = viewLight(scene, path, v, r).contribution;
    r.v *= v.c;
    sums.direct += r.v * F;
    sums.directSquares += r.v * F * F;
    return r.v * luminance(F);
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
