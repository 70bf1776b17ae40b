// From a hit to what shading needs: position, frames, texture coordinates, material, emission,
// alpha. Ray origins are offset after Waechter and Binder, "A Fast and Robust Method for Avoiding
// Self-Intersection" (2019), from barycentric hit points, in a scene that is recentred at load; but
// at least by what the size of the triangle asks for.
#ifndef REKINDLE_SHARED_SURFACE_H
#define REKINDLE_SHARED_SURFACE_H

#include "bsdf.h"
#include "instances.h"
#include "rng.h"
#include "scene.h"
#include "warp.h"

SHARED_BEGIN

SHARED_CONST float kOffEdge = 3.0e-5f;  // of the largest coordinate: 256 steps of a float
SHARED_CONST float kLeastOffset = 2.384185791015625e-7f;  // 2^-22: see leastOffset

/// Barycentrics of a hit moved at least as far from the edges of its triangle as rays start off it.
/// A point on the edge of two walls may otherwise lie behind one of them, by rounding, and see
/// nothing. Pixel centres may meet such edges on whole diagonals of a picture.
SHARED_FN vec2 insideTriangle(Triangle t, vec2 barycentrics)
{
    const vec3 v0 = xyz(t.v0);
    const vec3 v1 = xyz(t.v1);
    const vec3 v2 = xyz(t.v2);
    const float area = length(cross(v1 - v0, v2 - v0));  // twice
    const float distance = kOffEdge * maxComponent(max(max(abs(v0), abs(v1)), abs(v2)));
    const vec3 edges = vec3(length(v1 - v2), length(v2 - v0), length(v0 - v1));
    // An edge's distance from the opposite corner is the area over its length.
    const vec3 least = min(edges * (distance / max(area, 1.0e-30f)), vec3(1.0f / 3.0f));
    vec3 w = vec3(1.0f - barycentrics.x - barycentrics.y, barycentrics.x, barycentrics.y);
    w = max(w, least);
    // What the others took comes from the largest, which has a third at least.
    const float excess = w.x + w.y + w.z - 1.0f;
    if (w.y > w.x && w.y >= w.z)
        w.y -= excess;
    else if (w.z > w.x && w.z > w.y)
        w.z -= excess;
    return vec2(w.y, w.z);
}

/// The nearest intersection: distance, weights of the second and third vertex, slot of the
/// triangle.
struct Hit {
    float t;
    vec2 barycentrics;
    uint slot;
};

struct SurfacePoint {
    vec3 position;
    vec3 normal;  // geometric, unit, of the front face
    mat3 frame;   // shading: columns tangent, bitangent, normal on the side of wo
    vec2 uv0;
    vec2 uv1;
    vec4 color;    // vertex colour, or one
    float offset;  // least distance at which rays start: see offsetRay
    uint material;
    uint emitter;   // or kNone
    uint triangle;  // the scene's own numbering
    uint backFace;  // 1: seen from behind
};

/// The least distance from a triangle at which rays leave it. The errors of a hit's position and of
/// intersectTriangle's t grow with the triangle's own coordinates, however small those of the hit
/// are; the second also with how narrow it is. `placed`: the largest number that was added to bring
/// the triangle here. Measured with planes and strips of +-1 to +-100 beside the origin, at all
/// tilts: of rays that leave them by half of this, up to one in a hundred meet them again; by this,
/// one in a million at most, but for strips over a thousand times as long as wide.
SHARED_FN float leastOffset(vec3 a, vec3 b, vec3 c, float placed)
{
    const vec3 e0 = b - a;
    const vec3 e1 = c - b;
    const vec3 e2 = c - a;
    const vec3 n = cross(e0, e2);
    const float area2 = dot(n, n);  // the square of twice the area
    const float longest2 = max(max(dot(e0, e0), dot(e1, e1)), dot(e2, e2));
    const float placing = kLeastOffset * (maxComponent(max(max(abs(a), abs(b)), abs(c))) + placed);
    // Most triangles are not narrow, which squares tell without roots and divisions.
    const float share2 = 0.0625f * kLeastOffset * kLeastOffset;
    if (!(share2 * longest2 * longest2 * longest2 > placing * placing * area2)) return placing;
    const float height = sqrt(area2 / max(longest2, 1.0e-36f));
    const float narrow = 0.25f * kLeastOffset * longest2 / max(height, 1.0e-18f);
    return max(placing, min(narrow, 0.1f * height));
}

