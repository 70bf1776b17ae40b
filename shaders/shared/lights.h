// Emitters of a scene: the choice of one by its share of the power or by its tree, sampling it, and
// the density of a direction that was found another way. Choice and environment use inverted CDFs,
// not alias tables: those would scramble the stratification of the sample points. The differences
// of the stored CDF *are* the probabilities.
#ifndef REKINDLE_SHARED_LIGHTS_H
#define REKINDLE_SHARED_LIGHTS_H

#include "emitter.h"
#include "emitter_tree.h"
#include "sky_regions.h"
#include "surface.h"

SHARED_BEGIN

/// Index i in [first, end) with cdf[i] <= u < cdf[i + 1] among the emitters; u is in [cdf[first],
/// cdf[end]).
SHARED_FN uint invertEmitterCdf(IN(SceneView) scene, uint first, uint end, float u, OUT(float) pmf)
{
    uint low = first;
    uint high = end;
    while (high - low > 1u) {
        const uint middle = (low + high) >> 1u;
        if (fetchEmitterCdf(scene, middle) <= u) {
            low = middle;
        } else {
            high = middle;
        }
    }
    pmf = fetchEmitterCdf(scene, low + 1u) - fetchEmitterCdf(scene, low);
    return low;
}

/// Chooses one of all emitters, whatever it is for.
SHARED_FN uint chooseEmitter(IN(SceneView) scene, uint count, float u, OUT(float) pmf)
{
    return invertEmitterCdf(scene, 0u, count, u, pmf);
}

/// Probability with which chooseEmitter returns `emitter`.
SHARED_FN float pmfEmitter(IN(SceneView) scene, uint emitter)
{
    if (!FEATURE(kFeatureManyEmitters)) return 1.0f;
    return fetchEmitterCdf(scene, emitter + 1u) - fetchEmitterCdf(scene, emitter);
}

/// Whether some emitters are chosen by what they may bring to a place.
SHARED_FN bool choosesByPlace(PathSettings settings)
{
    return FEATURE(kFeatureEmitterTree) && settings.treeEmitters != 0u;
}

/// Begins the choice of an emitter by what it may bring to a place. What is not in the tree is
/// infinitely far away, and as good in one place as in another: it is chosen at once.
SHARED_FN EmitterChoice beginChoiceFor(IN(SceneView) scene, PathSettings settings, float u)
{
    if (!FEATURE(kFeatureManyEmitters)) return emitterChosen(0u, 1.0f);
    float near = 0.0f;
    uint first = 0u;
    if (choosesByPlace(settings)) {
        first = settings.treeEmitters;
        near = fetchEmitterCdf(scene, first);
        if (u < near)
            return beginInTree(first, min(u / near, kOneMinusEpsilon), kUnitGrain / near, near);
    }
    float pmf;
    const uint emitter = invertEmitterCdf(scene, first, settings.emitterCount, u, pmf);
    prefetchEmitter(scene, emitter);
    return emitterChosen(emitter, pmf);
}

/// Probability with which that choice ends at `emitter`, made for a `departure` from p.
SHARED_FN float pmfEmitterFor(IN(SceneView) scene, PathSettings settings, uint emitter, vec3 p,
                              uint departure)
{
    if (!choosesByPlace(settings) || emitter >= settings.treeEmitters)
        return pmfEmitter(scene, emitter);
    return fetchEmitterCdf(scene, settings.treeEmitters) *
           pmfInTree(scene, settings.treeEmitters, emitter, p, departure);
}

/// Whether the environment is drawn as it is seen from a place.
SHARED_FN bool drawsSkyByPlace(PathSettings settings)
{
    return FEATURE(kFeatureSkyRegions) && settings.skyRegions != 0u;
}

/// Begins a choice among emitters other than the environment, by `others` from 0 to the sum of
/// their probabilities.
SHARED_FN EmitterChoice beginBesideSky(IN(SceneView) scene, PathSettings settings, float others)
{
    const float first = fetchEmitterCdf(scene, settings.environmentEmitter);
    const float whole = fetchEmitterCdf(scene, settings.environmentEmitter + 1u) - first;
    return beginChoiceFor(scene, settings,
                          min(others < first ? others : others + whole, kOneMinusEpsilon));
}

