// How the shared text reaches scene data: a handful of fetch functions. In GLSL they are prototypes
// that shaders/scene.glsl defines over texel buffers; in C++ they read core::World through the
// pointers of a SceneView. Either way every function that reads the scene takes one as its first
// argument. On the device it holds nothing that is ever read: the buffers are bound, and the
// argument vanishes when functions are inlined.
#ifndef REKINDLE_SHARED_SCENE_H
#define REKINDLE_SHARED_SCENE_H

#include "layout.h"

#ifdef __cplusplus

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#ifdef __F16C__
#include <immintrin.h>
#endif
#if defined(__clang__) && defined(__x86_64__)
#include <glm/gtc/packing.hpp>
#endif

SHARED_BEGIN

/// Pointers into a core::World, which must outlive it. `attributes`, `extra`, `triangleEmitter` and
/// `instances` may be null.
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
    const uvec4* emitterTree;
    const vec4* environment;
    const float* environmentCdf;
    const uvec4* skyRegions;
    const uvec4* instances;  // instances.h; may be null
};

inline float halfAsFloat(uint16_t bits)
{
#if defined(__clang__) && defined(__F16C__)
    return _cvtsh_ss(bits);
#elif defined(__clang__) && defined(__x86_64__)  // Clang 14 has the type for newest processors only
    return glm::unpackHalf1x16(bits);
#else
    __extension__ using Half = _Float16;
    return static_cast<float>(std::bit_cast<Half>(bits));
#endif
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

// Static, not inline, where a source file has features of its own: see lang.h.
SHARED_FN bool hasVertexAttributes(const SceneView& scene)
{
    return FEATURE(kFeatureShadingNormals | kFeatureTextures | kFeatureVertexExtra) &&
           scene.attributes != nullptr;
}

SHARED_FN bool hasVertexExtra(const SceneView& scene)
{
    return FEATURE(kFeatureVertexExtra) && scene.extra != nullptr;
}

SHARED_FN bool hasInstances(const SceneView& scene)
{
    return FEATURE(kFeatureInstances) && scene.instances != nullptr;
}

inline uvec4 fetchInstanceWord(const SceneView& scene, uint word)
{
    return scene.instances[word];
}

inline VertexAttributes fetchVertexAttributes(const SceneView& scene, uint vertex)
{
    return scene.attributes[vertex];
}

inline VertexExtra fetchVertexExtra(const SceneView& scene, uint vertex)
{
    return scene.extra[vertex];
}

/// Word `word` of 16 bytes of a record, as the device fetches it.
template <class Word, class Record> Word fetchWord(const Record& record, uint word)
{
    static_assert(sizeof(Word) == 16 && sizeof(Record) % 16 == 0);
    Word result;
    std::memcpy(&result, reinterpret_cast<const std::byte*>(&record) + 16u * word, sizeof(Word));
    return result;
}

inline vec4 fetchMaterial(const SceneView& scene, uint material, uint word)
{
    return fetchWord<vec4>(scene.materials[material], word);
}

inline uvec4 fetchTextureReference(const SceneView& scene, uint reference, uint word)
{
    return fetchWord<uvec4>(scene.textureReferences[reference], word);
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

/// Asks memory for an emitter that is fetched soon: they lie anywhere among many, and a processor
/// would wait for each.
inline void prefetchEmitter(const SceneView& scene, uint emitter)
{
    __builtin_prefetch(scene.emitters + emitter);
}

/// The same for a node of their tree, of 144 bytes.
inline void prefetchEmitterNode(const SceneView& scene, uint word)
{
    const uvec4* node = scene.emitterTree + word;
    __builtin_prefetch(node);
    __builtin_prefetch(node + 4);
    __builtin_prefetch(node + 8);
}

inline float fetchEmitterCdf(const SceneView& scene, uint i)
{
    return scene.emitterCdf[i];
}

inline uvec4 fetchEmitterTree(const SceneView& scene, uint word)
{
    return scene.emitterTree[word];
}

inline vec4 fetchEnvironmentTexel(const SceneView& scene, uint i)
{
    return scene.environment[i];
}

inline float fetchEnvironmentCdf(const SceneView& scene, uint i)
{
    return scene.environmentCdf[i];
}

inline uvec4 fetchSkyRegions(const SceneView& scene, uint word)
{
    return scene.skyRegions[word];
}

SHARED_END

#else

struct SceneView {
    uint unused;  // a structure without members is not allowed
};

/// Three vertex indices and the material of a triangle, by the scene's own numbering.
uvec4 fetchTriangleIndices(SceneView scene, uint triangle);
/// Vertex k of the triangle in a slot, below kFirstInstancedSlot, as it is stored; w: k = 0 its
/// index in the scene, 1 its material and alpha bit, 2 its emitter.
vec4 fetchTriangleVertex(SceneView scene, uint slot, uint k);
/// Whether slots can belong to instances.
bool hasInstances(SceneView scene);
uvec4 fetchInstanceWord(SceneView scene, uint word);
/// Whether vertices have normals or coordinates that the features here look at.
bool hasVertexAttributes(SceneView scene);
/// Whether vertices have colours or second coordinates that the features here look at.
bool hasVertexExtra(SceneView scene);
VertexAttributes fetchVertexAttributes(SceneView scene, uint vertex);
VertexExtra fetchVertexExtra(SceneView scene, uint vertex);
vec4 fetchMaterial(SceneView scene, uint material, uint word);
uvec4 fetchTextureReference(SceneView scene, uint reference, uint word);
vec4 fetchTexel(SceneView scene, uint texel);
Emitter fetchEmitter(SceneView scene, uint emitter);
// Devices have other paths to follow while one waits.
void prefetchEmitter(SceneView scene, uint emitter) {}
void prefetchEmitterNode(SceneView scene, uint word) {}
float fetchEmitterCdf(SceneView scene, uint i);
uvec4 fetchEmitterTree(SceneView scene, uint word);
vec4 fetchEnvironmentTexel(SceneView scene, uint i);
float fetchEnvironmentCdf(SceneView scene, uint i);
uvec4 fetchSkyRegions(SceneView scene, uint word);

#endif

#endif
