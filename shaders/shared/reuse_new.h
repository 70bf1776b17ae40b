// A new path of sample reuse, in the steps that devices take one after the other: it begins at a
// first hit, where its direction is resampled with weight 1 - alpha, and a connection is made
// (beginNewPath); it goes on from vertex to vertex (extendNewPath), the first of which is its place
// and kept; and it ends (endNewPath), where what old samples answer for is taken off. From its
// place on the path is grey, so that what arrives can be told from what the surface makes of it.
#ifndef REKINDLE_SHARED_REUSE_NEW_H
#define REKINDLE_SHARED_REUSE_NEW_H

#include "reuse_path.h"

SHARED_BEGIN

/// What is kept of a new path's beginning until it ends.
struct ReuseTrail {
    vec3 direction;  // from the first hit, world
    float pdf;
    vec3 weight;        // of that direction: f |cos| / pdf
    float omega;        // that it was picked with
    float mean;         // of the weights of all candidates; 0: there is no path
    float alpha;        // before it is known where the ray ends
    vec3 emitted;       // by the place towards the first hit; 0 where nothing is met
    vec3 leaving;       // the same with what the place reflects of its connection
    vec3 beyond;        // what the place makes of what is gathered further on
    float perGathered;  // what is stored of that, as radiance that arrives; 0: as it leaves
    bool emits;         // the place shines
    bool bends;         // a mirror or glass: from elsewhere it shows something else
};

SHARED_CONST uint kReuseTrailWords = 8u;  // with the record, from one kernel to the next
SHARED_CONST uint kReuseStateWords = 4u;  // of a path under way

SHARED_FN ReuseTrail noReuseTrail()
{
    ReuseTrail trail;
    trail.direction = vec3(0.0f);
    trail.pdf = 0.0f;
    trail.weight = vec3(0.0f);
    trail.omega = 0.0f;
    trail.mean = 0.0f;
    trail.alpha = 0.0f;
    trail.emitted = vec3(0.0f);
    trail.leaving = vec3(0.0f);
    trail.beyond = vec3(0.0f);
    trail.perGathered = 0.0f;
    trail.emits = false;
    trail.bends = false;
    return trail;
}

/// Numbers for the stochastic rounding of what is stored.
SHARED_FN vec3 roundingNumbers(SampleStream stream, uint which)
{
    stream = decisionStream(stream, kPurposeRounding);
    const vec2 a = streamVec2(stream, 2u * which);
    return vec3(a.x, a.y, streamVec2(stream, 2u * which + 1u).x);
}

// A chance for every candidate: whether a sample may be reused is only known once its ray has been
// traced, and what may not is not left to old samples.
SHARED_CONST float kReuseLeastOmega = 0.05f;

/// Candidates that pay: several only where the lobe has moved by a good part of its width.
SHARED_FN uint candidatesFor(ReuseSettings settings, IN(ReuseVertex) v)
{
    const bool augments = settings.strategy == kReuseRa || settings.strategy == kReuseRejection;
    if (!augments || !(v.c > 0.0f)) return 1u;
    const float turn = lobeTurn(v.history.width, length(v.vertex.wo - v.woBefore));
    return turn > kReuseTurnsALot ? candidatesOf(settings) : 1u;
}

/// Picks the direction of a new path among candidates; `next` becomes the pick. A single candidate
/// is drawn by `numbers`, as where nothing is reused.
SHARED_FN void drawNewDirection(IN(SceneView) scene, ReuseSettings settings, IN(ReuseVertex) v,
                                VertexNumbers numbers, SampleStream stream, OUT(BsdfSample) next,
                                INOUT(ReuseTrail) trail)
{
    next.wi = vec3(0.0f);
    next.pdf = 0.0f;
    next.weight = vec3(0.0f);
    next.flags = 0u;
    float sum = 0.0f;
    const uint candidates = candidatesFor(settings, v);
    const SampleStream proposals = purposeStream(stream, kPurposeCandidates);
    const SampleStream selection = decisionStream(stream, kPurposeSelection);
    for (uint t = 0u; t < candidates; ++t) {
        if (candidates > 1u) {
            numbers.bsdf = streamVec2(proposals, 2u * t);
            numbers.lobe = streamVec2(proposals, 2u * t + 1u);
        }
        BsdfSample z;
        if (!sampleDirection(scene, v.vertex, numbers, z)) continue;
        float alpha = 0.0f;
        if (v.c > 0.0f && z.pdf > 0.0f)
            alpha = reuseShare(settings, v.c,
                               densityBefore(v, toWorld(v.vertex.surface.frame, z.wi)), z.pdf);
        const float omega = max(1.0f - alpha, kReuseLeastOmega);
        sum += omega;
        const float xi = candidates == 1u ? 0.0f : streamFloat(selection, t);
        if (xi * sum < omega) {
            next = z;
            trail.omega = omega;
            trail.alpha = alpha;
        }
    }
    trail.mean = sum / float(candidates);
}

