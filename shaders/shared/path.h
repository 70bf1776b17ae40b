// The path tracer's estimator, one text for GPU and CPU: unidirectional paths, next-event
// estimation, multiple importance sampling with the power heuristic (Veach 1997), Russian roulette.
// Devices only trace rays in between:
//   beginPath; loop { hit? shadeSurface : shadeMiss; trace the shadow ray; } until the path ends.
// shadeSurface is prepareVertex, then leaveVertex. How a vertex chooses the direction it goes on in
// is the one pair sampleDirection / pdfDirection (directions.h); a method that chooses otherwise
// brings a pair of its own and nothing else.
// Thin smooth walls (panes) let light straight through: connections pass them, dimmed, and a path
// that does keeps the density of its last real vertex, so that what it meets behind them is weighed
// against connections as if they were not there. A passage still counts as a scattering event.
// Solids absorb on every way through them that ends somewhere, connections within one included.
#ifndef REKINDLE_SHARED_PATH_H
#define REKINDLE_SHARED_PATH_H

#include "connection.h"

SHARED_BEGIN

/// Weight of emission that was met by following a sampled direction; `emitterPdf` is the density
/// with which next-event estimation would have found the same point, choice among emitters
/// included.
SHARED_FN float emissionWeight(PathSettings settings, float pdf, float emitterPdf)
{
    if (pdf == 0.0f || settings.strategy == kStrategyBsdf) return 1.0f;
    if (settings.strategy == kStrategyLight) return emitterPdf > 0.0f ? 0.0f : 1.0f;
    return powerHeuristic(pdf, emitterPdf);
}

/// Radiance that a ray which hit nothing brings home.
SHARED_FN vec3 shadeMiss(IN(SceneView) scene, PathSettings settings, PathState path)
{
    vec3 L = vec3(0.0f, 0.0f, 0.0f);
    if (FEATURE(kFeatureEnvironment) && settings.environmentEmitter != kNone) {
        float density = 0.0f;
        if (path.pdf > 0.0f && settings.strategy != kStrategyBsdf) {
            density = pmfEnvironmentIn(scene, settings, path.skyRegion) *
                      pdfEnvironment(scene, settings, path.skyRegion, path.direction);
        }
        L += emissionWeight(settings, path.pdf, density) *
             environmentRadiance(scene, settings, path.direction);
    }
    if (FEATURE(kFeatureSun) && settings.sunEmitter != kNone) {
        const Emitter sun = fetchEmitter(scene, settings.sunEmitter);
        const float density = pdfSun(sun, path.direction);
        if (density > 0.0f) {
            const float pmf = pmfEmitter(scene, settings.sunEmitter) *
                              shareBesideSky(scene, settings, path.skyRegion);
            L += emissionWeight(settings, path.pdf, pmf * density) * sun.radiance;
        }
    }
    return clampIndirect(settings, path.depth, path.beta * L);
}

/// Emission of the surface at `s`, weighted against next-event estimation from the path's previous
/// vertex.
SHARED_FN vec3 shadeEmission(IN(SceneView) scene, PathSettings settings, PathState path, Hit hit,
                             SurfacePoint s, vec3 emission)
{
    float density = 0.0f;
    if (path.pdf > 0.0f && s.emitter != kNone && settings.strategy != kStrategyBsdf) {
        const Triangle lamp = triangleInSlot(scene, hit.slot);
        const vec3 from = lastVertex(path);
        const float distance = FEATURE(kFeaturePanes) ? path.passed + hit.t : hit.t;
        density = pmfEmitterIn(scene, settings, path.skyRegion, s.emitter, from, path.departure) *
                  pdfTriangleEmitter(xyz(lamp.v0), xyz(lamp.v1), xyz(lamp.v2), from, path.direction,
                                     distance);
    }
    return clampIndirect(settings, path.depth,
                         emissionWeight(settings, path.pdf, density) * path.beta * emission);
}

/// Emission and absorption at a hit, and what connect and scatter need to know of it. False when
/// the path ends here.
SHARED_FN bool prepareVertex(IN(SceneView) scene, PathSettings settings, Hit hit,
                             INOUT(PathState) path, OUT(Vertex) vertex, INOUT(vec3) L)
{
    vertex.surface = makeSurfacePoint(scene, hit, path.direction);
    const Shading shading = evaluateMaterial(scene, vertex.surface, path.direction);
    if (FEATURE(kFeatureVolume))
        path.beta *=
            transmittanceTo(scene, vertex.surface, shading.inputs.flags, hit.t, path.medium);
    // An unlit surface shows its colour to who looks at it, in mirrors and through glass, too, and
    // lights nothing: no connection would ever look for it.
    const bool unlit = (shading.inputs.flags & kMaterialUnlit) != 0u;
    if (FEATURE(kFeatureEmissiveTriangles) && maxComponent(shading.emission) > 0.0f &&
        !(unlit && path.pdf > 0.0f)) {
        L += shadeEmission(scene, settings, path, hit, vertex.surface, shading.emission);
    }
    if (path.depth >= settings.maxDepth || unlit) return false;
    vertex.bsdf = makeBsdf(shading.inputs);
    vertex.wo = toLocal(vertex.surface.frame, -path.direction);
    vertex.lobes = lobesAt(vertex.bsdf, vertex.wo);
    vertex.skyRegion = 0u;
    if (drawsSkyByPlace(settings))
        vertex.skyRegion = findSkyRegion(scene, vertex.surface.position, vertex.surface.frame[2]);
    return true;
}

