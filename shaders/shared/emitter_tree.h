// The choice of one emitter for a point by what it may bring there: a tree over triangles, point
// and spot lights, descended by the ratio of its children's importance (A. Conty Estevez, C. Kulla,
// "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018; without the splitting).
// Nodes are spheres and have four children, whose importance the CPU finds in one go: a descent of
// half as many steps. Importance is zero only where nothing can arrive, so that no light is lost.
#ifndef REKINDLE_SHARED_EMITTER_TREE_H
#define REKINDLE_SHARED_EMITTER_TREE_H

#include "departure.h"
#include "lanes.h"
#include "layout.h"
#include "rng.h"
#include "scene.h"

SHARED_BEGIN

// The words of the tree: for every emitter the ways that lead to it, four emitters to a word, two
// bits for each step, the first the lowest; then the nodes, the root first. A node's words are
// properties of its four children:
//   x, y, z of the centre, radius of a sphere around the emitters; of a cone that holds all normals
//   the axis in three fractions of 16 bits, and cosine and sine of its half angle, the sine
//   negative where emission is to both sides of the axis; the cosine of the angle to a normal
//   beyond which nothing is emitted; intensity, which is 0 where there is no child; link.
SHARED_CONST uint kEmitterLeaf = 0x80000000u;  // of a link: to an emitter, not to a node's words
SHARED_CONST uint kEmitterIndex = 0x7fffffffu;
SHARED_CONST uint kEmitterNodeWords = 9u;

/// Where the root is.
SHARED_FN uint emitterTreeRoot(uint treeEmitters)
{
    return (treeEmitters + 3u) / 4u;
}

// The normal is known to 1e-3 rad, and the sphere to rounding.
SHARED_CONST float kHorizonSlack = 2.0e-3f;
// Cosines of 16 bits, and what they make.
SHARED_CONST float kReachSlack = 2.0e-4f;

/// What the cosine of an angle may be taken for whose cosine at the centre is `c`, when the angle
/// may be smaller by one whose sine is `spread`: the mean of c and of a bound.
SHARED_FN Lanes meanCosine(Lanes c, Lanes spread)
{
    return 0.5f * (lanesMax(c, lanesOf(0.0f)) +
                   lanesMax(lanesMin(c + spread, lanesOf(1.0f)), lanesOf(kHorizonSlack)));
}

// Random numbers are multiples of kUnitGrain; a branch is taken by no coarser ones.
SHARED_CONST float kUnitGrain = 5.9604644775390625e-8f;  // 2^-24
SHARED_CONST float kCoarseGrain = 3.814697265625e-6f;    // 2^-18

/// What the emitters of each child of the node at `word` are thought to bring to p, on the side of
/// `normal` if `oneSided`; 0 only where they can bring nothing. Bounds alone would make much of
/// what is near, whatever its turn: the cosines are means of the bound and of the centre's, and
/// distances shrink to a part of the radius. Measured among 60,000 lamps (sponza-lanterns): bounds
/// and the whole radius have 4.5 times the variance.
SHARED_FN Lanes emitterImportance(IN(SceneView) scene, uint word, vec3 p, bool oneSided,
                                  vec3 normal)
{
    const Lanes x = lanesAsFloat(fetchEmitterTree(scene, word)) - p.x;
    const Lanes y = lanesAsFloat(fetchEmitterTree(scene, word + 1u)) - p.y;
    const Lanes z = lanesAsFloat(fetchEmitterTree(scene, word + 2u)) - p.z;
    const Lanes radius = lanesAsFloat(fetchEmitterTree(scene, word + 3u));
    const uvec4 axisXy = fetchEmitterTree(scene, word + 4u);
    const uvec4 axisZCos = fetchEmitterTree(scene, word + 5u);
    const uvec4 sinEmission = fetchEmitterTree(scene, word + 6u);
    const Lanes intensity = lanesAsFloat(fetchEmitterTree(scene, word + 7u));

    const Lanes radius2 = radius * radius;
    const Lanes square = x * x + y * y + z * z;
    const Lanes inverse2 = 1.0f / lanesMax(lanesMax(square, 0.15f * radius2), lanesOf(1.0e-30f));
    const Lanes inverse = lanesSqrt(inverse2);
    const Lanes strength = intensity * inverse2;
    // The sphere as p sees it, from outside.
    const Lanes sinB = lanesMin(radius * inverse, lanesOf(1.0f));
    const Lanes cosB = lanesSqrt(lanesMax(1.0f - radius2 * inverse2, lanesOf(0.0f)));

    // The cone of the normals, wider by the sphere: half its angle is D.
    const Lanes cosO = lanesHighSnorm(axisZCos);
    const Lanes signedSinO = lanesLowSnorm(sinEmission);
    const Lanes sinO = lanesMax(signedSinO, -signedSinO);
    const Lanes cosD = cosO * cosB - sinO * sinB;
    const Lanes sinD = sinO * cosB + cosO * sinB;
    // What lies farther from the axis than D and E together gets nothing.
    const Lanes cosE = lanesHighSnorm(sinEmission);
    const Lanes sinE = lanesSqrt(lanesMax(1.0f - cosE * cosE, lanesOf(0.0f)));
    const Lanes cosReach = cosD * cosE - sinD * sinE;
    const Lanes sinReach = lanesMin(sinD, sinD * cosE + cosD * sinE);
    Lanes c =
        -(lanesLowSnorm(axisXy) * x + lanesHighSnorm(axisXy) * y + lanesLowSnorm(axisZCos) * z) *
        inverse;
    c = lanesIfLess(signedSinO, lanesOf(0.0f), lanesMax(c, -c), c);
    // Bounds without roots, which take long: c + sin D is 0 where cos(acos c - D) is, and near it
    // between; beyond a right angle a line from the cone's edge to its far side.
    Lanes spread = lanesIfLess(lanesOf(0.0f), cosD, sinD, 1.0f - cosD);
    spread = lanesIfLess(sinD, lanesOf(0.0f), lanesOf(2.0f), spread);
    Lanes seen = meanCosine(c, spread);
    seen = lanesIfLess(cosReach - kReachSlack, c, seen,
                       lanesIfLess(sinReach, lanesOf(0.0f), seen, lanesOf(0.0f)));
    if (oneSided) {
        const Lanes facing = (normal.x * x + normal.y * y + normal.z * z) * inverse;
        const Lanes beyond = sinB + kHorizonSlack;
        seen *= lanesIfLess(-beyond, facing, meanCosine(facing, beyond), lanesOf(0.0f));
    }
    return lanesIfLess(radius2, square, strength * seen, strength);
}