/// Draws an emitter by its power, whatever the place: what is stored of a connection must not
/// depend on it.
SHARED_FN uint drawEmitter(IN(SceneView) scene, PathSettings path, VertexNumbers numbers,
                           OUT(float) pmf)
{
    pmf = 1.0f;
    if (!FEATURE(kFeatureManyEmitters)) return 0u;
    return chooseEmitter(scene, path.emitterCount, numbers.choice, pmf);
}

/// Connects the first hit to an emitter, for a sample that is kept where the connection is open.
SHARED_FN void connectFirstHit(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                               IN(ReuseVertex) v, IN(PathState) ray, VertexNumbers numbers,
                               SampleStream stream, INOUT(ReuseNew) result, INOUT(ReuseTally) tally)
{
    if (!connects(path, v.vertex)) return;
    float pmf;
    const uint emitter = drawEmitter(scene, path, numbers, pmf);
    // What is kept is drawn on a grid, so that it can be drawn again.
    const uint grid = packNumbers(numbers.light);
    const ShadowRay shadow =
        connectTo(scene, path, emitter, pmf, unpackNumbers(grid), ray, v.vertex);
    if (!(maxComponent(shadow.contribution) > 0.0f)) return;
    ++tally.shadowRays;
    if (!wayIsOpen(scene, shadow, alphaSeed(stream, 0u, 1u))) return;
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

/// Begins a new path, and makes a new connection: `ray`, which is pathFromHere, moves on to where
/// the path's place is to be found. False where there is no path.
SHARED_FN bool beginNewPath(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                            IN(ReuseVertex) v, SampleStream stream, INOUT(PathState) ray,
                            INOUT(ReuseTrail) trail, INOUT(ReuseNew) result,
                            INOUT(ReuseTally) tally)
{
    VertexNumbers numbers = drawVertexNumbers(stream, 0u);
    connectFirstHit(scene, path, settings, v, ray, numbers, stream, result, tally);
    BsdfSample next;
    drawNewDirection(scene, settings, v, numbers, stream, next, trail);
    numbers.lobe.y = 0.0f;  // always goes on
    if (!(trail.mean > 0.0f) || !(maxComponent(next.weight) > 0.0f) ||
        !follow(path, numbers, v.vertex, next, ray)) {
        trail.mean = 0.0f;
        return false;
    }
    trail.direction = ray.direction;
    trail.pdf = next.pdf;
    trail.weight = next.weight;
    ray.beta = vec3(1.0f);
    return true;
}

/// Whether light that leaves a surface hardly depends on the direction over the width of a pixel.
SHARED_FN bool isRough(Bsdf b)
{
    return ((b.parts & kBsdfMicrofacet) == 0u || b.alpha >= kReuseRough) &&
           ((b.parts & kBsdfCoat) == 0u || b.coatAlpha >= kReuseRough);
}

/// Follows the path to its next vertex; false where it ends. The first vertex it comes to is its
/// place.
SHARED_FN bool meetNext(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                        SampleStream stream, INOUT(PathState) ray, OUT(Vertex) vertex,
                        INOUT(vec3) gathered, INOUT(ReuseTrail) trail, INOUT(ReuseSample) record)
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
    trail.bends = scatters && (isUnbiased(settings) ? hasDelta(vertex.bsdf) : isDelta(vertex.bsdf));
    record.slot = hit.slot;
    record.place = packPlace(hit.barycentrics);
    trail.emitted = gathered;
    trail.emits = vertex.surface.emitter != kNone || maxComponent(gathered) > 0.0f;
    const bool exact = isUnbiased(settings) || keepsArrivals(settings) || !isRough(vertex.bsdf);
    if (trail.emits || (scatters && exact)) record.radiance = kReuseEvaluated;
    return scatters;
}

