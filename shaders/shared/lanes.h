// Four numbers that are handled together: a vec4 to kernels, one register to the CPU. GLM's vec4 is
// four numbers to the compiler, which does not make vectors of them.
#ifndef REKINDLE_SHARED_LANES_H
#define REKINDLE_SHARED_LANES_H

#include "lang.h"

#ifdef __cplusplus
#define LANE(i) int(i)
#else
#define LANE(i) (i)
#endif

#ifdef __cplusplus

#include <bit>

namespace shared {

using Lanes = float __attribute__((vector_size(16)));
using IntLanes = int __attribute__((vector_size(16)));

inline Lanes lanesOf(float x)
{
    return Lanes{x, x, x, x};
}

inline Lanes lanesOf(float x, float y, float z, float w)
{
    return Lanes{x, y, z, w};
}

/// a < b ? yes : no, each for itself.
inline Lanes lanesIfLess(Lanes a, Lanes b, Lanes yes, Lanes no)
{
    return a < b ? yes : no;
}

inline Lanes lanesMin(Lanes a, Lanes b)
{
    return b < a ? b : a;
}

inline Lanes lanesMax(Lanes a, Lanes b)
{
    return a < b ? b : a;
}

/// A loop that becomes one instruction where roots need not set errno.
inline Lanes lanesSqrt(Lanes x)
{
    for (int i = 0; i < 4; ++i) x[i] = sqrt(x[i]);
    return x;
}

inline Lanes lanesAsFloat(uvec4 words)
{
    return std::bit_cast<Lanes>(words);
}

/// The lower and the upper halves of words as fractions in [-1, 1], as packSnorm2x16 has them but
/// for -1 - 1/32767.
inline Lanes lanesLowSnorm(uvec4 words)
{
    return __builtin_convertvector((std::bit_cast<IntLanes>(words) << 16) >> 16, Lanes) *
           (1.0f / 32767.0f);
}
inline Lanes lanesHighSnorm(uvec4 words)
{
    return __builtin_convertvector(std::bit_cast<IntLanes>(words) >> 16, Lanes) * (1.0f / 32767.0f);
}

}  // namespace shared

#else

#define Lanes vec4

Lanes lanesOf(float x)
{
    return vec4(x);
}

Lanes lanesOf(float x, float y, float z, float w)
{
    return vec4(x, y, z, w);
}

Lanes lanesIfLess(Lanes a, Lanes b, Lanes yes, Lanes no)
{
    return mix(no, yes, lessThan(a, b));
}

Lanes lanesMin(Lanes a, Lanes b)
{
    return min(a, b);
}

Lanes lanesMax(Lanes a, Lanes b)
{
    return max(a, b);
}

Lanes lanesSqrt(Lanes x)
{
    return sqrt(x);
}

Lanes lanesAsFloat(uvec4 words)
{
    return uintBitsToFloat(words);
}

Lanes lanesLowSnorm(uvec4 words)
{
    return vec4(ivec4(words << 16u) >> 16) * (1.0f / 32767.0f);
}

Lanes lanesHighSnorm(uvec4 words)
{
    return vec4(ivec4(words) >> 16) * (1.0f / 32767.0f);
}

#endif

#endif
