// The path tracer's estimator, one text for GPU and CPU: unidirectional paths, next-event
// estimation, multiple importance sampling with the power heuristic (Veach 1997), Russian roulette.
// Devices only trace rays in between:
//   beginPath; loop { hit? shadeSurface : shadeMiss; trace the shadow ray; } until the path ends.
// shadeSurface is prepareVertex, connect, scatter. How a vertex chooses the direction it goes on in
// is the one pair sampleDirection / pdfDirection (directions.h); a method that chooses otherwise
// brings a pair of its own and nothing else.
// Thin smooth walls (panes) let light straight through: connections pass them, dimmed, and a path
// that does keeps the density of its last real vertex, so that what it meets behind them is weighed
// against connections as if they were not there. A passage still counts as a scattering event.
// Absorption is applied where a ray reaches the inner side of a solid; a shadow ray wholly inside
// one is not absorbed.
#ifndef REKINDLE_SHARED_PATH_H
#define REKINDLE_SHARED_PATH_H

#include "camera.h"
#include "lights.h"
#include "mis.h"
#include "vertex.h"

#ifndef REKINDLE_OWN_DIRECTIONS
#include "directions.h"
#endif

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
};

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
    uint passes;  // how many panes it may go through yet
};

/// Whether light goes straight through panes: nothing of them is in the code of other scenes.
SHARED_FN bool passesPanes(PathSettings settings)
{
    return FEATURE(kFeaturePanes) && settings.passesPanes != 0u;
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
    return hashUint(stream.pixel ^
                    hashUint(stream.index * 2u + shadow + 0x9e3779b9u * depth + stream.seed));
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
    return path;
}

SHARED_FN PathState beginPath(CameraData camera, PathSettings settings, uvec2 pixel,
                              SampleStream stream)
{
    const vec2 film = vec2(float(pixel.x), float(pixel.y)) + streamVec2(stream, kDimensionPixel);
    vec2 lens = vec2(0.5f, 0.5f);
    if (FEATURE(kFeatureThinLens) && camera.apertureRadius > 0.0f)
        lens = streamVec2(stream, kDimensionLens);
    vec3 origin;
    vec3 direction;
    cameraRay(camera, film, vec2(float(settings.imageWidth), float(settings.imageHeight)), lens,
              origin, direction);
    return pathAlong(origin, direction);
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
    return shadow;
}

/// Emission and absorption at a hit, and what connect and scatter need to know of it. False when
/// the path ends here.
SHARED_FN bool prepareVertex(IN(SceneView) scene, PathSettings settings, Hit hit,
                             INOUT(PathState) path, OUT(Vertex) vertex, INOUT(vec3) L)
{
    vertex.surface = makeSurfacePoint(scene, hit, path.direction);
    const Shading shading = evaluateMaterial(scene, vertex.surface, path.direction);
    if (FEATURE(kFeatureVolume) && vertex.surface.backFace != 0u &&
        (shading.inputs.flags & kMaterialVolume) != 0u) {
        path.beta *= exp(-hit.t * shading.absorption);
    }
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
    return offsetRay(s.position, side > 0.0f ? outside : -outside);
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
    shadow.passes = settings.maxDepth - 1u - path.depth;
    shadow.origin = originOnSide(vertex.surface, side);
    shadow.direction = e.wi;
    shadow.tMax = kDistant;
    if (e.distance < 0.5f * kDistant) {
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

/// Connects the vertex to one emitter; contribution zero when nothing can come of it.
SHARED_FN ShadowRay connect(IN(SceneView) scene, PathSettings settings, VertexNumbers numbers,
                            PathState path, IN(Vertex) vertex)
{
    if (!connects(settings, vertex)) return noShadowRay(vertex.surface.position);
    float pmf;
    const uint emitter = chooseEmitterIn(scene, settings, vertex.skyRegion, vertex.surface.position,
                                         receiverOf(settings, vertex), numbers.choice, pmf);
    if (!(pmf > 0.0f)) return noShadowRay(vertex.surface.position);
    return connectTo(scene, settings, emitter, pmf, numbers.light, path, vertex);
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
    shadow.contribution *= straightThrough(bsdf, wo);
    const vec3 behind = originOnSide(s, side);
    if (shadow.tMax < 1.0f) {
        shadow.direction -= behind - shadow.origin;
        shadow.tMax = connectionEnd(length(shadow.direction));
    }
    shadow.origin = behind;
    shadow.passes -= 1u;
    return maxComponent(shadow.contribution) > 0.0f;
}

/// Whether a path goes straight through a pane by `next`.
SHARED_FN bool goesStraight(PathSettings settings, IN(Vertex) vertex, BsdfSample next)
{
    const uint straight = kLobeDelta | kLobeTransmission;
    return passesPanes(settings) && (next.flags & straight) == straight && isPane(vertex.bsdf);
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

/// Draws a direction and follows it.
SHARED_FN bool scatter(IN(SceneView) scene, PathSettings settings, VertexNumbers numbers,
                       IN(Vertex) vertex, INOUT(PathState) path)
{
    BsdfSample next;
    return sampleDirection(scene, vertex, numbers, next) &&
           follow(settings, numbers, vertex, next, path);
}

/// One vertex of a path. Adds emission to L, sets the connection to an emitter, and moves `path` on
/// to the next ray; returns false when the path ends here (the shadow ray still counts).
SHARED_FN bool shadeSurface(IN(SceneView) scene, PathSettings settings, VertexNumbers numbers,
                            Hit hit, INOUT(PathState) path, OUT(ShadowRay) shadow, INOUT(vec3) L)
{
    Vertex vertex;
    if (!prepareVertex(scene, settings, hit, path, vertex, L)) {
        shadow = noShadowRay(vertex.surface.position);
        return false;
    }
    shadow = connect(scene, settings, numbers, path, vertex);
    return scatter(scene, settings, numbers, vertex, path);
}

SHARED_END

#endif
