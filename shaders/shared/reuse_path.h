// Reweighting-Augmentation at the first hits of a moving camera, one text for GPU and CPU. A pixel
// keeps samples of the light that comes to its first hit. When the camera has moved, each old one
// is looked at from the new first hit (reuse_shift.h) and answers for the share alpha of the new
// integral; the rest comes from new paths, whose first direction is resampled with weight 1 -
// alpha. After S. Wang, "Efficient Sample Usage in Photo-Realistic Rendering" (2022), chapter 8.
// What differs: in the fast mode samples that end at nothing that shines keep their direction and
// radiance alone, mirrors and glass included (keepDirection); elsewhere what arrives at the far end
// is stored as radiance by direction, so that a shiny far surface is seen from the new side;
// samples carry absolute weights (shared/reuse.h); visibility of old samples is asked for again as
// far as the settings say (reuse_visibility.h): where it is not, the picture is too bright where
// something has come in between.
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

/// What the ray of a pixel meets, for later passes, and at which distance; without history yet.
SHARED_FN ReusePixel findFirstHit(IN(SceneView) scene, PathState ray, SampleStream stream,
                                  OUT(float) t)
{
    t = 0.0f;
    ReusePixel pixel;
    pixel.slot = kNone;
    pixel.barycentrics = vec2(0.0f);
    pixel.history = packHistory(noHistory());
    Hit hit;
    if (traceWay(scene, ray.origin, ray.direction, alphaSeed(stream, 0u, 0u), hit)) {
        pixel.slot = hit.slot;
        pixel.barycentrics = hit.barycentrics;
        t = hit.t;
    }
    return pixel;
}

/// Numbers for the stochastic rounding of what is stored.
SHARED_FN vec3 roundingNumbers(SampleStream stream, uint which)
{
    stream = decisionStream(stream, kPurposeRounding);
    const vec2 a = streamVec2(stream, 2u * which);
    return vec3(a.x, a.y, streamVec2(stream, 2u * which + 1u).x);
}

/// A direction for a new path: the pick of resampling among candidates.
struct ReuseDraw {
    BsdfSample next;
    float omega;  // the weight that it was picked with
    float mean;   // of the weights of all candidates; 0: nothing to trace
    float alpha;  // before it is known where the ray ends
};

SHARED_FN ReuseDraw noReuseDraw()
{
    ReuseDraw draw;
    draw.next.wi = vec3(0.0f);
    draw.next.pdf = 0.0f;
    draw.next.weight = vec3(0.0f);
    draw.next.flags = 0u;
    draw.omega = 0.0f;
    draw.mean = 0.0f;
    draw.alpha = 0.0f;
    return draw;
}

// A chance for every candidate: whether a sample may be reused is only known once its ray has been
// traced, and what may not is not left to old samples.
SHARED_CONST float kReuseLeastOmega = 0.05f;

