// Old samples, looked at from a first hit that has moved: each is carried along (reuse_shift.h),
// and the surfaces at both ends are evaluated for the new directions. Nothing is traced here; what
// is traced anew is in reuse_new.h.
#ifndef REKINDLE_SHARED_REUSE_VIEW_H
#define REKINDLE_SHARED_REUSE_VIEW_H

#include "path.h"
#include "reuse.h"
#include "reuse_history.h"
#include "reuse_shift.h"
#include "reuse_sums.h"

SHARED_BEGIN

// GGX width from which on the light that leaves a surface is kept as it is: from frame to frame a
// first hit moves by less than a pixel, which turns the direction by much less than the lobe is
// wide.
SHARED_CONST float kReuseRough = 0.25f;

/// A first hit, and how the samples of the frame before look at it.
struct ReuseVertex {
    Vertex vertex;
    uint medium;             // through which the camera sees it
    uint moved;              // the moved piece that it lies on (motion.h); kNone: it rests
    mat3 frameBefore;        // of the surface where the frame before met it
    vec3 woBefore;           // from there towards its camera, in that frame
    vec3 normalBefore;       // geometric, on the side of that camera
    Bsdf bsdfBefore;         // of the surface there: textures differ from place to place
    LobeChoice lobesBefore;  // at woBefore
    vec3 positionBefore;     // of the first hit that the history belongs to, in that frame
    vec3 beta;               // of the way from the camera
    ReuseHistory history;
    float rays;  // n: new paths that are due
    float c;     // N / (N + n); 0 without history
};

/// The first hit as the camera sees it; adds what is seen directly to L. False where nothing is
/// scattered.
SHARED_FN bool beginReuse(IN(SceneView) scene, PathSettings path, PathState ray, ReusePixel pixel,
                          OUT(ReuseVertex) v, INOUT(vec3) L)
{
    v.moved = kNone;
    v.frameBefore = mat3(1.0f);
    v.woBefore = vec3(0.0f);
    v.normalBefore = vec3(0.0f);
    v.lobesBefore.coat = 0.0f;
    v.lobesBefore.facet = 0.0f;
    v.lobesBefore.diffuse = 0.0f;
    v.lobesBefore.through = 1.0f;
    v.positionBefore = vec3(0.0f);
    v.medium = kNone;
    v.beta = ray.beta;
    v.history = noHistory();
    v.rays = 1.0f;
    v.c = 0.0f;
    if (pixel.slot == kNone) {
        L += shadeMiss(scene, path, ray);
        return false;
    }
    Hit hit;
    hit.slot = pixel.slot;
    hit.barycentrics = pixel.barycentrics;
    hit.t = dot(pointOfTriangle(scene, hit.slot, hit.barycentrics) - ray.origin, ray.direction);
    const bool scatters = prepareVertex(scene, path, hit, ray, v.vertex, L);
    if (scatters) v.bsdfBefore = v.vertex.bsdf;
    v.medium = ray.medium;
    v.beta = ray.beta;
    return scatters;
}

/// Takes over the history of a pixel of the frame before, which fits; `towardsBefore` points to
/// where that frame's camera is, or appears to be, and has moved along with the surface (`motion`).
SHARED_FN void takeHistory(IN(SceneView) scene, ReuseSettings settings, vec3 towardsBefore,
                           ReusePixel before, SurfaceMotion motion, INOUT(ReuseVertex) v)
{
    v.positionBefore = pointOfTriangle(scene, before.slot, before.barycentrics);
    // Where a surface curves or has textures, its lobes change from pixel to pixel. Old samples are
    // where the old lobes had a density, and nowhere else: with the new ones' in its place, light
    // from directions that only those have would be left to samples that there are not.
    Hit hit;
    hit.t = 0.0f;
    hit.slot = before.slot;
    hit.barycentrics = before.barycentrics;
    SurfacePoint s = makeSurfacePoint(scene, hit, -towardsBefore);
    v.bsdfBefore = makeBsdf(evaluateMaterial(scene, s, -towardsBefore).inputs);
    v.frameBefore = s.frame;
    v.normalBefore = s.backFace != 0u ? -s.normal : s.normal;
    v.woBefore = toLocal(v.frameBefore, towardsBefore);
    v.lobesBefore = lobesAt(v.bsdfBefore, v.woBefore);
    v.history = unpackHistory(before.history);
    const vec3 towards = toLocal(v.vertex.surface.frame, towardsBefore);
    v.rays = raysDue(settings, v.history, length(v.vertex.wo - towards));
    v.c = shareOfHistory(settings, v.history, v.rays);
    if (!FEATURE(kFeatureMoves) || motion.piece == kNone) return;
    // So far all of it as it lies now. What surrounds the surface has not moved along.
    v.moved = motion.piece;
    v.positionBefore = pointOn(fetchTriangleBefore(scene, before.slot), before.barycentrics);
    v.frameBefore = transpose(motion.turn) * v.frameBefore;
    v.normalBefore = transpose(motion.turn) * v.normalBefore;
}