/// Shifts a point off its surface, to the side of `n` (unit), by some units in the last place.
SHARED_FN vec3 offsetRay(vec3 p, vec3 n)
{
    const float kOrigin = 1.0f / 32.0f;
    const vec3 nearZero = p + n * (1.0f / 65536.0f);
    const ivec3 ulps = ivec3(n * 256.0f);
    vec3 shifted;
    shifted.x = uintAsFloat(floatAsUint(p.x) + uint(p.x < 0.0f ? -ulps.x : ulps.x));
    shifted.y = uintAsFloat(floatAsUint(p.y) + uint(p.y < 0.0f ? -ulps.y : ulps.y));
    shifted.z = uintAsFloat(floatAsUint(p.z) + uint(p.z < 0.0f ? -ulps.z : ulps.z));
    return vec3(abs(p.x) < kOrigin ? nearZero.x : shifted.x,
                abs(p.y) < kOrigin ? nearZero.y : shifted.y,
                abs(p.z) < kOrigin ? nearZero.z : shifted.z);
}

/// The same, but at least by `least`: what the surface's triangle asks for.
SHARED_FN vec3 offsetRay(vec3 p, vec3 n, float least)
{
    const vec3 shifted = offsetRay(p, n);
    return dot(shifted - p, n) < least ? p + least * n : shifted;
}

/// A coordinate of a texture folded into [0, 1] as its wrap mode says. In float: integer division
/// is slow everywhere.
SHARED_FN float foldCoordinate(float u, uint mode)
{
    if (mode == kWrapRepeat) return u - floor(u);
    if (mode == kWrapClamp) return clamp(u, 0.0f, 1.0f);
    const float t = u - 2.0f * floor(0.5f * u);
    return t > 1.0f ? 2.0f - t : t;
}

/// Index of a texel that is at most one off the texture: the other end, or (mirrored or clamped)
/// the end itself.
SHARED_FN uint wrapTexel(int i, int size, uint mode)
{
    if (mode != kWrapRepeat) return uint(clamp(i, 0, size - 1));
    return uint(i < 0 ? i + size : (i < size ? i : i - size));
}

/// Bilinear (or nearest) look-up; row 0 is at v = 0 as in glTF. Coordinates that are not finite
/// read some texel.
SHARED_FN vec4 lookUpTexture(IN(SceneView) scene, uint reference, vec2 uv0, vec2 uv1)
{
    const uvec4 head = fetchTextureReference(scene, reference, 0u);
    const uint flags = head.w;
    vec2 uv = (flags & kTextureTexCoord1) != 0u ? uv1 : uv0;
    if ((flags & kTextureTransformed) != 0u) {
        const uvec4 row0 = fetchTextureReference(scene, reference, 1u);
        const uvec4 row1 = fetchTextureReference(scene, reference, 2u);
        uv = vec2(uintAsFloat(row0.x) * uv.x + uintAsFloat(row0.y) * uv.y + uintAsFloat(row0.z),
                  uintAsFloat(row1.x) * uv.x + uintAsFloat(row1.y) * uv.y + uintAsFloat(row1.z));
    }
    const int width = int(head.y);
    const int height = int(head.z);
    const uint wrapS = (flags >> kTextureWrapSShift) & 3u;
    const uint wrapT = (flags >> kTextureWrapTShift) & 3u;
    uv = vec2(foldCoordinate(uv.x, wrapS), foldCoordinate(uv.y, wrapT));
    uv = vec2(uv.x >= 0.0f ? uv.x : 0.0f, uv.y >= 0.0f ? uv.y : 0.0f);  // no number: some texel
    vec2 texel = vec2(uv.x * float(width), uv.y * float(height));
    const bool nearest = (flags & kTextureNearest) != 0u;
    texel = nearest ? texel : texel - vec2(0.5f, 0.5f);
    const vec2 corner = floor(texel);
    const vec2 f = nearest ? vec2(0.0f, 0.0f) : texel - corner;
    const int x = int(corner.x);
    const int y = int(corner.y);
    const uint x0 = wrapTexel(x, width, wrapS);
    const uint row0 = head.x + wrapTexel(y, height, wrapT) * head.y;
    if (nearest) return fetchTexel(scene, row0 + x0);
    const uint x1 = wrapTexel(x + 1, width, wrapS);
    const uint row1 = head.x + wrapTexel(y + 1, height, wrapT) * head.y;
    const vec4 top = mix(fetchTexel(scene, row0 + x0), fetchTexel(scene, row0 + x1), f.x);
    const vec4 bottom = mix(fetchTexel(scene, row1 + x0), fetchTexel(scene, row1 + x1), f.x);
    return mix(top, bottom, f.y);
}

