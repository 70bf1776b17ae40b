// A new path of sample reuse, in the steps that devices take one after the other: it begins at a
// first hit, where its direction is resampled with weight 1 - alpha (beginNewPath); it goes on from
// vertex to vertex (extendNewPath), the first of which is its place and kept; and it ends
// (endNewPath), where what old samples answer for is taken off. The first two propose connections,
// which count where they are open (takeFirstConnection, takeConnection). From its place on the path
// is grey, so that what arrives can be told from what the surface makes of it.
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

// A chance for every candidate: whether a sample may be reused is only known once its ray has been
// traced, and what may not is not left to old samples.
SHARED_CONST float kReuseLeastOmega = 0.05f;

/// Candidates that pay: several only where the lobe has moved by a good part of its width. One in
/// the passes that follow in a view: their pictures are means of new paths alone (plainRadiance).
SHARED_FN uint candidatesFor(ReuseSettings settings, IN(ReuseVertex) v)
{
    const bool augments = settings.strategy == kReuseRa || settings.strategy == kReuseRejection;
    const bool follows = (settings.flags & kReuseFollows) != 0u;
    if (!augments || follows || !(v.c > 0.0f)) return 1u;
    const float turn = lobeTurn(v.history.width, lobesTurned(v));
    return turn > kReuseTurnsALot ? candidatesOf(settings) : 1u;
}

/// The numbers of candidate `t`: a rank-one lattice (multiples of powers of the root of
/// x^4 = x + 1, after M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018)
/// moved by those of the first. Resampling asks only that each candidate by itself is drawn as a
/// direction is; spread evenly they show it more of the lobe.
SHARED_FN VertexNumbers candidateNumbers(VertexNumbers first, uint t)
{
    const vec3 apart = vec3(0.8191725134f, 0.6710436067f, 0.5497004779f);
    const vec3 moved = fract(vec3(first.bsdf, first.lobe.x) + float(t) * apart);
    first.bsdf = vec2(moved.x, moved.y);
    first.lobe.x = moved.z;
    return first;
}