/// Width of the narrowest lobe of a surface that has a density; 1 without.
SHARED_FN float narrowestLobe(IN(Bsdf) b)
{
    float width = 1.0f;
    if ((b.parts & kBsdfMicrofacet) != 0u && b.alpha > 0.0f) width = min(width, b.alpha);
    if ((b.parts & kBsdfCoat) != 0u && b.coatAlpha > 0.0f) width = min(width, b.coatAlpha);
    return width;
}

/// The share of the new integral that old samples answer for at a direction of densities q (old)
/// and p (new). One function for old samples and for candidates.
SHARED_FN float reuseShare(ReuseSettings settings, float c, float q, float p)
{
    if (settings.strategy == kReuseRa || settings.strategy == kReuseRejection)
        return reuseAlpha(c, q, p);
    if (!usableDensity(q) || !usableDensity(p)) return 0.0f;
    if (settings.strategy == kReuseMis || settings.strategy == kReuseRestir)
        return c * q / (c * q + (1.0f - c) * p);
    return settings.strategy == kReuseReweighting ? c : 0.0f;
}

/// Whether old samples may slide along the surfaces that they come from (reuse_shift.h). Where the
/// first hit lies on a mesh that has moved, its own way is no rounding, and adds up.
SHARED_FN bool maySlide(ReuseSettings settings, IN(ReuseVertex) v)
{
    return !isUnbiased(settings) && v.moved == kNone;
}

/// Whether a way from a first hit is what it was in the frame before, as far as motion goes: to its
/// end at `way` from the hit, on triangle `triangle`, or (kNone) on for ever. What is not is left
/// to new samples, on both sides alike. Ways past the mesh that the hit itself lies on count as
/// they were, as those past meshes that rest do.
SHARED_FN bool wayIsOld(IN(SceneView) scene, ReuseSettings settings, IN(ReuseVertex) v, vec3 way,
                        bool ends, uint triangle)
{
    const uint pieces = movedPieces(settings);
    if (pieces == 0u) return true;
    if (triangle != kNone && movedPieceOf(scene, pieces, triangle) != kNone) return false;
    if (passesMoved(scene, pieces, v.vertex.surface.position, way, ends, v.moved)) return false;
    if (v.moved == kNone) return true;
    const vec3 before = ends ? way + (v.vertex.surface.position - v.positionBefore) : way;
    return dot(before, v.normalBefore) * dot(way, v.normalBefore) > 0.0f &&
           !passesMoved(scene, pieces, v.positionBefore, before, ends, v.moved);
}

/// The same of the ways over which light arrives at the place of a sample, as they are stored,
/// dark ones too.
SHARED_FN bool arrivingIsOld(IN(SceneView) scene, ReuseSettings settings, vec3 place, ReuseSample r)
{
    const uint pieces = movedPieces(settings);
    if (pieces == 0u || r.slot == kNone) return true;
    bool old = true;
    if (r.lightDirection != 0u)
        old = !passesMoved(scene, pieces, place, unpackOct(r.lightDirection), false, kNone);
    if (old && r.nextDirection != 0u)
        old = !passesMoved(scene, pieces, place, unpackOct(r.nextDirection), false, kNone);
    return old;
}

