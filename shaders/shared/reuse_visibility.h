// Visibility between first hits and the places of samples, asked for again after a move. Two
// questions make reconnection unbiased: does the new first hit see the place of an old sample, and
// did the old first hit see the place of a new one? Where the second answer is no, nothing old
// answers for the new sample (alpha = 0). Both may be asked for some samples only; what the answers
// would have changed elsewhere is then an estimate of the bias that is left.
//
// A device says how rays are traced:
//   bool traceWay(SceneView, vec3 origin, vec3 direction, uint seed, out Hit)
//   bool wayIsOpen(SceneView, inout ShadowRay, uint seed, inout ReuseTally)
// the latter through as many panes as the connection may pass, by which it is dimmed.
#ifndef REKINDLE_SHARED_REUSE_VISIBILITY_H
#define REKINDLE_SHARED_REUSE_VISIBILITY_H

#include "reuse_view.h"

SHARED_BEGIN

/// Rays that a pass has cost.
struct ReuseTally {
    uint closestRays;
    uint shadowRays;
};

#ifdef __cplusplus
bool traceWay(const SceneView& scene, vec3 origin, vec3 direction, uint seed, Hit& hit);
bool wayIsOpen(const SceneView& scene, ShadowRay& shadow, uint seed, ReuseTally& tally);
#else
bool traceWay(SceneView scene, vec3 origin, vec3 direction, uint seed, out Hit hit);
bool wayIsOpen(SceneView scene, inout ShadowRay shadow, uint seed, inout ReuseTally tally);
#endif

/// The stream of another purpose at the same sample of a path.
SHARED_FN SampleStream purposeStream(SampleStream stream, uint purpose)
{
    stream.seed ^= purpose * 0x9e3779b9u;  // as makeStream
    return stream;
}

/// The same for decisions that follow upon earlier ones: its numbers do not know those of the
/// frames before. A sequence that is well spread over frames would be biased here, since what it
/// gives depends on what it gave to the samples that are there.
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

// What is rounded: light that comes to a place from an emitter and by the path's continuation, what
// leaves it, and what panes let through of a new connection and of old ones.
SHARED_CONST uint kRoundsEmitter = 0u;
SHARED_CONST uint kRoundsNext = 1u;
SHARED_CONST uint kRoundsLeaving = 2u;
SHARED_CONST uint kRoundsNewLight = 3u;
SHARED_CONST uint kRoundsOldLight = 4u;  // + its number

// What is asked about: old samples, old connections, the new ones of each kind.
SHARED_CONST uint kAskOldSample = 0u;  // + its number
SHARED_CONST uint kAskOldLight = 16u;  // + its number
SHARED_CONST uint kAskNewSample = 32u;
SHARED_CONST uint kAskNewLight = 33u;

/// Whether visibility is asked for again, of what `which` counts.
SHARED_FN bool asksAgain(ReuseSettings settings, SampleStream stream, uint which)
{
    if (!FEATURE(kFeatureAsksVisibility) || !(settings.visibility > 0.0f)) return false;
    return streamFloat(decisionStream(stream, kPurposeVisibility), which) < settings.visibility;
}

// By how much a connection through panes may seem to have changed that is what it was: its colour
// has been rounded, and the pane is seen from a place nearby.
SHARED_CONST float kRoundingOfPanes = 1.0f / 64.0f;

SHARED_FN uint askSeed(SampleStream stream, uint which)
{
    return alphaSeed(stream, 64u + which, 1u);
}

/// Whether a first hit at `position` of the surface `s` sees what lies in a direction (unit) at
/// some distance, through so many panes; kInfinity: whether it sees anything there.
SHARED_FN bool seesPlace(IN(SceneView) scene, IN(SurfacePoint) s, vec3 position, vec3 direction,
                         float distance, uint panes, uint seed, INOUT(ReuseTally) tally)
{
    float side;
    sideOf(s, direction, 1.0f, side);
    ShadowRay way = noShadowRay(position);
    way.origin =
        offsetRay(position, (s.backFace != 0u) == (side > 0.0f) ? -s.normal : s.normal, s.offset);
    way.direction = direction;
    way.wi = direction;
    way.contribution = vec3(1.0f);
    way.passes = panes;
    way.tMax = kDistant;
    if (distance < 0.5f * kDistant) {
        way.direction = (position - way.origin) + distance * direction;
        way.tMax = connectionEnd(distance);
    }
    return wayIsOpen(scene, way, seed, tally);
}

