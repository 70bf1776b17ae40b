// What a virtual light sends to a point of the picture, one text for GPU and CPU (Keller, "Instant
// Radiosity", 1997, with the whole surface model at both ends). Lights of a slice come as records
// of 16-byte words, and what belongs to some of them only (a glossy surface, the fall-off of a
// spot) as further words, the details, which are read when they are needed.
#ifndef REKINDLE_SHARED_VIRTUAL_LIGHT_H
#define REKINDLE_SHARED_VIRTUAL_LIGHT_H

#include "medium.h"

SHARED_BEGIN

// VirtualLight::kind: its lowest bits. Above them stands VirtualLight::bounces.
SHARED_CONST uint kVirtualSurface = 0u;
SHARED_CONST uint kVirtualPoint = 1u;
SHARED_CONST uint kVirtualDirectional = 2u;
SHARED_CONST uint kVirtualKindMask = 3u;
SHARED_CONST uint kVirtualBothSides = 4u;
SHARED_CONST uint kVirtualBouncesShift = 3u;

// Below this squared distance a light is at the receiver itself and contributes nothing.
SHARED_CONST float kTooNear2 = 1.0e-18f;

/// A light as a slice sees it, three words: see core/many_lights/virtual_light.h for what its
/// members mean. `intensity` holds how many lights it stands for, `detail` counts in words.
struct LightRecord {
    vec3 position;
    uint kind;
    vec3 normal;
    float radius;  // of lights with extent (extended_light.h); 0: a point
    vec3 intensity;
    uint detail;
};
SHARED_CONST uint kLightRecordWords = 3u;

// LightSurface::bsdf.parts: it sends out light of its own, which no cosine weakens as it arrives.
SHARED_CONST uint kLightEmits = 1u << 31u;

/// A surface that is a virtual light and sends out other than Lambert's, with the direction from
/// which its light arrives. Its frame is that of the shading normal as nobody has bent it: who
/// looks at it bends it to himself.
struct LightSurface {
    mat3 frame;
    vec3 normal;    // geometric, on the side where light arrives
    vec3 incident;  // unit, in the frame: to where the light came from, maybe behind its horizon
    Bsdf bsdf;
    LobeChoice lobes;
};

/// A receiver in three words: the point of a triangle that is seen along a direction.
struct ReceiverRecord {
    vec3 direction;  // of the ray that found it
    uint slot;
    vec2 barycentrics;
    uint events;  // scattering events between camera and receiver
    uint seed;    // of what is drawn there
    uint medium;  // through which it is seen; read where a scene has media that absorb
    uint reserved0;
    uint reserved1;
    uint reserved2;
};
SHARED_CONST uint kReceiverRecordWords = 3u;

/// Up to kSliceGroup rows of one piece of a slice, two words: what a workgroup sums. Where its
/// lights, their details, its receivers and its values begin. Values are bits, a word for a column
/// and kSliceWord rows, words of one set of rows side by side; or numbers, the rows of a column
/// side by side. Word or number (r, j) of the group is therefore
///   bits     firstValue + (r / kSliceWord) * columns + j, bit r % kSliceWord
///   numbers  firstValue + j * kSliceGroup + r
struct SliceGroup {
    uint firstLight;
    uint columns;
    uint firstDetail;
    uint firstValue;
    uint firstReceiver;
    uint rows;
    uint reserved0;
    uint reserved1;
};
SHARED_CONST uint kSliceGroupWords = 2u;
SHARED_CONST uint kSliceGroup = 64u;
SHARED_CONST uint kSliceWord = 32u;
// A software device leaves loops that have turned 65535 times in sum (traverse.glsl): a column
// takes two turns at most, and as many as it has samples where lights have extent.
SHARED_CONST uint kMostPieceColumns = 16384u;
SHARED_CONST uint kMostExtendedColumns = 400u;

