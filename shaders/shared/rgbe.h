// A colour in 32 bits: three mantissas of 8 bits and the exponent of the largest channel, after G.
// Ward, "Real Pixels" (Graphics Gems II, 1991). What differs: the exponent is that of fp32 (bias
// 127), so that every normal number has a place; it is chosen such that rounding up never carries;
// and rounding can be stochastic, so that the mean of many stored colours is that of the colours,
// channel by channel, also where one is a thousandth of another.
#ifndef REKINDLE_SHARED_RGBE_H
#define REKINDLE_SHARED_RGBE_H

#include "lang.h"

SHARED_BEGIN

SHARED_CONST float kRgbeMax = 1.7014118346e38f;     // 2^127: brighter channels are stored as this
SHARED_CONST float kRgbeLeast = 1.1754943508e-38f;  // 2^-126: colours darker than this are black

/// 2^k for k in [-126, 127].
SHARED_FN float powerOfTwo(int k)
{
    return uintAsFloat(uint(k + 127) << 23u);
}

/// x 2^k where 2^k alone may be out of range: k in [-252, 254].
SHARED_FN float scaleByPower(float x, int k)
{
    int first = k / 2;
    return x * powerOfTwo(first) * powerOfTwo(k - first);
}

/// What a channel is stored as before rounding: NaN and negative numbers are 0, infinity saturates.
SHARED_FN float rgbeChannel(float x)
{
    return x > 0.0f ? (x < kRgbeMax ? x : kRgbeMax) : 0.0f;
}

/// floor(y), or one more with the probability of the fraction; y in [0, 255], xi uniform in [0, 1).
SHARED_FN uint rgbeMantissa(float y, float xi)
{
    float whole = floor(y);
    return uint(whole) + (xi < y - whole ? 1u : 0u);
}

/// The word of a colour of channels >= 0: mantissas in bits 0-7, 8-15, 16-23, exponent above; 0 is
/// black. With xi uniform in [0, 1)^3 every channel is right on average; the error of a channel is
/// less than 1/127.5 of the largest channel.
SHARED_FN uint packRgbe(vec3 colour, vec3 xi)
{
    float r = rgbeChannel(colour.x);
    float g = rgbeChannel(colour.y);
    float b = rgbeChannel(colour.z);
    float largest = max(r, max(g, b));
    if (!(largest >= kRgbeLeast)) {
        return 0u;
    }
    int exponent = int(floatAsUint(largest) >> 23u);
    // In units of the step the largest is in [128, 256). Above 255 it might be rounded up to 256.
    if (scaleByPower(largest, 134 - exponent) > 255.0f) {
        ++exponent;
    }
    int k = 134 - exponent;
    return rgbeMantissa(scaleByPower(r, k), xi.x) | (rgbeMantissa(scaleByPower(g, k), xi.y) << 8u) |
           (rgbeMantissa(scaleByPower(b, k), xi.z) << 16u) | (uint(exponent) << 24u);
}

/// Rounds to nearest: the error of a channel is at most 1/255 of the largest channel, and always
/// the same for the same colour. For pictures, not for what is summed up later.
SHARED_FN uint packRgbeNearest(vec3 colour)
{
    return packRgbe(colour, vec3(0.5f));
}

/// The colour of a word. Channels below kRgbeLeast may read as 0 where the device has no denormals.
SHARED_FN vec3 unpackRgbe(uint word)
{
    int k = int(word >> 24u) - 134;
    return vec3(scaleByPower(float(word & 255u), k), scaleByPower(float((word >> 8u) & 255u), k),
                scaleByPower(float((word >> 16u) & 255u), k));
}

SHARED_END

#endif