/// 1 + texture reference of a slot, 0 for none. Words 5 and 6 of the material hold them, 16 bits
/// each.
SHARED_FN uint textureOfSlot(vec4 word5, vec4 word6, uint slot)
{
    uint pair = floatAsUint(word5.w);
    if (slot >= 8u) {
        pair = floatAsUint(word6.w);
    } else if (slot >= 6u) {
        pair = floatAsUint(word6.z);
    } else if (slot >= 4u) {
        pair = floatAsUint(word6.y);
    } else if (slot >= 2u) {
        pair = floatAsUint(word6.x);
    }
    return (slot & 1u) != 0u ? pair >> 16u : pair & 0xffffu;
}

SHARED_FN vec2 interpolate(vec2 a, vec2 b, vec2 c, vec2 w)
{
    return (1.0f - w.x - w.y) * a + w.x * b + w.y * c;
}

SHARED_FN vec4 unpackHalfColor(uint rg, uint ba)
{
    const vec2 a = unpackHalf2x16(rg);
    const vec2 b = unpackHalf2x16(ba);
    return vec4(a.x, a.y, b.x, b.y);
}

/// Texture coordinates and colour at a point of a triangle (`vertices` as fetchTriangleIndices
/// gives them).
SHARED_FN void interpolateVertexExtra(IN(SceneView) scene, uvec4 vertices, vec2 w, OUT(vec2) uv1,
                                      OUT(vec4) color)
{
    const VertexExtra a = fetchVertexExtra(scene, vertices.x);
    const VertexExtra b = fetchVertexExtra(scene, vertices.y);
    const VertexExtra c = fetchVertexExtra(scene, vertices.z);
    uv1 = interpolate(vec2(a.u1, a.v1), vec2(b.u1, b.v1), vec2(c.u1, c.v1), w);
    color = (1.0f - w.x - w.y) * unpackHalfColor(a.colorRg, a.colorBa) +
            w.x * unpackHalfColor(b.colorRg, b.colorBa) +
            w.y * unpackHalfColor(c.colorRg, c.colorBa);
}

/// Bends a shading normal until `wo` is above it (cos >= 0.001): a view from under the shading
/// horizon has no meaning.
SHARED_FN vec3 ensureVisible(vec3 n, vec3 wo)
{
    const float kLowest = 0.001f;
    const float cosine = dot(n, wo);
    return cosine >= kLowest ? n : normalize(n + (kLowest - cosine) * 1.001f * wo);
}