/// beginChoiceFor in a region of the sky (0: none), which has its own share of the environment:
/// all of it where there is nothing else.
SHARED_FN EmitterChoice beginChoiceIn(IN(SceneView) scene, PathSettings settings, uint region,
                                      float u)
{
    if (!FEATURE(kFeatureSkyRegions) || !FEATURE(kFeatureManyEmitters) || region == 0u)
        return beginChoiceFor(scene, settings, u);
    const uint sky = settings.environmentEmitter;
    const float share = skyShare(scene, region);
    if (u < share) return emitterChosen(sky, share);
    // The rest of u goes over the CDF without the environment.
    const float rest = 1.0f - pmfEmitter(scene, sky);
    EmitterChoice c = beginBesideSky(scene, settings, (u - share) * (rest / (1.0f - share)));
    c.pmf *= (1.0f - share) / rest;
    return c;
}

/// By how much emitters other than the environment are more likely there than by the CDF.
SHARED_FN float shareBesideSky(IN(SceneView) scene, PathSettings settings, uint region)
{
    if (!FEATURE(kFeatureSkyRegions) || !FEATURE(kFeatureManyEmitters) || region == 0u) return 1.0f;
    const float rest = 1.0f - pmfEmitter(scene, settings.environmentEmitter);
    return rest > 0.0f ? (1.0f - skyShare(scene, region)) / rest : 0.0f;
}

/// Probability with which a choice there ends at `emitter`, which is not the environment,
SHARED_FN float pmfEmitterIn(IN(SceneView) scene, PathSettings settings, uint region, uint emitter,
                             vec3 p, uint departure)
{
    return shareBesideSky(scene, settings, region) *
           pmfEmitterFor(scene, settings, emitter, p, departure);
}

/// and that with which it is the environment.
SHARED_FN float pmfEnvironmentIn(IN(SceneView) scene, PathSettings settings, uint region)
{
    if (!FEATURE(kFeatureSkyRegions) || !FEATURE(kFeatureManyEmitters) || region == 0u)
        return pmfEmitter(scene, settings.environmentEmitter);
    return skyShare(scene, region);
}

/// Inverts a CDF that starts at `first`, its parts at `parts`; returns the interval, and u
/// stretched inside it.
SHARED_FN uint invertEnvironmentCdf(IN(SceneView) scene, uint first, uint parts, INOUT(float) u,
                                    OUT(float) pmf)
{
    const uint part = parts + min(uint(u * float(kCdfParts)), kCdfParts - 1u);
    uint low = uint(fetchEnvironmentCdf(scene, part));
    uint high = uint(fetchEnvironmentCdf(scene, part + 1u)) + 1u;
    while (high - low > 1u) {
        const uint middle = (low + high) >> 1u;
        if (fetchEnvironmentCdf(scene, first + middle) <= u) {
            low = middle;
        } else {
            high = middle;
        }
    }
    const float a = fetchEnvironmentCdf(scene, first + low);
    const float b = fetchEnvironmentCdf(scene, first + low + 1u);
    pmf = b - a;
    u = pmf > 0.0f ? min((u - a) / pmf, kOneMinusEpsilon) : 0.5f;
    return low;
}

