// Next-event estimation: the connection of a vertex to a point of an emitter, weighted against
// directions that the surface draws (multiple importance sampling, Veach 1997), and its way
// straight through thin panes.
#ifndef REKINDLE_SHARED_CONNECTION_H
#define REKINDLE_SHARED_CONNECTION_H

#include "mis.h"
#include "path_state.h"

#ifndef REKINDLE_OWN_DIRECTIONS
#include "directions.h"
#endif

SHARED_BEGIN

/// The connection to an emitter. `contribution` is what it adds if nothing is between; zero: no
/// need to trace. `direction` is not of unit length: `tMax` counts in its lengths. Before the
/// surface has had its say: `incident` is the radiance from `wi` (unit, world) over its density,
/// MIS weight included; contribution = beta f |cos| incident. `pdf` is the density with which
/// emitters are sampled in that direction, the choice among them included; 0 for emitters that
/// directions cannot meet.
struct ShadowRay {
    vec3 origin;
    vec3 direction;
    float tMax;
    vec3 contribution;
    vec3 wi;
    vec3 incident;
    float pdf;
    uint passes;   // how many panes it may go through yet
    vec3 through;  // what those on its way have let through; `incident` knows nothing of it
};

/// How far along a connection of that length is asked whether it is open: not to its very end,
/// where the emitter itself would be met, but no more than a thousandth of a unit (a scene has a
/// radius of 1 to 100) is left out.
SHARED_FN float connectionEnd(float distance)
{
    return max(0.9999f, 1.0f - 1.0e-3f / distance);
}

/// No connection: nothing to trace.
SHARED_FN ShadowRay noShadowRay(vec3 origin)
{
    ShadowRay shadow;
    shadow.origin = origin;
    shadow.direction = vec3(0.0f, 0.0f, 1.0f);
    shadow.tMax = 0.0f;
    shadow.contribution = vec3(0.0f, 0.0f, 0.0f);
    shadow.wi = shadow.direction;
    shadow.incident = vec3(0.0f, 0.0f, 0.0f);
    shadow.pdf = 0.0f;
    shadow.passes = 0u;
    shadow.through = vec3(1.0f, 1.0f, 1.0f);
    return shadow;
}

/// `incident` behind the panes on the way.
SHARED_FN vec3 incidentBehind(IN(ShadowRay) shadow)
{
    return FEATURE(kFeaturePanes) ? shadow.incident * shadow.through : shadow.incident;
}

/// Connects the vertex to the point that `u` picks of an emitter, which was itself chosen with
/// probability `pmf`; contribution zero when nothing can come of it.
SHARED_FN ShadowRay connectTo(IN(SceneView) scene, PathSettings settings, uint emitter, float pmf,
                              vec2 u, PathState path, IN(Vertex) vertex)
{
    ShadowRay shadow = noShadowRay(vertex.surface.position);
    EmitterSample e;
    const uint region = drawsSkyByPlace(settings) ? vertex.skyRegion : 0u;
    if (!sampleEmitter(scene, settings, emitter, vertex.surface.position, region, u, e))
        return shadow;
    if (settings.strategy == kStrategyBsdf && e.pdf > 0.0f) return shadow;

    const vec3 wi = toLocal(vertex.surface.frame, e.wi);
    float side;
    if (!sideOf(vertex.surface, e.wi, wi.z, side)) return shadow;
    const bool distant = !(e.distance < 0.5f * kDistant);
    // What is infinitely far is in no solid.
    if (FEATURE(kFeatureVolume) && !distant)
        e.radiance *= transmittance(scene, mediumBeyond(path.medium, vertex, side), e.distance);
    vec3 f;
    float pdf;
    evalPdfLobes(vertex.bsdf, vertex.lobes, vertex.wo, wi, f, pdf);
    float weight = 1.0f / pmf;
    if (e.pdf > 0.0f) {
        weight /= e.pdf;
        if (settings.strategy == kStrategyMis) {
            pdf = pdfDirection(scene, vertex, wi, pdf);
            weight *= powerHeuristic(pmf * e.pdf, pdf);
        }
    }
    shadow.contribution =
        clampIndirect(settings, path.depth + 1u, path.beta * f * e.radiance * (abs(wi.z) * weight));
    shadow.wi = e.wi;
    shadow.incident = e.radiance * weight;
    shadow.pdf = pmf * e.pdf;
    shadow.passes = mostPanes(settings, path.depth, e.pdf);
    shadow.origin = originOnSide(vertex.surface, side);
    shadow.direction = e.wi;
    shadow.tMax = kDistant;
    if (!distant) {
        // Aimed anew from the shifted origin: along the old direction an emitter seen edge-on would
        // block itself.
        shadow.direction = (vertex.surface.position - shadow.origin) + e.distance * e.wi;
        shadow.tMax = connectionEnd(e.distance);
    }
    return shadow;
}

