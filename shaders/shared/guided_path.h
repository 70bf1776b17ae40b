// A vertex of a guided path, one text for GPU and CPU: path.h with another way to choose the
// direction that a path goes on in (a mixture of the BSDF's lobes and the guide), another roulette,
// and records of what came of it, from which the guide learns. What differs from T. Mueller et al.
// (2017):
// - Next-event estimation is weighted against the density of the BSDF alone, on both sides: any
//   partition is unbiased, and no look-up is spent on it. The path's weight divides by the mixture.
//   (kNeeMixture weights against the mixture, as the paper's authors do.)
// - Sharp lobes keep their probability: the guide takes its share of the smooth ones.
// - Roulette at arrival: a path survives by its throughput (the product of albedos, for weights of
//   guided samples tell nothing of what is to come) or by what the guide expects it to bring,
//   relative to the pixel (J. Vorba, J. Krivanek, "Adjoint-Driven Russian Roulette and Splitting in
//   Light Transport Simulation", 2016), whichever is larger.
#ifndef REKINDLE_SHARED_GUIDED_PATH_H
#define REKINDLE_SHARED_GUIDED_PATH_H

#include "guide.h"
#include "path.h"

SHARED_BEGIN

SHARED_CONST float kSharpAlpha = 0.06f;  // GGX width below which a lobe is left alone

// A path records its first vertices; what lies deeper teaches little that others do not.
SHARED_CONST uint kGuideVertices = 8u;

/// What happened at one vertex. `before` and `after` are the luminance that the path had brought
/// home before and after the vertex's own connection to an emitter; together with what it brings in
/// all they tell what came of both. `beta` is the luminance of its throughput before it scattered.
struct GuideRecord {
    vec3 position;
    uint direction;  // it went on in, packOct
    float pdf;       // of the mixture; 0: a delta lobe, or it did not go on
    float bsdfPdf;
    float before;
    float after;
    float beta;
    uint place;       // packGuidePlace
    float scattered;  // luminance of the throughput after it scattered
};

/// How many records a path has left, and the luminance of what it brought home and of what its
/// pixel is thought to have.
struct GuidePathEnd {
    uint count;
    float final;
    float image;
};

/// What else a record holds, in one word: the tree of the vertex (guideRoot), the share of its
/// sharp lobes, its albedo, and the probability with which roulette let the path come there.
SHARED_FN uint packGuidePlace(uint tree, float sharp, float albedo, float survival)
{
    return tree | (uint(sharp * 255.0f + 0.5f) << 3u) |
           (uint(min(albedo, 1.0f) * 1023.0f + 0.5f) << 11u) |
           (uint(survival * 2047.0f + 0.5f) << 21u);
}

SHARED_FN uint treeOfPlace(uint place)
{
    return place & 7u;
}

SHARED_FN float sharpOfPlace(uint place)
{
    return float((place >> 3u) & 0xffu) * (1.0f / 255.0f);
}

SHARED_FN float albedoOfPlace(uint place)
{
    return float((place >> 11u) & 0x3ffu) * (1.0f / 1023.0f);
}

SHARED_FN float survivalOfPlace(uint place)
{
    return float(max(place >> 21u, 1u)) * (1.0f / 2047.0f);
}

/// The state of a guided path beside PathState.
struct GuidedState {
    float albedo;    // product over vertices, divided by survival
    float survival;  // probability with which roulette let the path come to its next vertex
    float image;     // luminance that its pixel is thought to have, 0 while that is not known
};

/// Before the first vertex.
SHARED_FN GuidedState beginGuided(float image)
{
    GuidedState state;
    state.albedo = 1.0f;
    state.survival = 1.0f;
    state.image = image;
    return state;
}

// Which paths follow the guide: all, those that leave records, or none. Those that do not are paths
// of path.h, and cost what those do.
SHARED_CONST uint kGuideForAll = 0u;
SHARED_CONST uint kGuideForRecorded = 1u;
SHARED_CONST uint kGuideForNone = 2u;

/// What is asked of guided paths (PathSettings::guidedRules): one in `stride` leaves records (a
/// power of two up to 64; 0: none), what roulette goes by, how connections to emitters are
/// weighted, and who follows the guide.
SHARED_FN uint packGuidedRules(uint stride, uint roulette, uint nee, uint followers)
{
    return stride | (roulette << 8u) | (nee << 16u) | (followers << 24u);
}

/// Whether a path follows the guide that leaves records or not.
SHARED_FN bool followsGuide(PathSettings settings, bool records)
{
    const uint followers = settings.guidedRules >> 24u;
    return followers == kGuideForAll || (followers == kGuideForRecorded && records);
}

SHARED_FN uint recordStride(PathSettings settings)
{
    return settings.guidedRules & 0xffu;
}

SHARED_FN uint rouletteKind(PathSettings settings)
{
    return (settings.guidedRules >> 8u) & 0xffu;
}

// Density against which next-event estimation is weighted (GuidedNee).
SHARED_CONST uint kNeeBsdf = 0u;
SHARED_CONST uint kNeeMixture = 1u;