/// Whether the place of an old sample is hidden now, as far as this is asked.
SHARED_FN bool oldSampleHides(IN(SceneView) scene, ReuseSettings settings, IN(ReuseVertex) v,
                              IN(ReuseView) view, SampleStream stream, uint i,
                              INOUT(ReuseTally) tally)
{
    const uint which = kAskOldSample + i;
    if (!asksAgain(settings, stream, which)) return false;
    return !seesPlace(scene, v.vertex.surface, v.vertex.surface.position, view.direction,
                      view.distance, 0u, askSeed(stream, which), tally);
}

/// Whether the place of a new sample, `wayBefore` from the old first hit, was hidden from there.
/// `ends`: false where the way is a direction in which nothing is met.
SHARED_FN bool newSampleHid(IN(SceneView) scene, ReuseSettings settings, IN(ReuseVertex) v,
                            vec3 wayBefore, bool ends, SampleStream stream, INOUT(ReuseTally) tally)
{
    if (!asksAgain(settings, stream, kAskNewSample)) return false;
    const float distance = length(wayBefore);
    return !seesPlace(scene, v.vertex.surface, v.positionBefore, wayBefore / distance,
                      ends ? distance : kInfinity, 0u, askSeed(stream, kAskNewSample), tally);
}

/// The same of a new connection to an emitter, `shadow`, that is open. Through which panes the old
/// first hit saw that light does not matter: what an old connection brings is what comes now.
SHARED_FN bool newLightHid(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                           IN(ReuseVertex) v, IN(ShadowRay) shadow, SampleStream stream,
                           INOUT(ReuseTally) tally)
{
    if (!asksAgain(settings, stream, kAskNewLight)) return false;
    const bool ends = shadow.tMax < 1.0f;
    const vec3 to = ends ? shadow.origin + shadow.direction - v.positionBefore : shadow.wi;
    const float distance = length(to);
    return !seesPlace(scene, v.vertex.surface, v.positionBefore, to / distance,
                      ends ? distance : kInfinity, mostPanes(path, 0u, shadow.pdf),
                      askSeed(stream, kAskNewLight), tally);
}

/// Whether the way of old connection number `i` is open, which is asked; `F`, what it was taken to
/// bring before its weight, becomes what it does bring. What panes let through that it had not to
/// pass before, or the other way round, is wrong as light that is hidden is.
SHARED_FN bool takeOldWay(IN(SceneView) scene, SampleStream stream, uint i, INOUT(ShadowRay) shadow,
                          INOUT(ReuseLight) r, INOUT(vec3) F, INOUT(ReuseSums) sums,
                          INOUT(ReuseTally) tally)
{
    const float taken = luminance(r.v * F);
    if (!wayIsOpen(scene, shadow, askSeed(stream, kAskOldLight + i), tally)) {
        sums.leaked += taken;
        return false;
    }
    if (!FEATURE(kFeaturePanes)) return true;
    F = shadow.contribution;
    r.through = packThrough(shadow.through, roundingNumbers(stream, kRoundsOldLight + i));
    const float tooMuch = taken - luminance(r.v * F);
    if (abs(tooMuch) < kRoundingOfPanes * taken) return true;
    sums.leaked += max(tooMuch, 0.0f);
    sums.lost += max(-tooMuch, 0.0f);
    return true;
}

/// Adds old connection number `i`, of the vertex's share: `r.v` is changed to what it weighs now.
/// Returns what it brings (v F).
SHARED_FN vec3 addOldLight(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                           IN(ReuseVertex) v, SampleStream stream, uint i, INOUT(ReuseLight) r,
                           INOUT(ReuseSums) sums, INOUT(ReuseTally) tally)
{
    ShadowRay shadow = viewLight(scene, path, v, r);
    vec3 F = shadow.contribution;
    if (FEATURE(kFeaturePanes)) F *= unpackThrough(r.through);
    r.v *= lightShare(scene, settings, v, shadow);
    const bool asks = r.v * maxComponent(F) > 0.0f && asksAgain(settings, stream, kAskOldLight + i);
    if (asks && !takeOldWay(scene, stream, i, shadow, r, F, sums, tally)) {
        r.v = 0.0f;
        return vec3(0.0f);
    }
    const vec3 brings = r.v * F;
    sums.direct += brings;
    sums.directSquares += r.v * F * F;
    return brings;
}

SHARED_END

#endif
