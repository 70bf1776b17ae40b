// Sample streams: pure functions of (kind, seed, pixel, sample index, dimension, purpose); nothing
// else is state. Sobol: padded two-dimensional (0,2)-sequences with hash-based Owen scrambling and
// nested-uniform shuffled indices, each dimension and pixel on its own seeds: Burley, "Practical
// Hash-based Owen Scrambling", JCGT 9(4), 2020, with the better mixing Laine-Karras constants found
// by Vegdahl (2021). Independent: pcg4d.
#ifndef REKINDLE_SHARED_SAMPLER_H
#define REKINDLE_SHARED_SAMPLER_H

#include "lang.h"
#include "rng.h"

SHARED_BEGIN

SHARED_CONST uint kSamplerSobol = 0u;
SHARED_CONST uint kSamplerIndependent = 1u;

// Dimensions: a dimension is one padded two-dimensional pattern.
SHARED_CONST uint kDimensionPixel = 0u;
SHARED_CONST uint kDimensionLens = 1u;
SHARED_CONST uint kDimensionPath = 2u;  // first one of vertex 0
SHARED_CONST uint kDimensionsPerVertex = 4u;
SHARED_CONST uint kDimensionBsdf = 0u;  // offsets within a vertex
SHARED_CONST uint kDimensionLobe = 1u;  // x lobe, y roulette
SHARED_CONST uint kDimensionLight = 2u;
SHARED_CONST uint kDimensionLightChoice = 3u;

// What random numbers are for. Estimators that share a pixel and a sample index (old samples and
// new paths, say) must not share numbers: each purpose has streams of its own.
SHARED_CONST uint kPurposePath = 0u;       // paths from the camera
SHARED_CONST uint kPurposeLostLight = 1u;  // walks on from receivers, of light that is clamped away
SHARED_CONST uint kPurposeSelection = 2u;  // which candidate, neighbour or history is taken
SHARED_CONST uint kPurposeResampling = 3u;    // which stored samples survive
SHARED_CONST uint kPurposeLightTracing = 4u;  // paths from emitters, virtual lights
SHARED_CONST uint kPurposeOcclusion = 6u;     // ambient occlusion
SHARED_CONST uint kPurposeRounding = 7u;      // stochastic rounding of what is stored
SHARED_CONST uint kPurposeVisibility = 8u;    // which old samples are asked for visibility again
SHARED_CONST uint kPurposeRest = 9u;          // ways that mirrors and glass have not taken
SHARED_CONST uint kPurposeCount = 10u;

/// Where a sample's random numbers come from. `index` counts the samples of the pixel and may use
/// all 32 bits.
struct SampleStream {
    uint kind;
    uint seed;  // of one purpose: see makeStream
    uint pixel;
    uint index;
};

/// The stream of sample `index` of a pixel (coordinates below 65536) for one purpose, which is a
/// seed of its own: among seeds below 2^28 no two purposes meet. Paths keep the seed as it is
/// given.
SHARED_FN SampleStream makeStream(uint kind, uint seed, uvec2 pixel, uint index, uint purpose)
{
    SampleStream s;
    s.kind = kind;
    s.pixel = pixel.x | (pixel.y << 16u);
    s.seed = seed ^ (purpose * 0x9e3779b9u);
    s.index = index;
    return s;
}

/// A permutation in which each bit depends on the seed and the lower bits only; an Owen scramble of
/// bit-reversed numbers (Laine & Karras 2011; constants by Vegdahl).
SHARED_FN uint laineKarras(uint x, uint seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/// Product with Pascal's triangle modulo 2, the generator matrix of Sobol's second dimension
/// (before the bit reversal of the radical inverse). C(j,i) is odd where the bits of i are among
/// those of j, so bit i is the parity of the bits at all supersets of i: a zeta transform in five
/// steps, instead of one per index bit.
SHARED_FN uint pascalParity(uint x)
{
    x ^= (x >> 1u) & 0x55555555u;
    x ^= (x >> 2u) & 0x33333333u;
    x ^= (x >> 4u) & 0x0f0f0f0fu;
    x ^= (x >> 8u) & 0x00ff00ffu;
    x ^= x >> 16u;
    return x;
}

/// Two numbers in [0,1) of pattern `dimension`.
SHARED_FN vec2 streamVec2(SampleStream s, uint dimension)
{
    // One word must differ between the two kinds' uses of the hash: Sobol's seeds do not depend on
    // the index.
    bool sobol = s.kind == kSamplerSobol;
    uvec4 h = pcg4d(uvec4(s.pixel, dimension, s.seed, sobol ? 0x9e3779b9u : s.index));
    if (sobol) {
        // Shuffled index = reverse(laineKarras(reverse(index))). A scrambled coordinate is
        // reverse(laineKarras(reverse(x))); the radical inverse's own reversal cancels the inner
        // one.
        uint index = bitfieldReverse(laineKarras(bitfieldReverse(s.index), h.x));
        h.x = bitfieldReverse(laineKarras(index, h.y));
        h.y = bitfieldReverse(laineKarras(pascalParity(index), h.z));
    }
    return vec2(unitFloat(h.x), unitFloat(h.y));
}

/// One number in [0,1): the first coordinate of pattern `dimension`.
SHARED_FN float streamFloat(SampleStream s, uint dimension)
{
    return streamVec2(s, dimension).x;
}

SHARED_END

#endif