/// The same rules with that kind, which a device may know when it compiles.
SHARED_FN uint withNee(uint rules, uint nee)
{
    return (rules & 0xff00ffffu) | (nee << 16u);
}

SHARED_FN uint neeKind(PathSettings settings)
{
    return (settings.guidedRules >> 16u) & 0xffu;
}

/// Whether the path of a lane of a tile of 8x8 pixels (`lane` its Morton index) is recorded: one in
/// `stride`, a power of two, others in every sample. Stride 0: none.
SHARED_FN bool isRecorded(uint lane, uint index, uint stride)
{
    return stride != 0u && ((lane + index) & (stride - 1u)) == 0u;
}

/// Where in a batch the records of such a path are, among those of the other paths; groups of 64
/// lanes are tiles.
SHARED_FN uint recordedSlot(uint lane, uint stride)
{
    return (lane / 64u) * (64u / stride) + (lane % 64u) / stride;
}

/// Probability that the guide chooses the direction at a vertex. The lobes become those of the BSDF
/// given that it does not: the sharp ones as likely as before.
SHARED_FN float shareWithGuide(float share, INOUT(Vertex) vertex, OUT(float) sharp)
{
    sharp = 0.0f;
    if (isDelta(vertex.bsdf)) {
        sharp = 1.0f;
        return 0.0f;
    }
    if (isLambert(vertex.bsdf)) return 1.0f - share;
    const bool sharpFacet = vertex.bsdf.alpha < kSharpAlpha;
    const bool sharpCoat = vertex.bsdf.coatAlpha < kSharpAlpha;
    sharp = (sharpFacet ? vertex.lobes.facet : 0.0f) + (sharpCoat ? vertex.lobes.coat : 0.0f);
    const float guide = (1.0f - share) * max(1.0f - sharp, 0.0f);
    const float rest = 1.0f / (1.0f - guide);
    vertex.lobes.facet *= (sharpFacet ? 1.0f : share) * rest;
    vertex.lobes.coat *= (sharpCoat ? 1.0f : share) * rest;
    vertex.lobes.diffuse *= share * rest;
    return guide;
}

/// Draws a direction from the mixture: the guide with probability `share`, the BSDF else.
/// next.weight divides by the density of the mixture, `pdf`; next.pdf is that of the BSDF, against
/// which emitters are weighted. Both are 0 for delta lobes. False when the path ends here.
SHARED_FN bool sampleMixture(IN(GuideView) guide, GuideLeaf leaf, float share, IN(Vertex) vertex,
                             VertexNumbers numbers, OUT(BsdfSample) next, OUT(float) pdf)
{
    pdf = 0.0f;
    const float others = 1.0f - share;
    const bool byGuide = numbers.lobe.x >= others;
    vec3 wi;
    vec3 f = vec3(0.0f);
    float guidePdf = kAsPdfGuide;
    if (byGuide) {
        next.flags = 0u;
        next.pdf = 0.0f;
        next.weight = vec3(0.0f);
        const bool drawn = sampleGuide(guide, leaf, numbers.bsdf, wi, guidePdf);
        next.wi = toLocal(vertex.surface.frame, wi);
        if (!drawn) return false;
        evalPdfLobes(vertex.bsdf, vertex.lobes, vertex.wo, next.wi, f, next.pdf);
        if (!(next.pdf > 0.0f)) return false;
    } else {
        if (!sampleLobes(vertex.bsdf, vertex.lobes, vertex.wo, numbers.lobe.x / others,
                         numbers.bsdf, next))
            return false;
        if ((next.flags & kLobeDelta) != 0u) {
            next.weight *= 1.0f / others;
            return true;
        }
        wi = toWorld(vertex.surface.frame, next.wi);
    }
    pdf = next.pdf;
    if (!(share > 0.0f)) return true;
    // Here and not in both branches: lanes of a device take these one after the other.
    if (guidePdf == kAsPdfGuide) guidePdf = pdfGuide(guide, leaf, wi);
    pdf = others * next.pdf + share * guidePdf;
    if (!byGuide) {
        next.weight *= next.pdf / pdf;
        return true;
    }
    next.weight = f * (abs(next.wi.z) / pdf);
    return maxComponent(next.weight) > 0.0f;
}

// What decides about survival (GuidedRoulette of core/methods/guided_params.h).
SHARED_CONST uint kRouletteBoth = 0u;
SHARED_CONST uint kRouletteAlbedo = 1u;
SHARED_CONST uint kRouletteLight = 2u;
SHARED_CONST uint kRouletteNone = 3u;
// By light alone: what is expected is an average over a leaf, and may be zero by chance.
SHARED_CONST float kLeastSurvival = 0.05f;

/// Probability that a path that arrives goes on. `image` is the luminance that its pixel is thought
/// to have, 0 while that is not known; `expected` what the path is thought to bring. By albedo
/// while nothing else is known; never zero but for a path that is black.
SHARED_FN float guidedSurvival(uint kind, float albedo, float expected, float image)
{
    if (kind == kRouletteNone) return 1.0f;
    const float byAlbedo = sqrt(albedo);
    if (kind == kRouletteAlbedo || !(image > 0.0f)) return min(byAlbedo, 1.0f);
    const float byLight = expected / image;
    const float least = kind == kRouletteLight ? kLeastSurvival : byAlbedo;
    return min(byLight > least ? byLight : least, 1.0f);
}

