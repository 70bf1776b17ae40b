// The choice of one emitter for a point by what it may bring there: a binary tree over triangles,
// point and spot lights, descended by the ratio of its children's importance (A. Conty Estevez,
// C. Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018; without the
// splitting). Nodes are spheres. Importance is zero only where nothing can arrive, so that no light
// is lost.
#ifndef REKINDLE_SHARED_EMITTER_TREE_H
#define REKINDLE_SHARED_EMITTER_TREE_H

#include "departure.h"
#include "layout.h"
#include "rng.h"
#include "scene.h"
#include "warp.h"

SHARED_BEGIN

// A child of a node, as stored (packEmitterBounds in core/scene/emitter_tree.cpp):
//   centre, radius of a sphere around the emitters | axis (packOct), cosines, intensity, link.
// Cosines: in 2 x 16 bits, of the half angle of a cone around axis that holds all normals, and of
// the angle to a normal beyond which nothing is emitted.
SHARED_CONST uint kEmitterLeaf = 0x80000000u;       // of a link: to an emitter, not to a node
SHARED_CONST uint kEmitterBothFaces = 0x40000000u;  // of a link: emission is to both sides of axis
SHARED_CONST uint kEmitterIndex = 0x3fffffffu;
SHARED_CONST uint kEmitterNodeWords = 4u;  // two children

/// Two 16-bit cosines of a word, both rounded so that cones hold what they shall hold.
SHARED_FN vec2 unpackCosines(uint word)
{
    return vec2(float(word & 0xffffu), float(word >> 16u)) * (2.0f / 65535.0f) - vec2(1.0f);
}

/// Cosine of the angle a - b, or 1 where b is larger.
SHARED_FN float cosineOfRest(float cosA, float sinA, float cosB, float sinB)
{
    return cosA >= cosB ? 1.0f : cosA * cosB + sinA * sinB;
}

SHARED_FN float sineOf(float cosine)
{
    return sqrt(max(1.0f - cosine * cosine, 0.0f));
}

// Random numbers are multiples of kUnitGrain; a branch is taken by no coarser ones.
SHARED_CONST float kUnitGrain = 5.9604644775390625e-8f;  // 2^-24
SHARED_CONST float kCoarseGrain = 3.814697265625e-6f;    // 2^-18

// The normal is known to 1e-3 rad, and the sphere to rounding.
SHARED_CONST float kHorizonSlack = 2.0e-3f;

/// What the emitters of a child are thought to bring to p, on the side of `normal` if `oneSided`; 0
/// only where they can bring nothing. Bounds alone would make much of what is near, whatever its
/// turn: the cosines are means of the bound and of the centre's, and distances shrink to a part of
/// the radius. Measured among 60,000 lamps (sponza-lanterns): bounds and the whole radius have 4.5
/// times the variance.
SHARED_FN float emitterImportance(uvec4 sphere, uvec4 cone, vec3 p, bool oneSided, vec3 normal)
{
    const vec3 way = uintBitsToFloat(uvec3(sphere.x, sphere.y, sphere.z)) - p;
    const float radius = uintBitsToFloat(sphere.w);
    const float square = max(dot(way, way), 1.0e-30f);
    const float radius2 = radius * radius;
    const float strength = uintBitsToFloat(cone.z) / max(square, 0.15f * radius2);
    if (square <= radius2) return strength;
    const float inverse = 1.0f / sqrt(square);
    const float sinB = radius * inverse;
    const float cosB = sineOf(sinB);
    float facing = 1.0f;
    if (oneSided) {
        const float c = dot(normal, way) * inverse;
        const float bound = cosineOfRest(c, sineOf(c), cosB, sinB) + kHorizonSlack;
        if (!(bound > 0.0f)) return 0.0f;
        facing = 0.5f * (max(c, 0.0f) + bound);
    }
    const vec2 cosines = unpackCosines(cone.y);
    float c = -dot(unpackOct(cone.x), way) * inverse;
    if ((cone.w & kEmitterBothFaces) != 0u) c = abs(c);
    float bound = cosineOfRest(c, sineOf(c), cosines.x, sineOf(cosines.x));
    bound = cosineOfRest(bound, sineOf(bound), cosB, sinB);
    if (bound <= cosines.y) return 0.0f;
    const float leaving = 0.5f * (max(c, 0.0f) + max(bound, kHorizonSlack));
    return strength * facing * leaving;
}

/// Probability of a node's first child; negative where neither can bring anything.
SHARED_FN float firstChildPmf(IN(SceneView) scene, uint node, vec3 p, bool oneSided, vec3 normal,
                              OUT(uvec2) links)
{
    const uint word = kEmitterNodeWords * node;
    const uvec4 coneA = fetchEmitterTree(scene, word + 1u);
    const uvec4 coneB = fetchEmitterTree(scene, word + 3u);
    links = uvec2(coneA.w, coneB.w);
    const float a = emitterImportance(fetchEmitterTree(scene, word), coneA, p, oneSided, normal);
    const float b =
        emitterImportance(fetchEmitterTree(scene, word + 2u), coneB, p, oneSided, normal);
    return a + b > 0.0f ? a / (a + b) : -1.0f;
}

/// The emitter that u leads to, for a point p and a `departure` from it; pmf 0 where none can bring
/// anything.
SHARED_FN uint chooseInTree(IN(SceneView) scene, vec3 p, uint departure, float u, OUT(float) pmf)
{
    vec3 normal;
    const bool oneSided = unpackReceiver(departure, normal);
    uint node = 0u;
    uint fresh = floatBitsToUint(u);
    float grain = kUnitGrain;  // what u is a multiple of, stretched
    pmf = 1.0f;
    while (true) {
        uvec2 links;
        const float a = firstChildPmf(scene, node, p, oneSided, normal, links);
        if (a < 0.0f) {
            pmf = 0.0f;
            return 0u;
        }
        const bool first = u < a;
        const float chance = first ? a : 1.0f - a;
        u = first ? u / a : (u - a) / chance;
        pmf *= chance;
        const uint link = first ? links.x : links.y;
        if ((link & kEmitterLeaf) != 0u) return link & kEmitterIndex;
        node = link & kEmitterIndex;
        // Stretched over and over, u runs out of bits: new ones fill the gaps.
        grain /= chance;
        if (grain > kCoarseGrain) {
            fresh = hashUint(fresh + node);
            u += grain * unitFloat(fresh);
            grain = kUnitGrain;
        }
        u = min(u, kOneMinusEpsilon);
    }
}

/// Probability with which chooseInTree returns `emitter`; its bits are the ways of `trail`, the
/// first the lowest.
SHARED_FN float pmfInTree(IN(SceneView) scene, uint treeEmitters, uint emitter, vec3 p,
                          uint departure)
{
    vec3 normal;
    const bool oneSided = unpackReceiver(departure, normal);
    const uint trails = kEmitterNodeWords * (treeEmitters - 1u);
    uint trail = fetchEmitterTree(scene, trails + emitter / 4u)[emitter % 4u];
    uint node = 0u;
    float pmf = 1.0f;
    while (true) {
        uvec2 links;
        const float a = firstChildPmf(scene, node, p, oneSided, normal, links);
        if (a < 0.0f) return 0.0f;
        const bool first = (trail & 1u) == 0u;
        pmf *= first ? a : 1.0f - a;
        const uint link = first ? links.x : links.y;
        if ((link & kEmitterLeaf) != 0u) return pmf;
        node = link & kEmitterIndex;
        trail >>= 1u;
    }
}

SHARED_END

#endif