/// A direction (world) in the frame of the surface as the frame before met it; false where no light
/// went that way.
SHARED_FN bool wentBefore(IN(ReuseVertex) v, vec3 wi, OUT(vec3) local)
{
    local = toLocal(v.frameBefore, wi);
    return v.c > 0.0f && dot(wi, v.normalBefore) * local.z > 0.0f;
}

/// The density with which the frame before would have drawn a direction (world).
SHARED_FN float densityBefore(IN(ReuseVertex) v, vec3 wi)
{
    vec3 local;
    if (!wentBefore(v, wi, local)) return 0.0f;
    return pdfLobes(v.bsdfBefore, v.lobesBefore, v.woBefore, local);
}

/// f |cos| and the densities q and p of a direction (world, unit) at a first hit. False when no
/// light goes that way.
SHARED_FN bool evaluateAt(IN(ReuseVertex) v, vec3 wi, OUT(vec3) response, OUT(float) p,
                          OUT(float) q)
{
    const vec3 local = toLocal(v.vertex.surface.frame, wi);
    evalPdfLobes(v.vertex.bsdf, v.vertex.lobes, v.vertex.wo, local, response, p);
    q = densityBefore(v, wi);
    float side;
    const bool goes = sideOf(v.vertex.surface, wi, local.z, side);
    response *= goes ? abs(local.z) : 0.0f;
    return goes;
}

/// Radiance that leaves the vertex towards where it is seen from, of light that comes from one
/// direction.
SHARED_FN vec3 reflectStored(IN(Vertex) vertex, uint direction, uint radiance)
{
    if (radiance == 0u) return vec3(0.0f);
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
    vec3 direction;  // to its place, unit, world
    float distance;
    vec3 response;   // of the first hit to radiance from there
    float p;         // the density of its direction
    float u;         // absolute weight per solid angle, alpha included
    float perPlace;  // what it is multiplied by to be stored
    float survival;  // probability to be kept: 1 but for Rejection-Augmentation
    bool turned;     // its place is seen from another direction than before
};

/// Way from a position to the place of a sample: true where that is a triangle `t`, of normal n.
SHARED_FN bool wayToPlace(IN(SceneView) scene, ReuseSample r, vec3 position, OUT(vec3) way,
                          OUT(Triangle) t, OUT(vec3) n)
{
    n = vec3(0.0f);
    way = unpackOct(r.place);
    t.v0 = vec4(0.0f);
    t.v1 = vec4(0.0f);
    t.v2 = vec4(0.0f);
    if (r.slot == kNone) return false;
    t = triangleInSlot(scene, r.slot);
    n = normalize(cross(xyz(t.v1) - xyz(t.v0), xyz(t.v2) - xyz(t.v0)));
    way = pointOn(t, unpackPlace(r.place)) - position;
    return true;
}

SHARED_FN ReuseView noReuseView()
{
    ReuseView view;
    view.direction = vec3(0.0f);
    view.distance = kInfinity;
    view.response = vec3(0.0f);
    view.p = 0.0f;
    view.u = 0.0f;
    view.perPlace = 1.0f;
    view.survival = 1.0f;
    view.turned = false;
    return view;
}

/// What an old sample counts that `view` is aimed at; `share`: by what its place has become. False
/// when it is of no further use.
SHARED_FN bool weighOldSample(ReuseSettings settings, IN(ReuseVertex) v, ReuseSample r, float share,
                              INOUT(ReuseView) view)
{
    float q;
    // Dark here, a sample may be of use again: its density is not zero.
    if (!evaluateAt(v, view.direction, view.response, view.p, q)) view.response = vec3(0.0f);
    view.u = r.u / view.perPlace * (share * reuseShare(settings, v.c, q, view.p));
    if (settings.strategy == kReuseRejection && v.c * q > view.p)
        view.survival = view.p / (v.c * q);
    return view.u > 0.0f && view.u < kInfinity;
}