/// What light arrives at.
struct LightReceiver {
    vec3 position;
    mat3 frame;
    vec3 side;  // geometric normal, on the side that is seen
    vec3 wo;    // in the frame
    Bsdf bsdf;
    LobeChoice lobes;
    uint events;
    uint seed;
    // Absorption (1/metre) on the side that is seen and on the other; of scenes with such media.
    vec3 absorption;
    vec3 absorptionBehind;
};

/// What decides how lights contribute, the same for all receivers.
struct GatherRules {
    uint maxDepth;
    float clampDistance;  // lights on surfaces do not count as nearer than this
};

// --- words -------------------------------------------------------------------------------------

// How details are reached: see scene.h.
#ifdef __cplusplus
struct LightDetails {
    const vec4* words;
};
inline vec4 fetchLightDetail(const LightDetails& details, uint word)
{
    return details.words[word];
}
#else
struct LightDetails {
    uint first;  // of the words at hand
};
vec4 fetchLightDetail(LightDetails details, uint word);
#endif

// The last two words of a surface are read where the scene has metal, glass or a clear coat.
SHARED_CONST uint kLightSurfaceWords = 7u;

/// Word `word` of a surface. Its frame is not told but made anew from the shading normal, which no
/// BSDF of ours sees, and its geometric normal is that of its light.
SHARED_FN vec4 lightSurfaceWord(IN(LightSurface) s, uint word)
{
    const vec3 normal = s.frame[2];
    const Bsdf b = s.bsdf;
    if (word == 0u) return vec4(normal, s.lobes.through);
    if (word == 1u) return vec4(toLocal(makeFrame(normal), toWorld(s.frame, s.incident)), b.alpha);
    if (word == 2u) return vec4(b.diffuse * b.diffuseNorm, uintAsFloat(b.parts));
    if (word == 3u) return vec4(b.f0, b.f90);
    if (word == 4u) return vec4(b.eta, b.strength0, b.strength90, b.coat);
    if (word == 5u) return vec4(b.metal, b.metalShare);
    return vec4(b.transmit, b.coatAlpha);
}

SHARED_FN LightSurface unpackLightSurface(IN(LightDetails) details, uint first, vec3 normal)
{
    const vec4 a = fetchLightDetail(details, first);
    const vec4 b = fetchLightDetail(details, first + 1u);
    const vec4 c = fetchLightDetail(details, first + 2u);
    const vec4 d = fetchLightDetail(details, first + 3u);
    const vec4 e = fetchLightDetail(details, first + 4u);
    LightSurface s;
    s.frame = makeFrame(xyz(a));
    s.normal = normal;
    s.incident = xyz(b);
    s.lobes.coat = 0.0f;  // probabilities, which nobody asks for
    s.lobes.facet = 0.0f;
    s.lobes.diffuse = 0.0f;
    s.lobes.through = a.w;
    s.bsdf.diffuse = xyz(c);
    s.bsdf.diffuseNorm = 1.0f;
    s.bsdf.parts = floatAsUint(c.w);
    s.bsdf.f0 = xyz(d);
    s.bsdf.f90 = d.w;
    s.bsdf.alpha = b.w;
    s.bsdf.eta = e.x;
    const float root = (e.x - 1.0f) / (e.x + 1.0f);
    s.bsdf.r0 = root * root;
    s.bsdf.shareScale = 1.0f / (1.0f - s.bsdf.r0);
    s.bsdf.strength0 = e.y;
    s.bsdf.strength90 = e.z;
    s.bsdf.coat = e.w;
    s.bsdf.metal = vec3(0.0f);
    s.bsdf.metalShare = 0.0f;
    s.bsdf.transmit = vec3(0.0f);
    s.bsdf.coatAlpha = 0.0f;
    if (FEATURE(kFeatureMetal)) {
        const vec4 f = fetchLightDetail(details, first + 5u);
        s.bsdf.metal = xyz(f);
        s.bsdf.metalShare = f.w;
    }
    if (FEATURE(kFeatureTransmission | kFeatureClearcoat)) {
        const vec4 g = fetchLightDetail(details, first + 6u);
        s.bsdf.transmit = xyz(g);
        s.bsdf.coatAlpha = g.w;
    }
    return s;
}