/// Picks the direction of a new path among candidates; `next` becomes the pick. The first candidate
/// is the direction that is drawn where nothing is reused.
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
    float xi = 0.0f;
    if (candidates > 1u) xi = streamFloat(decisionStream(stream, kPurposeSelection), 0u);
    for (uint t = 0u; t < candidates; ++t) {
        BsdfSample z;
        if (!sampleDirection(scene, v.vertex, candidateNumbers(numbers, t), z)) continue;
        float alpha = 0.0f;
        if (v.c > 0.0f && z.pdf > 0.0f)
            alpha = reuseShare(settings, v.c,
                               densityBefore(v, toWorld(v.vertex.surface.frame, z.wi)), z.pdf);
        const float omega = max(1.0f - alpha, kReuseLeastOmega);
        sum += omega;
        // One number decides all: what is left of it is again even.
        const float chance = omega / sum;
        const bool picked = xi < chance;
        xi = picked ? xi / chance : (xi - chance) / (1.0f - chance);
        if (picked) {
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

/// Proposes a connection of the first hit, whose sample has no weight until it is found open.
SHARED_FN ShadowRay proposeFirstConnection(IN(SceneView) scene, PathSettings path,
                                           IN(ReuseVertex) v, IN(PathState) ray,
                                           VertexNumbers numbers, INOUT(ReuseLight) light)
{
    if (!connects(path, v.vertex)) return noShadowRay(v.vertex.surface.position);
    float pmf;
    light.emitter = drawEmitter(scene, path, numbers, pmf);
    // What is kept is drawn on a grid, so that it can be drawn again.
    light.numbers = packNumbers(numbers.light);
    return connectTo(scene, path, light.emitter, pmf, unpackNumbers(light.numbers), ray, v.vertex);
}

/// Takes the connection that beginNewPath has proposed, and which is open.
SHARED_FN void takeFirstConnection(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                                   IN(ReuseVertex) v, IN(ShadowRay) shadow, SampleStream stream,
                                   INOUT(ReuseNew) result, INOUT(ReuseTally) tally)
{
    float share = lightShare(scene, settings, v, shadow);
    if (share > 0.0f && newLightHid(scene, path, settings, v, shadow, stream, tally)) {
        result.lost += share / v.rays * luminance(shadow.contribution);
        share = 0.0f;
    }
    result.direct = shadow.contribution;
    result.light.v = (1.0f - share) / v.rays;
    if (FEATURE(kFeaturePanes) && shadow.through != vec3(1.0f))
        result.light.through =
            packThrough(shadow.through, roundingNumbers(stream, kRoundsNewLight));
}

/// Begins a new path, and proposes a connection (one that brings nothing is none): `ray`, which is
/// pathFromHere, moves on to where the path's place is to be found. False where there is no path.
SHARED_FN bool beginNewPath(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                            IN(ReuseVertex) v, SampleStream stream, INOUT(PathState) ray,
                            INOUT(ReuseTrail) trail, INOUT(ReuseLight) light, OUT(ShadowRay) shadow)
{
    VertexNumbers numbers = drawVertexNumbers(stream, 0u);
    shadow = proposeFirstConnection(scene, path, v, ray, numbers, light);
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
SHARED_FN bool isRough(IN(Bsdf) b)
{
    return ((b.parts & kBsdfMicrofacet) == 0u || b.alpha >= kReuseRough) &&
           ((b.parts & kBsdfCoat) == 0u || b.coatAlpha >= kReuseRough);
}

/// What the path meets; false where it ends. The first vertex it comes to is its place.
SHARED_FN bool meetNext(IN(SceneView) scene, PathSettings path, ReuseSettings settings, Hit hit,
                        INOUT(PathState) ray, OUT(Vertex) vertex, INOUT(vec3) gathered,
                        INOUT(ReuseTrail) trail, INOUT(ReuseSample) record)
{
    if (hit.slot == kNone) {
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

/// Proposes a connection of a vertex; of the path's place its direction is kept in any case where
/// arrivals are.
SHARED_FN ShadowRay proposeConnection(IN(SceneView) scene, PathSettings path,
                                      ReuseSettings settings, IN(Vertex) vertex, IN(PathState) ray,
                                      VertexNumbers numbers, INOUT(ReuseSample) record)
{
    if (!connects(path, vertex)) return noShadowRay(vertex.surface.position);
    float pmf;
    const uint emitter = drawEmitter(scene, path, numbers, pmf);
    const ShadowRay shadow = connectTo(scene, path, emitter, pmf, numbers.light, ray, vertex);
    if (keepsArrivals(settings) && ray.depth == 1u && maxComponent(shadow.contribution) > 0.0f)
        record.lightDirection = packOct(shadow.wi);
    return shadow;
}

/// Takes the connection that extendNewPath has proposed at a vertex of that depth, and which is
/// open; of the path's place it is kept how it came.
SHARED_FN void takeConnection(IN(ShadowRay) shadow, uint depth, SampleStream stream,
                              INOUT(vec3) gathered, INOUT(ReuseTrail) trail,
                              INOUT(ReuseSample) record)
{
    if (depth > 1u) {
        gathered += shadow.contribution;
        return;
    }
    trail.leaving += shadow.contribution;
    record.lightDirection = packOct(shadow.wi);
    record.lightRadiance =
        packRgbe(incidentBehind(shadow), roundingNumbers(stream, kRoundsEmitter));
}

/// Extends a new path by what it has met (kNone: nothing): proposes a connection there (one that
/// brings nothing is none), and goes on; false where the path ends. `importance` is the largest
/// component of its first weight, for roulette at its place. What is `gathered` before the place is
/// left is the trail's.
SHARED_FN bool extendNewPath(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                             float importance, SampleStream stream, Hit hit, INOUT(PathState) ray,
                             INOUT(vec3) gathered, INOUT(ReuseTrail) trail,
                             INOUT(ReuseSample) record, OUT(ShadowRay) shadow)
{
    const bool atPlace = ray.depth == 1u;
    Vertex vertex;
    shadow = noShadowRay(ray.origin);
    bool goes = meetNext(scene, path, settings, hit, ray, vertex, gathered, trail, record);
    if (atPlace) {
        trail.leaving = gathered;
        gathered = vec3(0.0f);
    }
    if (!goes) return false;
    const VertexNumbers numbers = drawVertexNumbers(stream, ray.depth);
    shadow = proposeConnection(scene, path, settings, vertex, ray, numbers, record);
    BsdfSample next;
    if (!sampleDirection(scene, vertex, numbers, next)) return false;
    if (!(maxComponent(next.weight) > 0.0f)) return false;
    if (atPlace) {
        trail.bends = trail.bends || next.pdf == 0.0f;
        ray.beta *= importance;
    }
    const float entering = maxComponent(ray.beta * next.weight);
    if (!follow(path, numbers, vertex, next, ray)) return false;
    if (atPlace) {
        const float grey = maxComponent(ray.beta);
        trail.beyond = ray.beta / (importance * grey);
        // grey / entering is one over the chance to survive
        trail.perGathered = next.pdf == 0.0f ? 0.0f : 1.0f / (entering * next.pdf);
        record.nextDirection = packOct(ray.direction);
        ray.beta = vec3(grey);
    }
    return true;
}

/// extendNewPath with the rays that it takes.
SHARED_FN bool traceNewPath(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                            float importance, SampleStream stream, INOUT(PathState) ray,
                            INOUT(vec3) gathered, INOUT(ReuseTrail) trail,
                            INOUT(ReuseSample) record, INOUT(ReuseTally) tally)
{
    const uint depth = ray.depth;
    Hit hit;
    ++tally.closestRays;
    if (!traceWay(scene, ray.origin, ray.direction, alphaSeed(stream, depth, 0u), hit))
        hit.slot = kNone;
    ShadowRay shadow;
    const bool goes = extendNewPath(scene, path, settings, importance, stream, hit, ray, gathered,
                                    trail, record, shadow);
    if (maxComponent(shadow.contribution) > 0.0f) {
        if (wayIsOpen(scene, shadow, alphaSeed(stream, depth, 1u), tally))
            takeConnection(shadow, depth, stream, gathered, trail, record);
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
                     roundingNumbers(stream, kRoundsNext));
    if (result.record.radiance != kReuseEvaluated)
        result.record.radiance =
            packRgbe(max(L - trail.emitted, vec3(0.0f)), roundingNumbers(stream, kRoundsLeaving));
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

/// beginNewPath with the ray that its connection takes.
SHARED_FN bool beginTracedPath(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                               IN(ReuseVertex) v, SampleStream stream, INOUT(PathState) ray,
                               INOUT(ReuseTrail) trail, INOUT(ReuseNew) result,
                               INOUT(ReuseTally) tally)
{
    ShadowRay shadow;
    const bool goes =
        beginNewPath(scene, path, settings, v, stream, ray, trail, result.light, shadow);
    if (maxComponent(shadow.contribution) > 0.0f) {
        if (wayIsOpen(scene, shadow, alphaSeed(stream, 0u, 1u), tally))
            takeFirstConnection(scene, path, settings, v, shadow, stream, result, tally);
    }
    return goes;
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
            traceNewPath(scene, path, settings, 1.0f, stream, ray, gathered, trail, record, tally);
    return gathered;
}

SHARED_END

#endif