/// Chooses one of four by their weights and stretches u to what is left of it; `chance` 0 where no
/// weight is positive. Without branches, which nobody could foresee.
SHARED_FN uint chooseLane(Lanes weights, INOUT(float) u, OUT(float) chance)
{
    const float b = weights[0];
    const float c = b + weights[1];
    const float d = c + weights[2];
    const float total = d + weights[3];
    const float x = u * total;
    uint lane = uint(x >= b) + uint(x >= c) + uint(x >= d);
    // Rounding may lead past the last that has a weight.
    while (lane > 0u && !(weights[LANE(lane)] > 0.0f)) lane -= 1u;
    const Lanes starts = lanesOf(0.0f, b, c, d);
    const float weight = weights[LANE(lane)];
    u = min((x - starts[LANE(lane)]) / weight, kOneMinusEpsilon);
    chance = total > 0.0f ? weight / total : 0.0f;
    return lane;
}

/// A choice among emitters under way. Step by step, so that a processor can follow several at once:
/// each waits for memory at every node.
struct EmitterChoice {
    uint word;     // the node where it is; kNone: the choice is made
    uint emitter;  // that was chosen
    float pmf;     // of the way so far; 0 where none can bring anything
    float u;       // the random number that is left,
    float grain;   // a multiple of this: of more than kUnitGrain where it has been stretched
    uint fresh;    // bits for where it has become coarse
};

/// A choice that is made.
SHARED_FN EmitterChoice emitterChosen(uint emitter, float pmf)
{
    EmitterChoice c;
    c.word = kNone;
    c.emitter = emitter;
    c.pmf = pmf;
    c.u = 0.0f;
    c.grain = kUnitGrain;
    c.fresh = 0u;
    return c;
}

/// A choice that begins at the root of the tree, which is reached with probability `pmf`.
SHARED_FN EmitterChoice beginInTree(uint treeEmitters, float u, float grain, float pmf)
{
    EmitterChoice c = emitterChosen(0u, pmf);
    c.word = emitterTreeRoot(treeEmitters);
    c.u = u;
    c.grain = grain;
    c.fresh = floatBitsToUint(u);
    return c;
}

/// One step down, by what emitters may bring to p on the side of `normal` if `oneSided`.
SHARED_FN void stepInTree(IN(SceneView) scene, vec3 p, bool oneSided, vec3 normal,
                          INOUT(EmitterChoice) c)
{
    float chance;
    const Lanes weights = emitterImportance(scene, c.word, p, oneSided, normal);
    const uint lane = chooseLane(weights, c.u, chance);
    c.pmf *= chance;
    const uint link =
        chance > 0.0f ? fetchEmitterTree(scene, c.word + 8u)[LANE(lane)] : kEmitterLeaf;
    if ((link & kEmitterLeaf) != 0u) {
        c.emitter = link & kEmitterIndex;
        c.word = kNone;
        prefetchEmitter(scene, c.emitter);
        return;
    }
    c.word = link;
    prefetchEmitterNode(scene, link);
    // Stretched over and over, u runs out of bits: new ones fill the gaps.
    c.grain /= chance;
    if (c.grain > kCoarseGrain) {
        c.fresh = hashUint(c.fresh + c.word);
        c.u = min(c.u + c.grain * unitFloat(c.fresh), kOneMinusEpsilon);
        c.grain = kUnitGrain;
    }
}

/// What the choice ends at for a point p and a `departure` from it.
SHARED_FN EmitterChoice finishChoice(IN(SceneView) scene, vec3 p, uint departure,
                                     EmitterChoice begun)
{
    EmitterChoice c = begun;
    if (!FEATURE(kFeatureEmitterTree)) return c;
    vec3 normal;
    const bool oneSided = unpackReceiver(departure, normal);
    while (c.word != kNone) stepInTree(scene, p, oneSided, normal, c);
    return c;
}

/// Probability with which a choice that begins at the root ends at `emitter`.
SHARED_FN float pmfInTree(IN(SceneView) scene, uint treeEmitters, uint emitter, vec3 p,
                          uint departure)
{
    vec3 normal;
    const bool oneSided = unpackReceiver(departure, normal);
    uint trail = fetchEmitterTree(scene, emitter / 4u)[LANE(emitter % 4u)];
    uint word = emitterTreeRoot(treeEmitters);
    float pmf = 1.0f;
    while (true) {
        const Lanes weights = emitterImportance(scene, word, p, oneSided, normal);
        const float total = ((weights[0] + weights[1]) + weights[2]) + weights[3];
        const uint lane = trail & 3u;
        if (!(weights[lane] > 0.0f)) return 0.0f;
        pmf *= weights[lane] / total;
        const uint link = fetchEmitterTree(scene, word + 8u)[LANE(lane)];
        if ((link & kEmitterLeaf) != 0u) return pmf;
        word = link;
        trail >>= 2u;
    }
}

SHARED_END

#endif