/// Sets all of `s` but what the triangle is: its vertices a, b and c are in the world, what else
/// they have in the space of `stored`. `direction` is that of the ray, unit.
SHARED_FN void layOutSurface(IN(SceneView) scene, StoredTriangle stored, vec3 a, vec3 b, vec3 c,
                             vec2 w, vec3 direction, INOUT(SurfacePoint) s)
{
    const vec3 e1 = b - a;
    const vec3 e2 = c - a;
    s.position = a + w.x * e1 + w.y * e2;
    s.normal = normalize(cross(e1, e2));
    s.backFace = dot(direction, s.normal) > 0.0f ? 1u : 0u;
    s.uv0 = vec2(0.0f, 0.0f);
    s.uv1 = vec2(0.0f, 0.0f);
    s.color = vec4(1.0f, 1.0f, 1.0f, 1.0f);

    vec3 n = s.normal;
    vec4 tangent = vec4(0.0f, 0.0f, 0.0f, 0.0f);
    if (hasVertexAttributes(scene)) {
        const uvec4 vertices = fetchTriangleIndices(scene, s.triangle);
        const VertexAttributes va = fetchVertexAttributes(scene, vertices.x);
        const VertexAttributes vb = fetchVertexAttributes(scene, vertices.y);
        const VertexAttributes vc = fetchVertexAttributes(scene, vertices.z);
        s.uv0 = interpolate(vec2(va.u, va.v), vec2(vb.u, vb.v), vec2(vc.u, vc.v), w);
        if (FEATURE(kFeatureShadingNormals) && va.normal != kNoNormal) {
            const vec3 ns = (1.0f - w.x - w.y) * unpackOct(va.normal) + w.x * unpackOct(vb.normal) +
                            w.y * unpackOct(vc.normal);
            const float length2 = dot(ns, ns);
            if (length2 > 1.0e-8f) n = placedNormal(scene, stored, ns * inversesqrt(length2));
        }
        if (FEATURE(kFeatureNormalMaps)) {
            tangent = unpackTangent(va.tangent) * (1.0f - w.x - w.y) +
                      unpackTangent(vb.tangent) * w.x + unpackTangent(vc.tangent) * w.y;
            tangent = vec4(placedTangent(scene, stored, xyz(tangent)), 0.0f);
            tangent.w = unpackTangent(va.tangent).w;
        }
        if (hasVertexExtra(scene)) interpolateVertexExtra(scene, vertices, w, s.uv1, s.color);
    }
    n = dot(n, s.normal) < 0.0f ? -n : n;  // the geometric front decides
    const float side = s.backFace != 0u ? -1.0f : 1.0f;
    n = ensureVisible(side * n, -direction);
    s.frame = makeFrame(n);
    if (FEATURE(kFeatureNormalMaps)) {
        const vec3 t = xyz(tangent) - n * dot(n, xyz(tangent));
        const float length2 = dot(t, t);
        if (length2 > 1.0e-8f) {
            const vec3 unit = t * inversesqrt(length2);
            s.frame = mat3(unit, cross(side * n, unit) * (tangent.w < 0.0f ? -1.0f : 1.0f), n);
        }
    }
}

/// Everything about the hit but its material. `direction` is that of the ray, unit.
SHARED_FN SurfacePoint makeSurfacePoint(IN(SceneView) scene, Hit hit, vec3 direction)
{
    const StoredTriangle stored = findTriangle(scene, hit.slot);
    const Triangle v = fetchTriangle(scene, stored);
    SurfacePoint s;
    s.triangle = floatAsUint(v.v0.w);
    s.material = floatAsUint(v.v1.w) & ~kTriangleAlphaBit;
    s.emitter = floatAsUint(v.v2.w);
    s.offset = leastOffset(xyz(v.v0), xyz(v.v1), xyz(v.v2), placedBy(scene, stored));
    layOutSurface(scene, stored, xyz(v.v0), xyz(v.v1), xyz(v.v2), hit.barycentrics, direction, s);
    return s;
}

/// Replaces the shading normal by that of the normal map, if the material has one.
SHARED_FN void applyNormalMap(IN(SceneView) scene, uint reference, float scale, vec3 direction,
                              INOUT(SurfacePoint) s)
{
    const vec4 texel = lookUpTexture(scene, reference, s.uv0, s.uv1);
    vec3 m = vec3(scale * (2.0f * texel.x - 1.0f), scale * (2.0f * texel.y - 1.0f),
                  2.0f * texel.z - 1.0f);
    const float length2 = dot(m, m);
    m = length2 > 1.0e-8f ? m * inversesqrt(length2) : vec3(0.0f, 0.0f, 1.0f);
    // From behind the whole normal is reversed, as glTF has it: what is a bump is a dent there.
    const float side = s.backFace != 0u ? -1.0f : 1.0f;
    const vec3 n = s.frame * vec3(side * m.x, side * m.y, max(m.z, 0.01f));
    s.frame = makeFrame(ensureVisible(normalize(n), -direction));
}