/// Aims an old sample anew from the new first hit; its place may change. False when it is of no
/// further use.
SHARED_FN bool aimOldSample(IN(SceneView) scene, ReuseSettings settings, IN(ReuseVertex) v,
                            INOUT(ReuseSample) r, OUT(ReuseView) view)
{
    view = noReuseView();
    if (!(r.u > 0.0f)) return false;
    float share = 1.0f;
    vec3 n;
    Triangle t;
    const vec3 position = v.vertex.surface.position;
    const bool ends = wayToPlace(scene, r, position, view.direction, t, n);
    const uint triangle = ends ? floatAsUint(t.v0.w) : kNone;
    const bool slid = ends && maySlide(settings, v) &&
                      slidePlace(t, position, v.positionBefore, view.direction, r);
    if (!wayIsOld(scene, settings, v, view.direction, ends, triangle)) return false;
    if (ends) {
        if (!slid) share = reconnection(view.direction, n, position, v.positionBefore);
        view.turned = !slid && position != v.positionBefore;
        if (!(share > 0.0f)) return false;
        const float d2 = dot(view.direction, view.direction);
        view.distance = sqrt(d2);
        view.direction /= view.distance;
        view.perPlace = d2 / abs(dot(n, view.direction));
    }
    return weighOldSample(settings, v, r, share, view);
}

/// The same of a sample that has no place but a direction.
SHARED_FN bool aimOldDirection(IN(SceneView) scene, ReuseSettings settings, IN(ReuseVertex) v,
                               ReuseSample r, OUT(ReuseView) view)
{
    view = noReuseView();
    if (!(r.u > 0.0f)) return false;
    view.direction = unpackOct(r.place);
    if (!wayIsOld(scene, settings, v, view.direction, false, kNone)) return false;
    return weighOldSample(settings, v, r, 1.0f, view);
}

/// Drops an old sample or pays for those that are: `xi` is uniform. False where it is dropped.
SHARED_FN bool survivesRejection(float xi, INOUT(ReuseView) view)
{
    if (!(xi < view.survival)) return false;
    view.u /= view.survival;
    return true;
}

/// A path that begins at a first hit; it has no direction yet.
SHARED_FN PathState pathFromHere(IN(ReuseVertex) v)
{
    PathState path = pathAlong(v.vertex.surface.position, vec3(0.0f, 0.0f, 1.0f));
    path.medium = v.medium;
    return path;
}

/// Whether what a sample has stored cannot be known from where it is seen now: a mirror shows
/// something else.
SHARED_FN bool showsElse(ReuseSample r, IN(ReuseView) view)
{
    return view.turned && r.nextDirection == kReuseBent;
}

/// Radiance that comes from where nothing is met, along `view.direction`, whose density is
/// `view.p`.
SHARED_FN vec3 skyOfSample(IN(SceneView) scene, PathSettings path, IN(ReuseVertex) v,
                           IN(ReuseView) view)
{
    PathState ray = pathFromHere(v);
    ray.direction = view.direction;
    ray.pdf = view.p;
    ray.depth = 1u;
    return shadeMiss(scene, path, ray);
}

/// Radiance that comes from the place of a sample whose radiance is evaluated, along
/// `view.direction`, whose density is `view.p`.
SHARED_FN vec3 evaluateArriving(IN(SceneView) scene, PathSettings path, ReuseSettings settings,
                                IN(ReuseVertex) v, ReuseSample r, IN(ReuseView) view)
{
    PathState ray = pathFromHere(v);
    ray.direction = view.direction;
    ray.pdf = view.p;
    ray.depth = 1u;
    if (FEATURE(kFeatureVolume)) {
        float side;
        sideOf(v.vertex.surface, view.direction, 1.0f, side);
        ray.medium = mediumBeyond(v.medium, v.vertex, side);
    }
    if (r.slot == kNone) return shadeMiss(scene, path, ray);
    Hit hit;
    hit.slot = r.slot;
    hit.barycentrics = unpackPlace(r.place);
    hit.t = view.distance;
    vec3 L = vec3(0.0f);
    Vertex far;
    const bool scatters = prepareVertex(scene, path, hit, ray, far, L);
    if (keepsDirections(settings)) return L + unpackRgbe(r.radiance);
    if (scatters)
        L += ray.beta * (reflectStored(far, r.lightDirection, r.lightRadiance) +
                         reflectStored(far, r.nextDirection, r.nextRadiance));
    return L;
}