/// Radiance of the environment from direction `d` (unit), bilinear, without the sun.
SHARED_FN vec3 environmentRadiance(IN(SceneView) scene, PathSettings settings, vec3 d)
{
    const vec2 uv = environmentUv(d);
    const int width = int(settings.environmentWidth);
    const int height = int(settings.environmentHeight);
    const vec2 texel = vec2(uv.x * float(width) - 0.5f, uv.y * float(height) - 0.5f);
    const vec2 corner = floor(texel);
    const vec2 f = texel - corner;
    const uint x0 = wrapTexel(int(corner.x), width, kWrapRepeat);
    const uint x1 = wrapTexel(int(corner.x) + 1, width, kWrapRepeat);
    const uint row0 = wrapTexel(int(corner.y), height, kWrapClamp) * settings.environmentWidth;
    const uint row1 = wrapTexel(int(corner.y) + 1, height, kWrapClamp) * settings.environmentWidth;
    const vec3 top = mix(xyz(fetchEnvironmentTexel(scene, row0 + x0)),
                         xyz(fetchEnvironmentTexel(scene, row0 + x1)), f.x);
    const vec3 bottom = mix(xyz(fetchEnvironmentTexel(scene, row1 + x0)),
                            xyz(fetchEnvironmentTexel(scene, row1 + x1)), f.x);
    return settings.environmentIntensity * mix(top, bottom, f.y);
}

/// Solid-angle density from the probability of a texel at sin(theta) above the poles.
SHARED_FN float environmentDensity(PathSettings settings, float texelPmf, float sinTheta)
{
    const float texels = float(settings.environmentWidth) * float(settings.environmentHeight);
    return sinTheta > 0.0f ? texelPmf * texels / (2.0f * kPi * kPi * sinTheta) : 0.0f;
}

/// Density with which sampleEnvironment finds direction `d` in a region of the sky (0: none).
SHARED_FN float pdfEnvironment(IN(SceneView) scene, PathSettings settings, uint region, vec3 d)
{
    const vec2 uv = environmentUv(d);
    const uint width = settings.environmentWidth;
    const uint height = settings.environmentHeight;
    const uint x = min(uint(uv.x * float(width)), width - 1u);
    const uint y = min(uint(uv.y * float(height)), height - 1u);
    const float above = fetchEnvironmentCdf(scene, y);
    const float row = fetchEnvironmentCdf(scene, y + 1u) - above;
    const uint first = height + 1u + y * (width + 1u) + x;
    const float left = fetchEnvironmentCdf(scene, first);
    const float column = fetchEnvironmentCdf(scene, first + 1u) - left;
    float texel = row * column;
    if (FEATURE(kFeatureSkyRegions) && region != 0u) {
        const vec2 inTexel = vec2(uv.x * float(width) - float(x), uv.y * float(height) - float(y));
        texel *=
            skyDensity(scene, region, vec2(left + inTexel.x * column, above + inTexel.y * row));
    }
    return environmentDensity(settings, texel, sqrt(d.x * d.x + d.z * d.z));
}

/// Picks a texel by its power, and by what is seen of it in a region of the sky (0: none), and a
/// point in it.
SHARED_FN bool sampleEnvironment(IN(SceneView) scene, PathSettings settings, uint region, vec2 u,
                                 OUT(EmitterSample) s)
{
    vec2 v = u;
    float density = 1.0f;
    if (FEATURE(kFeatureSkyRegions) && region != 0u) density = warpToSky(scene, region, v);
    float row = 0.0f;
    float column = 0.0f;
    const uint width = settings.environmentWidth;
    const uint height = settings.environmentHeight;
    const uint parts = firstCdfPart(width, height);
    const uint y = invertEnvironmentCdf(scene, 0u, parts, v.y, row);
    const uint first = height + 1u + y * (width + 1u);
    const uint x =
        invertEnvironmentCdf(scene, first, parts + (y + 1u) * (kCdfParts + 1u), v.x, column);
    s.wi = environmentDirection(
        vec2((float(x) + v.x) / float(width), (float(y) + v.y) / float(height)));
    s.distance = kDistant;
    s.barycentrics = vec2(0.0f, 0.0f);
    s.pdf = environmentDensity(settings, density * row * column,
                               sqrt(s.wi.x * s.wi.x + s.wi.z * s.wi.z));
    s.radiance = environmentRadiance(scene, settings, s.wi);
    return s.pdf > 0.0f;
}