/// Whether a connection from the vertex can bring anything: there is light, and the surface has a
/// lobe that is no delta.
SHARED_FN bool connects(PathSettings settings, IN(Vertex) vertex)
{
    return settings.emitterCount != 0u && !isDelta(vertex.bsdf);
}

/// The side from which light counts at a vertex, as emitters are chosen for it.
SHARED_FN uint receiverOf(PathSettings settings, IN(Vertex) vertex)
{
    if (!choosesByPlace(settings) || (vertex.bsdf.parts & kBsdfTransmission) != 0u)
        return kAllSides;
    return packReceiver(vertex.surface.frame[2]);
}

/// Begins the choice of the emitter that the vertex is connected to; finishChoice makes it.
SHARED_FN EmitterChoice beginConnection(IN(SceneView) scene, PathSettings settings,
                                        VertexNumbers numbers, IN(Vertex) vertex)
{
    if (!connects(settings, vertex)) return emitterChosen(0u, 0.0f);
    return beginChoiceIn(scene, settings, vertex.skyRegion, numbers.choice);
}

/// Chooses the emitter that the vertex is connected to.
SHARED_FN EmitterChoice chooseConnection(IN(SceneView) scene, PathSettings settings,
                                         VertexNumbers numbers, IN(Vertex) vertex)
{
    return finishChoice(scene, vertex.surface.position, receiverOf(settings, vertex),
                        beginConnection(scene, settings, numbers, vertex));
}

/// Connects the vertex to the emitter that was chosen for it; contribution zero when nothing can
/// come of it.
SHARED_FN ShadowRay connectChosen(IN(SceneView) scene, PathSettings settings, EmitterChoice choice,
                                  VertexNumbers numbers, PathState path, IN(Vertex) vertex)
{
    if (!(choice.pmf > 0.0f)) return noShadowRay(vertex.surface.position);
    return connectTo(scene, settings, choice.emitter, choice.pmf, numbers.light, path, vertex);
}

/// Connects the vertex to one emitter; contribution zero when nothing can come of it.
SHARED_FN ShadowRay connect(IN(SceneView) scene, PathSettings settings, VertexNumbers numbers,
                            PathState path, IN(Vertex) vertex)
{
    return connectChosen(scene, settings, chooseConnection(scene, settings, numbers, vertex),
                         numbers, path, vertex);
}

/// Whether the triangle in a slot may be a pane somewhere.
SHARED_FN bool mayBePane(IN(SceneView) scene, uint slot)
{
    const uint stored = findTriangle(scene, slot).slot;
    const uint material =
        floatAsUint(fetchTriangleVertex(scene, stored, 1u).w) & ~kTriangleAlphaBit;
    return fetchMaterial(scene, material, 2u).w > 0.0f;
}

/// Takes a connection that has met a surface through it, if that is a pane: it then goes on behind,
/// by as much dimmer. False where it ends.
SHARED_FN bool passPane(IN(SceneView) scene, Hit hit, INOUT(ShadowRay) shadow)
{
    if (shadow.passes == 0u) return false;
    SurfacePoint s = makeSurfacePoint(scene, hit, shadow.wi);
    const Shading shading = evaluateMaterial(scene, s, shadow.wi);
    if ((shading.inputs.flags & kMaterialUnlit) != 0u) return false;
    const Bsdf bsdf = makeBsdf(shading.inputs);
    const vec3 wo = toLocal(s.frame, -shadow.wi);
    float side;
    if (!isPane(bsdf) || !sideOf(s, shadow.wi, -wo.z, side)) return false;
    const vec3 through = straightThrough(bsdf, wo);
    shadow.contribution *= through;
    shadow.through *= through;
    const vec3 behind = originOnSide(s, side);
    if (shadow.tMax < 1.0f) {
        shadow.direction -= behind - shadow.origin;
        shadow.tMax = connectionEnd(length(shadow.direction));
    }
    shadow.origin = behind;
    shadow.passes -= 1u;
    return maxComponent(shadow.contribution) > 0.0f;
}

SHARED_END

#endif
