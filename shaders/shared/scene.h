// How the shared text reaches scene data: a handful of fetch functions. In GLSL they are prototypes
// that shaders/scene_buffers.glsl defines over texel buffers; in C++ they read core::World through
// a SceneView, which SCENE_PARAM and SCENE_ARG carry along.
#ifndef REKINDLE_SHARED_SCENE_H
#define REKINDLE_SHARED_SCENE_H

#include "layout.h"

#ifdef __cplusplus

#include <bit>
#include <cstdint>
#ifdef __F16C__
#include <immintrin.h>
#endif

#define SCENE_PARAM const SceneView &scene,
#define SCENE_ARG scene,

SHARED_BEGIN

/// Pointers into a core::World, which must outlive it. `attributes`, `extra` and `triangleEmitter`
/// may be null.
struct SceneView {
    const vec3* positions;
    const VertexAttributes* attributes;
    const VertexExtra* extra;
    const WorldTriangle* triangles;
    const uint* triangleEmitter;
    const Material* materials;
    const TextureReference* textureReferences;
    const uint16_t* texels;  // four half floats each
    const Emitter* emitters;
    const float* emitterCdf;
    const vec4* environment;
    const float* environmentCdf;
};

inline float halfAsFloat(uint16_t bits)
{
    __extension__ using Half = _Float16;
    return static_cast<float>(std::bit_cast<Half>(bits));
}

inline uvec4 fetchTriangleIndices(const SceneView& scene, uint triangle)
{
    const WorldTriangle& t = scene.triangles[triangle];
    return uvec4(t.v0, t.v1, t.v2, t.material);
}

inline vec4 fetchTriangleVertex(const SceneView& scene, uint slot, uint k)
{
    const WorldTriangle& t = scene.triangles[slot];
    if (k == 0u) return vec4(scene.positions[t.v0], uintAsFloat(slot));
    if (k == 1u) {
        const bool alpha =
            (scene.materials[t.material].flags & (kMaterialAlphaMask | kMaterialAlphaBlend)) != 0u;
        return vec4(scene.positions[t.v1],
                    uintAsFloat(t.material | (alpha ? kTriangleAlphaBit : 0u)));
    }
    return vec4(
        scene.positions[t.v2],
        uintAsFloat(scene.triangleEmitter != nullptr ? scene.triangleEmitter[slot] : kNone));
}

inline VertexAttributes fetchVertexAttributes(const SceneView& scene, uint vertex)
{
    return scene.attributes[vertex];
}

inline VertexExtra fetchVertexExtra(const SceneView& scene, uint vertex)
{
    return scene.extra[vertex];
}

inline vec4 fetchMaterial(const SceneView& scene, uint material, uint word)
{
    const float* f = &scene.materials[material].baseColor.x + 4u * word;
    return vec4(f[0], f[1], f[2], f[3]);
}

inline uvec4 fetchTextureReference(const SceneView& scene, uint reference, uint word)
{
    const uint* f = &scene.textureReferences[reference].firstTexel + 4u * word;
    return uvec4(f[0], f[1], f[2], f[3]);
}

inline vec4 fetchTexel(const SceneView& scene, uint texel)
{
    const uint16_t* h = scene.texels + 4u * size_t(texel);
#ifdef __F16C__
    alignas(16) float v[4];
    _mm_store_ps(v, _mm_cvtph_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(h))));
    return vec4(v[0], v[1], v[2], v[3]);
#endif
    return vec4(halfAsFloat(h[0]), halfAsFloat(h[1]), halfAsFloat(h[2]), halfAsFloat(h[3]));
}

inline Emitter fetchEmitter(const SceneView& scene, uint emitter)
{
    return scene.emitters[emitter];
}

inline float fetchEmitterCdf(const SceneView& scene, uint i)
{
    return scene.emitterCdf[i];
}

inline vec4 fetchEnvironmentTexel(const SceneView& scene, uint i)
{
    return scene.environment[i];
}

inline float fetchEnvironmentCdf(const SceneView& scene, uint i)
{
    return scene.environmentCdf[i];
}

SHARED_END

#else

#define SCENE_PARAM
#define SCENE_ARG

/// Three vertex indices and the material of a triangle, by the scene's own numbering.
uvec4 fetchTriangleIndices(uint triangle);
/// Vertex k of the triangle in a slot; w: k = 0 its index in the scene, 1 its material and alpha
/// bit, 2 its emitter.
vec4 fetchTriangleVertex(uint slot, uint k);
VertexAttributes fetchVertexAttributes(uint vertex);
VertexExtra fetchVertexExtra(uint vertex);
vec4 fetchMaterial(uint material, uint word);
uvec4 fetchTextureReference(uint reference, uint word);
vec4 fetchTexel(uint texel);
Emitter fetchEmitter(uint emitter);
float fetchEmitterCdf(uint i);
vec4 fetchEnvironmentTexel(uint i);
float fetchEnvironmentCdf(uint i);

#endif

#endif