/// Russian roulette where a path arrives; false when it ends here.
SHARED_FN bool survives(PathSettings settings, GuideLeaf leaf, float number, INOUT(PathState) path,
                        INOUT(GuidedState) state)
{
    state.survival = 1.0f;
    if (path.depth < settings.rouletteDepth) return true;
    state.survival = guidedSurvival(rouletteKind(settings), state.albedo,
                                    luminance(path.beta) * leaf.reflected, state.image);
    if (!(number < state.survival)) return false;
    path.beta *= 1.0f / state.survival;
    state.albedo *= 1.0f / state.survival;
    return true;
}

/// The leaf of a place where the guide has no say.
SHARED_FN GuideLeaf noGuideLeaf()
{
    GuideLeaf leaf;
    leaf.index = 0u;
    leaf.firstWord = 0u;
    leaf.share = 1.0f;
    leaf.reflected = 0.0f;
    return leaf;
}

/// What a connection's contribution takes to be weighted against the density of the mixture, and
/// not of the BSDF alone.
SHARED_FN float mixtureWeight(IN(GuideView) guide, GuideLeaf leaf, float share, IN(Vertex) vertex,
                              IN(ShadowRay) shadow)
{
    if (!(shadow.pdf > 0.0f)) return 1.0f;
    vec3 f;
    float pdf;
    evalPdfLobes(vertex.bsdf, vertex.lobes, vertex.wo, toLocal(vertex.surface.frame, shadow.wi), f,
                 pdf);
    const float mixture = (1.0f - share) * pdf + share * pdfGuide(guide, leaf, shadow.wi);
    const float before = pdf / shadow.pdf;
    const float now = mixture / shadow.pdf;
    return (1.0f + before * before) / (1.0f + now * now);
}

/// One vertex of a path: shadeSurface, with the guide if it follows it (`follows`). `recorded` asks
/// for a record (1) or not, and says whether there is one; it is complete but for `after`, which is
/// known once the shadow ray has been traced.
SHARED_FN bool shadeGuided(IN(SceneView) scene, IN(GuideView) guide, PathSettings settings,
                           bool follows, VertexNumbers numbers, Hit hit, INOUT(PathState) path,
                           INOUT(GuidedState) state, OUT(ShadowRay) shadow,
                           INOUT(GuideRecord) record, INOUT(uint) recorded, INOUT(vec3) L)
{
    const bool wanted = recorded != 0u;
    recorded = 0u;
    Vertex vertex;
    if (!prepareVertex(scene, settings, hit, path, vertex, L)) {
        shadow = noShadowRay(vertex.surface.position);
        return false;
    }
    shadow = noShadowRay(vertex.surface.position);
    const vec3 normal = vertex.surface.frame[2];
    GuideLeaf leaf = noGuideLeaf();
    if (follows) {
        leaf = guideAt(guide, vertex.surface.position, normal);
        // In the first sample of a view nothing is known of its pixels but what the guide knows.
        if (!(state.image > 0.0f) && leaf.reflected > 0.0f)
            state.image = luminance(L) + luminance(path.beta) * leaf.reflected;
        if (!survives(settings, leaf, numbers.lobe.y, path, state)) return false;
    }
    float albedo = 1.0f;
    if (follows || wanted) albedo = maxComponent(albedoBsdf(vertex.bsdf, vertex.wo));
    state.albedo *= albedo;
    float sharp = 0.0f;
    float share = 0.0f;
    if (follows || wanted) share = shareWithGuide(leaf.share, vertex, sharp);
    shadow = connect(scene, settings, numbers, path, vertex);
    const bool againstMixture = share > 0.0f && neeKind(settings) == kNeeMixture;
    if (againstMixture && maxComponent(shadow.contribution) > 0.0f)
        shadow.contribution *= mixtureWeight(guide, leaf, share, vertex, shadow);
    const float beta = luminance(path.beta);
    const float cameBy = state.survival;
    BsdfSample next;
    float pdf;
    bool goesOn = sampleMixture(guide, leaf, share, vertex, numbers, next, pdf);
    goesOn = goesOn && leave(settings, vertex, next, path);
    if (againstMixture && pdf > 0.0f) path.pdf = pdf;
    const float scattered = luminance(path.beta);
    if (goesOn && !follows)
        goesOn = survivesByThroughput(settings, numbers.lobe.y, path, state.survival);
    if (wanted) {
        recorded = 1u;
        record.position = vertex.surface.position;
        record.place = packGuidePlace(guideRoot(normal), sharp, albedo, cameBy);
        record.beta = beta;
        record.before = luminance(L);
        record.after = record.before;
        record.direction = goesOn ? packOct(path.direction) : 0u;
        record.pdf = goesOn ? pdf : 0.0f;
        record.bsdfPdf = goesOn ? next.pdf : 0.0f;
        record.scattered = scattered;
    }
    return goesOn;
}

SHARED_END

#endif