/// Picks a direction at a vertex of the new path; old samples of `v` answer for directions at its
/// first vertex only. A single candidate is drawn by `numbers`, as where nothing is reused.
SHARED_FN ReuseDraw drawNewDirection(IN(SceneView) scene, ReuseSettings settings, IN(ReuseVertex) v,
                                     IN(Vertex) vertex, bool first, VertexNumbers numbers,
                                     SampleStream stream, uint candidates)
{
    ReuseDraw draw = noReuseDraw();
    float sum = 0.0f;
    const SampleStream proposals = purposeStream(stream, kPurposeCandidates);
    const SampleStream selection = decisionStream(stream, kPurposeSelection);
    for (uint t = 0u; t < candidates; ++t) {
        if (candidates > 1u) {
            numbers.bsdf = streamVec2(proposals, 2u * t);
            numbers.lobe = streamVec2(proposals, 2u * t + 1u);
        }
        BsdfSample z;
        if (!sampleDirection(scene, vertex, numbers, z)) continue;
        float alpha = 0.0f;
        if (first && v.c > 0.0f && z.pdf > 0.0f)
            alpha = reuseShare(settings, v.c, densityBefore(v, toWorld(vertex.surface.frame, z.wi)),
                               z.pdf);
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
    const bool augments = settings.strategy == kReuseRa || settings.strategy == kReuseRejection;
    if (!augments || !(v.c > 0.0f)) return 1u;
    const float turn = lobeTurn(v.history.width, length(v.vertex.wo - v.woBefore));
    return turn > kReuseTurnsALot ? candidatesOf(settings) : 1u;
}

/// The place where a new path ends its first way, and how the path goes on from there. From the
/// place on the path is grey, so that what arrives can be told from what the surface makes of it.
struct ReusePlace {
    vec3 position;
    vec3 normal;
    uint triangle;
    vec3 emitted;      // radiance towards the first hit by emission
    vec3 leaving;      // and by connection, too
    vec3 throughput;   // of the place, for what arrives from further on
    float grey;        // of the path after it; 0: the path has ended
    float perArrival;  // what is stored of radiance that arrives
    bool emits;
    bool bends;  // a mirror or glass: from elsewhere it shows something else
};

/// Whether light that leaves a surface hardly depends on the direction over the width of a pixel.
SHARED_FN bool isRough(Bsdf b)
{
    return ((b.parts & kBsdfMicrofacet) == 0u || b.alpha >= kReuseRough) &&
           ((b.parts & kBsdfCoat) == 0u || b.coatAlpha >= kReuseRough);
}

SHARED_FN ReusePlace noReusePlace()
{
    ReusePlace place;
    place.position = vec3(0.0f);
    place.normal = vec3(0.0f);
    place.triangle = kNone;
    place.emitted = vec3(0.0f);
    place.leaving = vec3(0.0f);
    place.throughput = vec3(0.0f);
    place.grey = 0.0f;
    place.perArrival = 0.0f;
    place.emits = false;
    place.bends = false;
    return place;
}

/// Turns the path grey when it leaves its place; `entering` is its throughput before roulette.
SHARED_FN void leavePlace(float importance, float entering, BsdfSample next, vec3 leaving,
                          INOUT(PathState) path, INOUT(ReusePlace) place, INOUT(ReuseSample) record)
{
    place.leaving = leaving;
    place.throughput = path.beta / importance;
    place.grey = maxComponent(path.beta);
    path.beta = vec3(place.grey);
    record.nextDirection = packOct(path.direction);
    // grey / entering is one over the chance to survive
    place.perArrival = next.pdf == 0.0f ? 0.0f : place.grey / (entering * next.pdf);
}

/// Makes a sample one of its direction `wi` (world) and what comes from there, without a place, as
/// where nothing is met. Not where it shines: what counts of that depends on the density of the
/// direction, and is evaluated beside what is reflected there.
SHARED_FN void keepDirection(ReuseSettings settings, vec3 wi, INOUT(ReusePlace) place,
                             INOUT(ReuseSample) record)
{
    if (!keepsDirections(settings) || record.slot == kNone) return;
    if (place.emits) {
        record.radiance = 0u;
        record.nextDirection = place.bends ? kReuseBent : 0u;
        return;
    }
    record = noReuseSample();
    record.place = packOct(wi);
    place.bends = false;
}

/// Radiance that comes to the first hit, from what was gathered since the path left its place;
/// completes the record but for its weight.
SHARED_FN vec3 endNewPath(SampleStream stream, vec3 gathered, ReusePlace place,
                          INOUT(ReuseSample) record)
{
    vec3 L = gathered;
    if (place.grey > 0.0f) {
        const vec3 arriving = gathered / place.grey;
        const vec3 reflected = place.throughput * arriving;
        L = place.leaving + reflected;
        record.nextRadiance =
            packRgbe(place.perArrival > 0.0f ? arriving * place.perArrival : reflected,
                     roundingNumbers(stream, 1u));
    }
    if (record.radiance != kReuseEvaluated)
        record.radiance = packRgbe(max(L - place.emitted, vec3(0.0f)), roundingNumbers(stream, 2u));
    return L;
}

/// What the new sample counts, and what is stored of that.
SHARED_FN void weighNewSample(IN(SceneView) scene, ReuseSettings settings, IN(ReuseVertex) v,
                              ReuseDraw draw, ReusePlace place, vec3 L, SampleStream stream,
                              INOUT(ReuseNew) result, INOUT(ReuseTally) tally)
{
    float alpha = draw.alpha;
    float perPlace = 1.0f;
    const bool ends = result.record.slot != kNone;
    if (place.bends && !keepsDirections(settings)) alpha = 0.0f;
    vec3 way = toWorld(v.vertex.surface.frame, draw.next.wi);
    vec3 wayBefore = way;
    if (ends) {
        const vec3 position = v.vertex.surface.position;
        way = place.position - position;
        wayBefore = place.position - v.positionBefore;
        const float d2 = dot(way, way);
        perPlace = d2 * sqrt(d2) / abs(dot(place.normal, way));
        // What cannot be carried along is not left to old samples.
        if (alpha > 0.0f &&
            !(maySlide(settings, v) && hasSlid(triangleInSlot(scene, result.record.slot), position,
                                               v.positionBefore, way, wayBefore)))
            alpha *= place.bends && position != v.positionBefore
                         ? 0.0f
                         : reconnection(way, place.normal, position, v.positionBefore);
    }
    if (alpha > 0.0f && !(wayIsOld(scene, settings, v, way, ends, place.triangle) &&
                          arrivingIsOld(scene, settings, place.position, result.record)))
        alpha = 0.0f;
    const float whole = draw.mean / (draw.omega * v.rays);
    result.around = draw.next.weight * L;
    if (alpha > 0.0f && newSampleHid(scene, settings, v, wayBefore, ends, stream, tally)) {
        result.lost += whole * alpha * luminance(result.around);
        alpha = 0.0f;
    }
    result.scale = whole * (1.0f - alpha);
    const float u = result.scale / draw.next.pdf * perPlace;
    const bool lasts =
        draw.next.pdf > 0.0f && u < kInfinity && (!place.bends || keepsDirections(settings));
    result.record.u = lasts ? u : 0.0f;
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
/// and 1 are left out: there what has not moved at all would lose its pixel by rounding.
SHARED_FN vec2 tapNumbers(ReuseSettings settings, SampleStream stream)
{
    if ((settings.flags & kReuseFollows) != 0u) return vec2(0.5f);
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

/// Keeps a connection of the first hit that is open.
SHARED_FN void keepNewLight(IN(SceneView) scene, ReuseSettings settings, IN(ReuseVertex) v,
                            IN(ShadowRay) shadow, uint emitter, uint grid, SampleStream stream,
                            INOUT(ReuseNew) result, INOUT(ReuseTally) tally)
{
    float share = lightShare(scene, settings, v, shadow);
    if (share > 0.0f && newLightHid(scene, settings, v, shadow, stream, tally)) {
        result.lost += share / v.rays * luminance(shadow.contribution);
        share = 0.0f;
    }
    result.direct = shadow.contribution;
    result.light.emitter = emitter;
    result.light.numbers = grid;
    result.light.v = (1.0f - share) / v.rays;
}

/// Connects a vertex of the new path, `ray.depth` from the first hit, to an emitter.
SHARED_FN void connectNew(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                          IN(ReuseVertex) v, IN(Vertex) vertex, IN(PathState) ray,
                          VertexNumbers numbers, SampleStream stream, INOUT(vec3) gathered,
                          INOUT(ReuseNew) result, INOUT(ReuseTally) tally)
{
    if (!connects(path, vertex)) return;
    float pmf = 1.0f;
    uint emitter = 0u;
    if (FEATURE(kFeatureManyEmitters))
        emitter = chooseEmitter(scene, path.emitterCount, numbers.choice, pmf);
    // What is kept is drawn on a grid, so that it can be drawn again.
    const uint grid = packNumbers(numbers.light);
    const vec2 u = ray.depth == 0u ? unpackNumbers(grid) : numbers.light;
    const ShadowRay shadow = connectTo(scene, path, emitter, pmf, u, ray, vertex);
    if (!(maxComponent(shadow.contribution) > 0.0f)) return;
    ++tally.shadowRays;
    if (keepsArrivals(settings) && ray.depth == 1u)
        result.record.lightDirection = packOct(shadow.wi);
    if (!wayIsOpen(scene, shadow, alphaSeed(stream, ray.depth, 1u))) return;
    if (ray.depth == 0u) {
        keepNewLight(scene, settings, v, shadow, emitter, grid, stream, result, tally);
    } else {
        gathered += shadow.contribution;
    }
    if (ray.depth == 1u) {
        result.record.lightDirection = packOct(shadow.wi);
        result.record.lightRadiance = packRgbe(shadow.incident, roundingNumbers(stream, 0u));
    }
}

/// Follows the path to its next vertex; false where it ends. The first vertex it comes to is the
/// place of the sample.
SHARED_FN bool meetNext(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                        SampleStream stream, INOUT(PathState) ray, INOUT(Vertex) vertex,
                        INOUT(vec3) gathered, INOUT(ReusePlace) place, INOUT(ReuseSample) record)
{
    Hit hit;
    if (!traceWay(scene, ray.origin, ray.direction, alphaSeed(stream, ray.depth, 0u), hit)) {
        gathered += shadeMiss(scene, path, ray);
        if (ray.depth > 1u) return false;
        record.place = packOct(ray.direction);
        if (path.environmentEmitter != kNone || path.sunEmitter != kNone)
            record.radiance = kReuseEvaluated;
        return false;
    }
    const bool scatters = prepareVertex(scene, path, hit, ray, vertex, gathered);
    if (ray.depth > 1u) return scatters;
    // Where one lobe of several has no density, it is the choice of a lobe that decides; exactly it
    // would have to be known how likely the choice was before.
    place.bends = scatters && (isUnbiased(settings) ? hasDelta(vertex.bsdf) : isDelta(vertex.bsdf));
    record.slot = hit.slot;
    record.place = packPlace(hit.barycentrics);
    place.position = vertex.surface.position;
    place.normal = vertex.surface.normal;
    place.triangle = vertex.surface.triangle;
    place.emitted = gathered;
    place.emits = vertex.surface.emitter != kNone || maxComponent(gathered) > 0.0f;
    const bool exact = isUnbiased(settings) || keepsArrivals(settings) || !isRough(vertex.bsdf);
    if (place.emits || (scatters && exact)) record.radiance = kReuseEvaluated;
    return scatters;
}

/// Takes a new path from a first hit, and a new connection, where `ray` is pathFromHere; or a way
/// that is not taken (restOfChain) to its end, with `around` as all that comes of it. One loop over
/// the vertices of the path, the first hit among them, so that there is one piece of code for each
/// thing that is done at a vertex: kernels of which the compiler makes copies take longer to
/// compile, and to run.
SHARED_FN ReuseNew takePath(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                            IN(ReuseVertex) v, PathState ray, SampleStream stream,
                            INOUT(ReuseTally) tally)
{
    ReuseNew result = noReuseNew();
    ReuseDraw first = noReuseDraw();
    ReusePlace place = noReusePlace();
    vec3 gathered = vec3(0.0f);
    Vertex vertex = v.vertex;
    const bool fromHere = ray.depth == 0u;
    while (true) {
        const uint i = ray.depth;  // 0: the first hit, 1: the place
        if (i > 0u) {
            ++tally.closestRays;
            if (!meetNext(scene, path, settings, stream, ray, vertex, gathered, place,
                          result.record))
                break;
        }
        VertexNumbers numbers = drawVertexNumbers(stream, i);
        connectNew(scene, path, settings, v, vertex, ray, numbers, stream, gathered, result, tally);
        const uint candidates = i == 0u ? candidatesFor(settings, v) : 1u;
        const ReuseDraw draw =
            drawNewDirection(scene, settings, v, vertex, i == 0u, numbers, stream, candidates);
        if (!(draw.mean > 0.0f) || !(maxComponent(draw.next.weight) > 0.0f)) break;
        if (i == 0u) {
            first = draw;
            numbers.lobe.y = 0.0f;  // always goes on
        }
        const float importance = maxComponent(first.next.weight);
        if (i == 1u && draw.next.pdf == 0.0f) place.bends = true;
        if (i == 1u) ray.beta *= importance;  // for roulette alone
        const float entering = maxComponent(ray.beta * draw.next.weight);
        if (!follow(path, numbers, vertex, draw.next, ray)) break;
        if (i == 0u) ray.beta = vec3(1.0f);
        if (i == 1u) {
            leavePlace(importance, entering, draw.next, gathered, ray, place, result.record);
            gathered = vec3(0.0f);
        }
    }
    if (!fromHere) {
        result.around = gathered;
    } else if (ray.depth > 0u) {
        keepDirection(settings, toWorld(v.vertex.surface.frame, first.next.wi), place,
                      result.record);
        const vec3 L = endNewPath(stream, gathered, place, result.record);
        weighNewSample(scene, settings, v, first, place, L, stream, result, tally);
    }
    return result;
}

SHARED_END

#endif
