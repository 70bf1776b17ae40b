// Counter-based hashing: random numbers as pure functions of integers, so that tiles, devices and
// pauses do not change an image. pcg4d: Jarzynski & Olano, "Hash Functions for GPU Rendering", JCGT
// 9(3), 2020.
#ifndef REKINDLE_SHARED_RNG_H
#define REKINDLE_SHARED_RNG_H

#include "lang.h"

SHARED_BEGIN

/// One well mixed word from one word (the output permutation of PCG-RXS-M-XS over one LCG step).
SHARED_FN uint hashUint(uint x)
{
    uint state = x * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

/// Four well mixed words from four words.
SHARED_FN uvec4 pcg4d(uvec4 v)
{
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v = v ^ (v >> 16u);
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

/// The upper 24 bits as a float in [0, 1): every value is exact, and one is never reached.
SHARED_FN float unitFloat(uint x)
{
    return float(x >> 8u) * 5.9604644775390625e-8f;
}

SHARED_END

#endif
