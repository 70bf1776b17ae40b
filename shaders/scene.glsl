// Set 0: the scene as kernels see it, texel buffers behind the fetch functions of shared/scene.h and of the BVH.
#ifndef REKINDLE_SCENE_GLSL
#define REKINDLE_SCENE_GLSL

#include "shared/bindings.h"
#include "shared/scene.h"

layout(set = kSetScene, binding = kBindNodes) uniform usamplerBuffer nodeWords;
layout(set = kSetScene, binding = kBindTriangles) uniform usamplerBuffer triangleWords;
layout(set = kSetScene, binding = kBindIndices) uniform usamplerBuffer indexWords;
layout(set = kSetScene, binding = kBindAttributes) uniform usamplerBuffer attributeWords;
layout(set = kSetScene, binding = kBindExtra) uniform usamplerBuffer extraWords;
layout(set = kSetScene, binding = kBindMaterials) uniform usamplerBuffer materialWords;
layout(set = kSetScene, binding = kBindTextureReferences) uniform usamplerBuffer textureReferenceWords;
layout(set = kSetScene, binding = kBindEmitters) uniform usamplerBuffer emitterWords;
layout(set = kSetScene, binding = kBindTexels) uniform samplerBuffer texels;
layout(set = kSetScene, binding = kBindEmitterCdf) uniform samplerBuffer emitterCdf;
layout(set = kSetScene, binding = kBindEnvironment) uniform samplerBuffer environmentTexels;
layout(set = kSetScene, binding = kBindEnvironmentCdf) uniform samplerBuffer environmentCdf;
layout(set = kSetScene, binding = kBindEmitterTree) uniform usamplerBuffer emitterTreeWords;
layout(set = kSetScene, binding = kBindInstances) uniform usamplerBuffer instanceWords;
layout(set = kSetScene, binding = kBindSkyRegions) uniform usamplerBuffer skyRegionWords;

const SceneView scene = SceneView(0u);  // for the functions that take one

/// Word `i` of the BVH's nodes, two to a node: core/trace/bvh.h.
uvec4 fetchNode(uint i)
{
    return texelFetch(nodeWords, int(i));
}

uvec4 fetchTriangleIndices(SceneView view, uint triangle)
{
    return texelFetch(indexWords, int(triangle));
}

vec4 fetchTriangleVertex(SceneView view, uint slot, uint k)
{
    return uintBitsToFloat(texelFetch(triangleWords, int(3u * slot + k)));
}

bool hasInstances(SceneView view)
{
    return FEATURE(kFeatureInstances);
}

uvec4 fetchInstanceWord(SceneView view, uint word)
{
    return texelFetch(instanceWords, int(word));
}

bool hasVertexAttributes(SceneView view)
{
    return FEATURE(kFeatureShadingNormals | kFeatureTextures | kFeatureVertexExtra);
}

bool hasVertexExtra(SceneView view)
{
    return FEATURE(kFeatureVertexExtra);
}

VertexAttributes fetchVertexAttributes(SceneView view, uint vertex)
{
    const uvec4 word = texelFetch(attributeWords, int(vertex));
    return VertexAttributes(word.x, uintBitsToFloat(word.y), uintBitsToFloat(word.z), word.w);
}

VertexExtra fetchVertexExtra(SceneView view, uint vertex)
{
    const uvec4 word = texelFetch(extraWords, int(vertex));
    return VertexExtra(uintBitsToFloat(word.x), uintBitsToFloat(word.y), word.z, word.w);
}

vec4 fetchMaterial(SceneView view, uint material, uint word)
{
    return uintBitsToFloat(texelFetch(materialWords, int(material * kMaterialWords + word)));
}

uvec4 fetchTextureReference(SceneView view, uint reference, uint word)
{
    return texelFetch(textureReferenceWords, int(reference * kTextureReferenceWords + word));
}

vec4 fetchTexel(SceneView view, uint texel)
{
    return texelFetch(texels, int(texel));
}

Emitter fetchEmitter(SceneView view, uint emitter)
{
    const int first = int(emitter * kEmitterWords);
    const uvec4 a = texelFetch(emitterWords, first);
    const uvec4 b = texelFetch(emitterWords, first + 1);
    const uvec4 c = texelFetch(emitterWords, first + 2);
    const uvec4 d = texelFetch(emitterWords, first + 3);
    return Emitter(uintBitsToFloat(a.xyz), a.w, uintBitsToFloat(b.xyz), b.w, uintBitsToFloat(c.xyz),
                   uintBitsToFloat(c.w), uintBitsToFloat(d.xyz), uintBitsToFloat(d.w));
}

float fetchEmitterCdf(SceneView view, uint i)
{
    return texelFetch(emitterCdf, int(i)).x;
}

uvec4 fetchEmitterTree(SceneView view, uint word)
{
    return texelFetch(emitterTreeWords, int(word));
}

vec4 fetchEnvironmentTexel(SceneView view, uint i)
{
    return texelFetch(environmentTexels, int(i));
}

float fetchEnvironmentCdf(SceneView view, uint i)
{
    return texelFetch(environmentCdf, int(i)).x;
}

uvec4 fetchSkyRegions(SceneView view, uint word)
{
    return texelFetch(skyRegionWords, int(word));
}

#endif