// --- both ends ---------------------------------------------------------------------------------

/// The cosine of what arrives that the intensity of such a light holds.
SHARED_FN float heldCosine(vec3 incident)
{
    return max(abs(incident.z), 1.0e-3f);
}

/// BSDF (no cosine) for flux that arrives at the surface and leaves to `out` (unit, world). Flux
/// does not have radiance's factor of the squared index (Veach 1997, 5.2). Who is behind the
/// horizon of the shading normal, but not of the geometric one, sees the surface with its normal
/// bent (ensureVisible), or the rims of coarse smooth meshes would send nothing there. With the
/// normal changes the cosine of what arrives, which the light's intensity holds for the other
/// normal.
SHARED_FN vec3 scatteredByLight(IN(LightSurface) s, vec3 leaving)
{
    const float side = dot(leaving, s.normal);
    const bool emits = (s.bsdf.parts & kLightEmits) != 0u;
    vec3 local = toLocal(s.frame, leaving);
    vec3 incident = s.incident;
    LobeChoice lobes = s.lobes;
    if (!(side * local.z > 0.0f)) {
        const float up = side < 0.0f ? -1.0f : 1.0f;
        const mat3 bent = makeFrame(up * ensureVisible(vec3(0.0f, 0.0f, up), local));
        local = toLocal(bent, local);
        if (!emits) incident = toLocal(bent, incident);
        lobes = lobesAt(s.bsdf, incident);
    }
    if (!(incident.z > 0.0f)) {
        return vec3(0.0f);  // who sees the surface so does not see it lit
    }
    vec3 f;
    float pdf;
    evalPdfLobes(s.bsdf, lobes, incident, local, f, pdf);
    const float cosines = emits ? 1.0f : incident.z / heldCosine(s.incident);
    const bool refracted = local.z < 0.0f && (s.bsdf.parts & kBsdfSolid) != 0u;
    return f * (refracted ? cosines * s.bsdf.eta * s.bsdf.eta : cosines);
}

/// Fall-off of a spot light (KHR_lights_punctual): the square of a ramp in the cosine to its axis.
SHARED_FN float spotFalloff(float scale, float offset, float cosine)
{
    const float ramp = clamp(cosine * scale + offset, 0.0f, 1.0f);
    return ramp * ramp;
}

/// Radiant intensity (of directional lights: irradiance) that goes from the light to a receiver in
/// direction -wi, without the cosine at the light.
SHARED_FN vec3 lightLeaving(IN(LightDetails) details, IN(LightRecord) light, vec3 wi)
{
    if (light.detail == kNone) {
        return light.intensity;
    }
    if ((light.kind & kVirtualKindMask) == kVirtualSurface) {
        if (!FEATURE(kFeatureSpecular | kFeatureTransmission | kFeatureClearcoat |
                     kFeatureShadingNormals | kFeatureNormalMaps)) {
            return vec3(0.0f);  // no such surface in the scene
        }
        const LightSurface s = unpackLightSurface(details, light.detail, light.normal);
        return light.intensity * scatteredByLight(s, -wi);
    }
    const vec4 spot = fetchLightDetail(details, light.detail);
    return light.intensity * spotFalloff(spot.x, spot.y, -dot(wi, light.normal));
}

SHARED_FN LightReceiver receiverAt(IN(SurfacePoint) s, IN(Bsdf) bsdf, vec3 direction)
{
    LightReceiver r;
    r.position = s.position;
    r.frame = s.frame;
    r.side = s.backFace != 0u ? -s.normal : s.normal;
    r.wo = toLocal(s.frame, -direction);
    r.bsdf = bsdf;
    r.lobes = lobesAt(bsdf, r.wo);
    r.events = 0u;
    r.seed = 0u;
    r.absorption = vec3(0.0f);
    r.absorptionBehind = vec3(0.0f);
    return r;
}