/// What a material says at a point.
struct Shading {
    BsdfInputs inputs;
    vec3 emission;  // radiance that leaves towards wo
};

/// Reads the material at `s` with its textures; perturbs the frame where there is a normal map.
SHARED_FN Shading evaluateMaterial(IN(SceneView) scene, INOUT(SurfacePoint) s, vec3 direction)
{
    const vec4 word0 = fetchMaterial(scene, s.material, 0u);
    const vec4 word5 = fetchMaterial(scene, s.material, 5u);
    const uint flags = floatAsUint(word5.z);
    Shading shading;
    shading.emission = vec3(0.0f, 0.0f, 0.0f);
    shading.inputs.baseColor = xyz(word0) * xyz(s.color);
    shading.inputs.metallic = 0.0f;
    shading.inputs.roughness = 1.0f;
    shading.inputs.ior = 1.5f;
    shading.inputs.transmission = 0.0f;
    shading.inputs.specularColor = vec3(1.0f, 1.0f, 1.0f);
    shading.inputs.specular = 0.0f;
    shading.inputs.clearcoat = 0.0f;
    shading.inputs.clearcoatRoughness = 0.0f;
    shading.inputs.flags = flags;
    shading.inputs.backFace = s.backFace;

    const bool shiny = FEATURE(kFeatureSpecular | kFeatureTransmission | kFeatureMetal);
    if (shiny) {
        const vec4 word2 = fetchMaterial(scene, s.material, 2u);
        const vec4 word3 = fetchMaterial(scene, s.material, 3u);
        shading.inputs.metallic = word2.x;
        shading.inputs.roughness = word2.y;
        shading.inputs.ior = word2.z;
        shading.inputs.transmission = word2.w;
        shading.inputs.specularColor = xyz(word3);
        shading.inputs.specular = word3.w;
    }
    if (FEATURE(kFeatureClearcoat)) {
        shading.inputs.clearcoat = word5.x;
        shading.inputs.clearcoatRoughness = word5.y;
    }
    const bool emits = FEATURE(kFeatureEmissiveTriangles) &&
                       (s.backFace == 0u || (flags & kMaterialDoubleSided) != 0u);
    if (emits) shading.emission = xyz(fetchMaterial(scene, s.material, 1u));

    if (FEATURE(kFeatureTextures)) {
        const vec4 word6 = fetchMaterial(scene, s.material, 6u);
        uint t = textureOfSlot(word5, word6, kTextureBaseColor);
        if (t != 0u) shading.inputs.baseColor *= xyz(lookUpTexture(scene, t - 1u, s.uv0, s.uv1));
        if (shiny) {
            t = textureOfSlot(word5, word6, kTextureMetallicRoughness);
            if (t != 0u) {
                const vec4 texel = lookUpTexture(scene, t - 1u, s.uv0, s.uv1);
                shading.inputs.roughness *= texel.y;
                shading.inputs.metallic *= texel.z;
            }
            t = textureOfSlot(word5, word6, kTextureSpecular);
            if (t != 0u) shading.inputs.specular *= lookUpTexture(scene, t - 1u, s.uv0, s.uv1).w;
            t = textureOfSlot(word5, word6, kTextureSpecularColor);
            if (t != 0u) {
                shading.inputs.specularColor *= xyz(lookUpTexture(scene, t - 1u, s.uv0, s.uv1));
            }
        }
        if (FEATURE(kFeatureTransmission)) {
            t = textureOfSlot(word5, word6, kTextureTransmission);
            if (t != 0u)
                shading.inputs.transmission *= lookUpTexture(scene, t - 1u, s.uv0, s.uv1).x;
        }
        if (FEATURE(kFeatureClearcoat)) {
            t = textureOfSlot(word5, word6, kTextureClearcoat);
            if (t != 0u) shading.inputs.clearcoat *= lookUpTexture(scene, t - 1u, s.uv0, s.uv1).x;
            t = textureOfSlot(word5, word6, kTextureClearcoatRoughness);
            if (t != 0u) {
                shading.inputs.clearcoatRoughness *= lookUpTexture(scene, t - 1u, s.uv0, s.uv1).y;
            }
        }
        if (FEATURE(kFeatureEmissiveTextures)) {
            t = textureOfSlot(word5, word6, kTextureEmissive);
            if (t != 0u && emits)
                shading.emission *= xyz(lookUpTexture(scene, t - 1u, s.uv0, s.uv1));
        }
        if (FEATURE(kFeatureNormalMaps)) {
            t = textureOfSlot(word5, word6, kTextureNormal);
            if (t != 0u)
                applyNormalMap(scene, t - 1u, fetchMaterial(scene, s.material, 4u).w, direction, s);
        }
    }
    if (FEATURE(kFeatureClearcoat) && emits && shading.inputs.clearcoat > 0.0f)
        shading.emission *=
            emissionThroughCoat(shading.inputs.clearcoat, -dot(s.frame[2], direction));
    if ((flags & kMaterialUnlit) != 0u) shading.emission = shading.inputs.baseColor;
    return shading;
}