/// Connects a vertex of the new path to an emitter; of its place it is kept how.
SHARED_FN void connectNext(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                           IN(Vertex) vertex, IN(PathState) ray, VertexNumbers numbers,
                           SampleStream stream, INOUT(vec3) gathered, INOUT(ReuseSample) record,
                           INOUT(ReuseTally) tally)
{
    if (!connects(path, vertex)) return;
    float pmf;
    const uint emitter = drawEmitter(scene, path, numbers, pmf);
    const ShadowRay shadow = connectTo(scene, path, emitter, pmf, numbers.light, ray, vertex);
    if (!(maxComponent(shadow.contribution) > 0.0f)) return;
    ++tally.shadowRays;
    if (keepsArrivals(settings) && ray.depth == 1u) record.lightDirection = packOct(shadow.wi);
    if (!wayIsOpen(scene, shadow, alphaSeed(stream, ray.depth, 1u))) return;
    gathered += shadow.contribution;
    if (ray.depth > 1u) return;
    record.lightDirection = packOct(shadow.wi);
    record.lightRadiance = packRgbe(shadow.incident, roundingNumbers(stream, 0u));
}

/// Extends a new path by one vertex: meets it, connects it, and goes on; false where the path ends.
/// `importance` is the largest component of its first weight, for roulette at its place. What is
/// `gathered` before the place is left is the trail's.
SHARED_FN bool extendNewPath(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                             float importance, SampleStream stream, INOUT(PathState) ray,
                             INOUT(vec3) gathered, INOUT(ReuseTrail) trail,
                             INOUT(ReuseSample) record, INOUT(ReuseTally) tally)
{
    const bool atPlace = ray.depth == 1u;
    ++tally.closestRays;
    Vertex vertex;
    bool goes = meetNext(scene, path, settings, stream, ray, vertex, gathered, trail, record);
    if (goes) {
        const VertexNumbers numbers = drawVertexNumbers(stream, ray.depth);
        connectNext(scene, path, settings, vertex, ray, numbers, stream, gathered, record, tally);
        BsdfSample next;
        goes = sampleDirection(scene, vertex, numbers, next) && maxComponent(next.weight) > 0.0f;
        if (goes) {
            if (atPlace) {
                trail.bends = trail.bends || next.pdf == 0.0f;
                ray.beta *= importance;
            }
            const float entering = maxComponent(ray.beta * next.weight);
            goes = follow(path, numbers, vertex, next, ray);
            if (goes && atPlace) {
                const float grey = maxComponent(ray.beta);
                trail.beyond = ray.beta / (importance * grey);
                // grey / entering is one over the chance to survive
                trail.perGathered = next.pdf == 0.0f ? 0.0f : 1.0f / (entering * next.pdf);
                record.nextDirection = packOct(ray.direction);
                ray.beta = vec3(grey);
            }
        }
    }
    if (atPlace) {
        trail.leaving = gathered;
        gathered = vec3(0.0f);
    }
    return goes;
}

/// Makes a sample one of its direction and what comes from there, without a place, as where nothing
/// is met. Not where it shines: what counts of that depends on the density of the direction, and is
/// evaluated beside what is reflected there.
SHARED_FN void keepDirection(ReuseSettings settings, INOUT(ReuseTrail) trail,
                             INOUT(ReuseSample) record)
{
    if (!keepsDirections(settings) || record.slot == kNone) return;
    if (trail.emits) {
        record.radiance = 0u;
        record.nextDirection = trail.bends ? kReuseBent : 0u;
        return;
    }
    record = noReuseSample();
    record.place = packOct(trail.direction);
    trail.bends = false;
}