/// Looks up the surface of a receiver; `slot` counts as the scene at hand does.
SHARED_FN LightReceiver lookUpReceiver(IN(SceneView) scene, IN(ReceiverRecord) record)
{
    Hit hit;
    hit.t = 0.0f;
    hit.barycentrics = record.barycentrics;
    hit.slot = record.slot;
    SurfacePoint s = makeSurfacePoint(scene, hit, record.direction);
    const Shading shading = evaluateMaterial(scene, s, record.direction);
    LightReceiver r = receiverAt(s, makeBsdf(shading.inputs), record.direction);
    r.events = record.events;
    r.seed = record.seed;
    if (FEATURE(kFeatureVolume)) {
        r.absorption = absorptionOf(scene, record.medium);
        r.absorptionBehind = absorptionOf(scene, mediumBehind(record.medium, s, r.bsdf));
    }
    return r;
}

/// What is left of light on its way from a light to the receiver. Nothing lies between them, so
/// that all of the way is in one medium; what is infinitely far is in none.
SHARED_FN vec3 dimming(IN(LightReceiver) r, IN(LightRecord) light, vec3 towards)
{
    if (!FEATURE(kFeatureVolume) || (light.kind & kVirtualKindMask) == kVirtualDirectional) {
        return vec3(1.0f);
    }
    const bool behind = dot(towards, r.side) < 0.0f;
    return exp(-length(towards) * (behind ? r.absorptionBehind : r.absorption));
}

/// The direction to a light (not unit), and the cosines and distances of what it contributes; 0
/// where it contributes nothing.
SHARED_FN float lightWeight(IN(LightReceiver) r, IN(LightRecord) light, GatherRules rules,
                            OUT(vec3) towards)
{
    const uint kind = light.kind & kVirtualKindMask;
    towards = kind == kVirtualDirectional ? -light.normal : light.position - r.position;
    const float cosine = dot(towards, r.frame[2]);
    const bool transmits = (r.bsdf.parts & kBsdfTransmission) != 0u;
    // Both normals agree, and light goes through only where it can; events before the receiver, at
    // it and before the light are maxDepth at most.
    const bool passes = cosine * dot(towards, r.side) > 0.0f && (cosine > 0.0f || transmits) &&
                        r.events + (light.kind >> kVirtualBouncesShift) < rules.maxDepth;
    float weight = abs(cosine);
    if (kind != kVirtualDirectional) {
        const float d2 = dot(towards, towards);
        const float safe = max(d2, kTooNear2);
        if (kind == kVirtualPoint) {
            weight /= safe * sqrt(safe);
        } else {
            const float facing = -dot(towards, light.normal);
            const bool bothSides = (light.kind & kVirtualBothSides) != 0u;
            const float leaves = max(facing, bothSides ? -facing : 0.0f);
            const float clamped = rules.clampDistance * rules.clampDistance;
            weight *= d2 > kTooNear2 ? leaves / (safe * max(safe, clamped)) : 0.0f;
        }
    }
    return passes ? weight : 0.0f;
}

/// Radiance that the receiver sends to where it is seen from because of a light that it sees.
SHARED_FN vec3 lightContribution(IN(LightReceiver) r, IN(LightDetails) details,
                                 IN(LightRecord) light, GatherRules rules)
{
    vec3 towards;
    const float weight = lightWeight(r, light, rules, towards);
    if (!(weight > 0.0f)) {
        return vec3(0.0f);
    }
    const vec3 wi = normalize(towards);
    vec3 f;
    float pdf;
    evalPdfLobes(r.bsdf, r.lobes, r.wo, toLocal(r.frame, wi), f, pdf);
    return f * lightLeaving(details, light, wi) * dimming(r, light, towards) * weight;
}

#ifdef __cplusplus
static_assert(sizeof(LightRecord) == 16 * kLightRecordWords);
static_assert(sizeof(ReceiverRecord) == 16 * kReceiverRecordWords);
static_assert(sizeof(SliceGroup) == 16 * kSliceGroupWords && kSliceGroup % kSliceWord == 0);
#endif

SHARED_END

#endif