/// How much of the surface is there at a point of a triangle: 0 or 1 where alpha is a mask, alpha
/// where it blends, 1 where the material has neither.
SHARED_FN float surfaceAlpha(IN(SceneView) scene, uint triangle, vec2 barycentrics)
{
    const uvec4 vertices = fetchTriangleIndices(scene, triangle);
    const vec4 word5 = fetchMaterial(scene, vertices.w, 5u);
    const uint flags = floatAsUint(word5.z);
    if ((flags & (kMaterialAlphaMask | kMaterialAlphaBlend)) == 0u) return 1.0f;
    float alpha = fetchMaterial(scene, vertices.w, 0u).w;
    vec2 uv0 = vec2(0.0f, 0.0f);
    vec2 uv1 = vec2(0.0f, 0.0f);
    vec4 color = vec4(1.0f, 1.0f, 1.0f, 1.0f);
    if (hasVertexExtra(scene)) interpolateVertexExtra(scene, vertices, barycentrics, uv1, color);
    const uint t =
        FEATURE(kFeatureTextures)
            ? textureOfSlot(word5, fetchMaterial(scene, vertices.w, 6u), kTextureBaseColor)
            : 0u;
    if (t != 0u) {
        const VertexAttributes a = fetchVertexAttributes(scene, vertices.x);
        const VertexAttributes b = fetchVertexAttributes(scene, vertices.y);
        const VertexAttributes c = fetchVertexAttributes(scene, vertices.z);
        uv0 = interpolate(vec2(a.u, a.v), vec2(b.u, b.v), vec2(c.u, c.v), barycentrics);
        alpha *= lookUpTexture(scene, t - 1u, uv0, uv1).w;
    }
    alpha *= color.w;
    if ((flags & kMaterialAlphaMask) != 0u) {
        return alpha >= fetchMaterial(scene, vertices.w, 1u).w ? 1.0f : 0.0f;
    }
    return alpha;
}

// A seed that leaves nothing to chance: what blends is there where alpha is a half or more.
SHARED_CONST uint kAlphaByHalf = 0xffffffffu;

/// The alpha test inside traversal: true when the surface is there for this ray. Blending is
/// stochastic: the surface is there with probability alpha, decided by a hash of `seed` and the
/// triangle, which is one of the prototype of an `instance` (counted from 1; 0: of none).
SHARED_FN bool alphaPasses(IN(SceneView) scene, uint slot, uint instance, vec2 barycentrics,
                           uint seed)
{
    const uint triangle = floatAsUint(fetchTriangleVertex(scene, slot, 0u).w);
    const float alpha = surfaceAlpha(scene, triangle, barycentrics);
    if (seed == kAlphaByHalf) return alpha >= 0.5f;
    // Two instances along a ray decide apart: a factor that is odd keeps their numbers apart, too.
    return unitFloat(hashUint(seed ^ hashUint(triangle + instance * 0x9e3779b1u))) < alpha;
}

SHARED_END

#endif