/// The share of a new sample that is left to old ones, by where it ends; `perPlace` becomes what
/// its weight is multiplied by to be stored, and `wayBefore` how it lies from the old first hit.
SHARED_FN float shareOfNew(IN(SceneView) scene, ReuseSettings settings, IN(ReuseVertex) v,
                           IN(ReuseTrail) trail, ReuseSample record, OUT(float) perPlace,
                           OUT(vec3) wayBefore)
{
    float alpha = trail.alpha;
    if (trail.bends && !keepsDirections(settings)) alpha = 0.0f;
    perPlace = 1.0f;
    const vec3 position = v.vertex.surface.position;
    vec3 way;
    vec3 n;
    Triangle t;
    const bool ends = wayToPlace(scene, record, position, way, t, n);
    if (!ends) way = trail.direction;
    wayBefore = way;
    uint triangle = kNone;
    if (ends) {
        triangle = floatAsUint(t.v0.w);
        wayBefore = way + (position - v.positionBefore);
        const float d2 = dot(way, way);
        perPlace = d2 * sqrt(d2) / abs(dot(n, way));
        // What cannot be carried along is not left to old samples.
        if (alpha > 0.0f &&
            !(maySlide(settings, v) && hasSlid(t, position, v.positionBefore, way, wayBefore)))
            alpha *= trail.bends && position != v.positionBefore
                         ? 0.0f
                         : reconnection(way, n, position, v.positionBefore);
    }
    const bool old = wayIsOld(scene, settings, v, way, ends, triangle) &&
                     arrivingIsOld(scene, settings, position + way, record);
    return old ? alpha : 0.0f;
}

/// Ends a new path that has gathered light beyond its place: completes its record, and says what it
/// counts beside old samples.
SHARED_FN void endNewPath(IN(SceneView) scene, ReuseSettings settings, IN(ReuseVertex) v,
                          vec3 gathered, SampleStream stream, INOUT(ReuseTrail) trail,
                          INOUT(ReuseNew) result, INOUT(ReuseTally) tally)
{
    keepDirection(settings, trail, result.record);
    const vec3 reflected = trail.beyond * gathered;
    const vec3 L = trail.leaving + reflected;
    if (result.record.nextDirection != 0u)
        result.record.nextRadiance =
            packRgbe(trail.perGathered > 0.0f ? trail.perGathered * gathered : reflected,
                     roundingNumbers(stream, 1u));
    if (result.record.radiance != kReuseEvaluated)
        result.record.radiance =
            packRgbe(max(L - trail.emitted, vec3(0.0f)), roundingNumbers(stream, 2u));
    result.around = trail.weight * L;
    float perPlace;
    vec3 wayBefore;
    float alpha = shareOfNew(scene, settings, v, trail, result.record, perPlace, wayBefore);
    const float whole = trail.mean / (trail.omega * v.rays);
    const bool ends = result.record.slot != kNone;
    if (alpha > 0.0f && newSampleHid(scene, settings, v, wayBefore, ends, stream, tally)) {
        result.lost += whole * alpha * luminance(result.around);
        alpha = 0.0f;
    }
    result.scale = whole * (1.0f - alpha);
    const float u = result.scale / trail.pdf * perPlace;
    const bool lasts =
        trail.pdf > 0.0f && u < kInfinity && (!trail.bends || keepsDirections(settings));
    result.record.u = lasts ? u : 0.0f;
}

/// Takes a whole new path from a first hit, and a new connection.
SHARED_FN ReuseNew takePath(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                            IN(ReuseVertex) v, SampleStream stream, INOUT(ReuseTally) tally)
{
    ReuseNew result = noReuseNew();
    ReuseTrail trail = noReuseTrail();
    PathState ray = pathFromHere(v);
    vec3 gathered = vec3(0.0f);
    bool goes = beginNewPath(scene, path, settings, v, stream, ray, trail, result, tally);
    if (!goes) return result;
    const float importance = maxComponent(trail.weight);
    while (goes)
        goes = extendNewPath(scene, path, settings, importance, stream, ray, gathered, trail,
                             result.record, tally);
    endNewPath(scene, settings, v, gathered, stream, trail, result, tally);
    return result;
}

/// All that comes of a way which mirrors and glass have not taken (restOfChain, restSettings).
SHARED_FN vec3 takeRest(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                        PathState ray, SampleStream stream, INOUT(ReuseTally) tally)
{
    ReuseTrail trail = noReuseTrail();
    ReuseSample record = noReuseSample();
    vec3 gathered = vec3(0.0f);
    bool goes = true;
    while (goes)
        goes =
            extendNewPath(scene, path, settings, 1.0f, stream, ray, gathered, trail, record, tally);
    return gathered;
}

SHARED_END

#endif