/// The share of a connection that old ones answer for: all of N / (N + n), since an emitter's
/// density does not depend on the camera; nothing where the ray that an old one would need is as
/// good as a new one, where the old surface was dark (a connection that brings nothing is not
/// kept), and where something has moved.
SHARED_FN float lightShare(IN(SceneView) scene, ReuseSettings settings, IN(ReuseVertex) v,
                           IN(ShadowRay) shadow)
{
    vec3 local;
    if (isUnbiased(settings) || !wentBefore(v, shadow.wi, local)) return 0.0f;
    vec3 f;
    float q;
    evalPdfLobes(v.bsdfBefore, v.lobesBefore, v.woBefore, local, f, q);
    if (!(maxComponent(f) > 0.0f)) return 0.0f;
    const bool ends = shadow.tMax < 1.0f;
    const vec3 end = shadow.origin + shadow.direction;
    const vec3 way = ends ? end - v.vertex.surface.position : shadow.wi;
    return wayIsOld(scene, settings, v, way, ends, kNone) ? v.c : 0.0f;
}

/// A connection of a first hit to an emitter, drawn again from its numbers; its contribution has no
/// weight yet.
SHARED_FN ShadowRay viewLight(IN(SceneView) scene, PathSettings settings, IN(ReuseVertex) v,
                              ReuseLight r)
{
    return connectTo(scene, settings, r.emitter, pmfEmitter(scene, r.emitter),
                     unpackNumbers(r.numbers), pathFromHere(v), v.vertex);
}

/// How far lobes point elsewhere than in the frame before: the length between the directions that
/// mirrors would reflect the camera in. In the world: local frames may turn about the normal.
SHARED_FN float lobesTurned(IN(ReuseVertex) v)
{
    const vec3 wo = v.vertex.wo;
    const vec3 now = toWorld(v.vertex.surface.frame, vec3(-wo.x, -wo.y, wo.z));
    const vec3 before = toWorld(v.frameBefore, vec3(-v.woBefore.x, -v.woBefore.y, v.woBefore.z));
    return length(now - before);
}

/// Gives back a share of the remainder that the frame before has left: as much as the vertex's
/// samples are likely to bring what they brought there. Lobes that have turned by their width bring
/// something else, and the remainder is noise then.
SHARED_FN void giveBack(IN(ReuseVertex) v, vec3 remainder, INOUT(ReuseSums) sums)
{
    const Bsdf b = v.vertex.bsdf;
    const LobeChoice lobes = v.vertex.lobes;
    const float turned = lobesTurned(v);
    const float facet = b.alpha > 0.0f ? lobes.facet : 0.0f;  // mirrors keep no samples
    const float coat = b.coatAlpha > 0.0f ? lobes.coat : 0.0f;
    const float lost = facet * min(lobeTurn(b.alpha, turned), 1.0f) +
                       coat * min(lobeTurn(b.coatAlpha, turned), 1.0f);
    const float all = max(facet + coat + lobes.diffuse, 1.0e-6f);
    sums.carried = (v.c * (1.0f - min(lost / all, 1.0f))) * remainder;
}

/// Adds an old sample by which radiance L comes; returns what it brings (u F).
SHARED_FN vec3 addOldSample(INOUT(ReuseSums) sums, IN(ReuseView) view, vec3 L)
{
    const vec3 F = view.response * L;
    sums.around += view.u * F;
    sums.aroundSquares += view.u / view.p * F * F;
    sums.weightSum += view.u * view.p;
    sums.weightSquares += view.u * view.p * view.u * view.p;
    sums.oldShare = sums.weightSum;
    return view.u * F;
}

/// Drops one that is hidden, and remembers what it would have brought.
SHARED_FN void dropOldSample(INOUT(ReuseSums) sums, IN(ReuseView) view, vec3 L)
{
    sums.leaked += view.u * luminance(view.response * L);
}

SHARED_END

#endif