/// A textured emitter's radiance at barycentrics of its triangle.
SHARED_FN vec3 emitterTexture(IN(SceneView) scene, uint triangle, vec2 w)
{
    const uvec4 vertices = fetchTriangleIndices(scene, triangle);
    const VertexAttributes a = fetchVertexAttributes(scene, vertices.x);
    const VertexAttributes b = fetchVertexAttributes(scene, vertices.y);
    const VertexAttributes c = fetchVertexAttributes(scene, vertices.z);
    const vec2 uv0 = interpolate(vec2(a.u, a.v), vec2(b.u, b.v), vec2(c.u, c.v), w);
    vec2 uv1 = uv0;
    vec4 color;
    if (hasVertexExtra(scene)) interpolateVertexExtra(scene, vertices, w, uv1, color);
    const uint t = textureOfSlot(fetchMaterial(scene, vertices.w, 5u),
                                 fetchMaterial(scene, vertices.w, 6u), kTextureEmissive);
    return t != 0u ? xyz(lookUpTexture(scene, t - 1u, uv0, uv1)) : vec3(1.0f, 1.0f, 1.0f);
}

/// A point of a triangle that emits, as its material and what is seen along `direction` need it.
SHARED_FN SurfacePoint emitterSurface(IN(SceneView) scene, Emitter e, vec2 w, vec3 direction)
{
    StoredTriangle stored;  // none is an instance's
    stored.slot = kNone;
    stored.matrix = 0u;
    SurfacePoint s;
    s.triangle = e.slot;
    s.material = fetchTriangleIndices(scene, e.slot).w;
    s.emitter = kNone;
    s.offset = leastOffset(e.a, e.b, e.c, 0.0f);
    layOutSurface(scene, stored, e.a, e.b, e.c, w, direction, s);
    return s;
}

/// Radiance along -direction of an emitter below a clear coat: just what a ray that meets it finds.
SHARED_FN vec3 coatedEmission(IN(SceneView) scene, Emitter e, vec2 w, vec3 direction)
{
    SurfacePoint s = emitterSurface(scene, e, w, direction);
    return evaluateMaterial(scene, s, direction).emission;
}

/// Samples one emitter as seen from p, in a region of the sky (0: none); the pdf (0 for those
/// without extent) does not hold the choice among emitters.
SHARED_FN bool sampleEmitter(IN(SceneView) scene, PathSettings settings, uint index, vec3 p,
                             uint region, vec2 u, OUT(EmitterSample) s)
{
    const Emitter e = fetchEmitter(scene, index);
    const uint kind = e.kind & 0xffu;
    s.wi = vec3(0.0f, 0.0f, 1.0f);
    s.distance = 0.0f;
    s.radiance = vec3(0.0f, 0.0f, 0.0f);
    s.pdf = 0.0f;
    s.barycentrics = vec2(0.0f, 0.0f);
    bool found = false;
    if (FEATURE(kFeatureEmissiveTriangles) && kind == kEmitterTriangle) {
        found = sampleTriangleEmitter(e, p, u, s);
        if (FEATURE(kFeatureClearcoat) && found && (e.kind & kEmitterCoated) != 0u) {
            s.radiance = coatedEmission(scene, e, s.barycentrics, s.wi);
        } else if (FEATURE(kFeatureEmissiveTextures) && found &&
                   (e.kind & kEmitterTextured) != 0u) {
            s.radiance *= emitterTexture(scene, e.slot, s.barycentrics);
        }
        // Rays meet a transparent emitter with probability alpha: so much of it shines.
        if (FEATURE(kFeatureAlpha) && found && (e.kind & kEmitterAlpha) != 0u)
            s.radiance *= surfaceAlpha(scene, e.slot, s.barycentrics);
    }
    if (FEATURE(kFeaturePunctualLights) && kind >= kEmitterPoint && kind <= kEmitterDirectional) {
        found = samplePunctual(e, p, s);
    }
    if (FEATURE(kFeatureEnvironment) && kind == kEmitterEnvironment) {
        found = sampleEnvironment(scene, settings, region, u, s);
    }
    if (FEATURE(kFeatureSun) && kind == kEmitterSun) {
        found = sampleSun(e, u, s);
    }
    return found;
}

SHARED_END

#endif