/// Whether a path goes straight through a pane by `next`.
SHARED_FN bool goesStraight(PathSettings settings, IN(Vertex) vertex, BsdfSample next)
{
    const uint straight = kLobeDelta | kLobeTransmission;
    return FEATURE(kFeaturePanes) && settings.passesPanes == kPanesPass &&
           (next.flags & straight) == straight && isPane(vertex.bsdf);
}

/// Moves the path on to the ray that leaves the vertex in the direction `next`; false when nothing
/// goes on.
SHARED_FN bool leave(PathSettings settings, IN(Vertex) vertex, BsdfSample next,
                     INOUT(PathState) path)
{
    const vec3 wi = toWorld(vertex.surface.frame, next.wi);
    float side;
    if (!sideOf(vertex.surface, wi, next.wi.z, side)) return false;
    path.beta *= next.weight;
    path.depth += 1u;
    const vec3 from = path.origin;
    path.origin = originOnSide(vertex.surface, side);
    path.medium = mediumBeyond(path.medium, vertex, side);
    if (goesStraight(settings, vertex, next)) {
        path.passed += dot(path.origin - from, path.direction);
        return maxComponent(path.beta) > 0.0f;
    }
    path.passed = 0.0f;
    path.direction = wi;
    path.pdf = next.pdf;
    path.departure = departFrom(path.departure, receiverOf(settings, vertex));
    if (drawsSkyByPlace(settings)) path.skyRegion = vertex.skyRegion;
    if (FEATURE(kFeatureTransmission) && next.wi.z < 0.0f && (vertex.bsdf.parts & kBsdfSolid) != 0u)
        path.departure = refractDeparture(path.departure, vertex.bsdf.eta);
    return maxComponent(path.beta) > 0.0f;
}

/// Russian roulette where a path leaves; `survival` is the probability with which it goes on.
SHARED_FN bool survivesByThroughput(PathSettings settings, float number, INOUT(PathState) path,
                                    OUT(float) survival)
{
    survival = 1.0f;
    if (path.depth < settings.rouletteDepth) return true;
    // The root keeps more of the dim paths than the throughput itself would: measured, error^2
    // times time falls by 6 % in a Cornell box and by 15 to 25 % in a white stairwell. What
    // refraction takes from radiance it gives back where the path leaves the solid.
    const float scale = FEATURE(kFeatureTransmission) ? 1.0f / radianceScale(path.departure) : 1.0f;
    survival = min(sqrt(scale * maxComponent(path.beta)), 1.0f);
    if (!(number < survival)) return false;
    path.beta *= 1.0f / survival;
    return true;
}

/// The same as `leave`, but that the path may end by chance, too.
SHARED_FN bool follow(PathSettings settings, VertexNumbers numbers, IN(Vertex) vertex,
                      BsdfSample next, INOUT(PathState) path)
{
    float survival;
    return leave(settings, vertex, next, path) &&
           survivesByThroughput(settings, numbers.lobe.y, path, survival);
}

/// Sets the connection to an emitter that has been chosen, and moves `path` on to the next ray;
/// returns false when the path ends here (the shadow ray still counts).
SHARED_FN bool leaveVertex(IN(SceneView) scene, PathSettings settings, EmitterChoice choice,
                           VertexNumbers numbers, IN(Vertex) vertex, INOUT(PathState) path,
                           OUT(ShadowRay) shadow)
{
    BsdfSample next;
    const bool goes = sampleDirection(scene, vertex, numbers, next);
    shadow = connectChosen(scene, settings, choice, numbers, path, vertex);
    return goes && follow(settings, numbers, vertex, next, path);
}

/// One vertex of a path: adds emission to L, the rest is leaveVertex.
SHARED_FN bool shadeSurface(IN(SceneView) scene, PathSettings settings, VertexNumbers numbers,
                            Hit hit, INOUT(PathState) path, OUT(ShadowRay) shadow, INOUT(vec3) L)
{
    Vertex vertex;
    if (!prepareVertex(scene, settings, hit, path, vertex, L)) {
        shadow = noShadowRay(vertex.surface.position);
        return false;
    }
    const EmitterChoice choice = chooseConnection(scene, settings, numbers, vertex);
    return leaveVertex(scene, settings, choice, numbers, vertex, path, shadow);
}

SHARED_END

#endif
