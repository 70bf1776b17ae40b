// What a path remembers of the vertex that it left, in one word: the normal there, which the choice
// of an emitter asks for (emitter_tree.h), and how much of its throughput is refraction's scaling
// of radiance rather than absorption, which roulette leaves out. Coarse on purpose: both steer
// probabilities, and whoever uses them uses these.
#ifndef REKINDLE_SHARED_DEPARTURE_H
#define REKINDLE_SHARED_DEPARTURE_H

#include "lang.h"
#include "warp.h"

SHARED_BEGIN

// Normal: 2 x 12 bits, octahedral; one pattern says that light counts from all sides.
SHARED_CONST float kDepartureGrid = 4094.0f;
SHARED_CONST uint kAllSides = 0xffffffu;
// Scale of radiance: 8 bits, in sixteenths of an octave around one.
SHARED_CONST float kScaleSteps = 16.0f;
SHARED_CONST int kScaleOne = 128;

/// Where a path begins: no surface, radiance as it is.
SHARED_FN uint noDeparture()
{
    return kAllSides | (uint(kScaleOne) << 24u);
}

/// A unit normal in 24 bits; off by 1.1e-3 rad at most.
SHARED_FN uint packReceiver(vec3 normal)
{
    const vec2 p = octEncode(normal) * (0.5f * kDepartureGrid) + vec2(0.5f * kDepartureGrid + 0.5f);
    return uint(p.x) | (uint(p.y) << 12u);
}

/// Whether light from one side alone counts; `normal` then points there.
SHARED_FN bool unpackReceiver(uint departure, OUT(vec3) normal)
{
    normal = vec3(0.0f, 0.0f, 1.0f);
    if ((departure & kAllSides) == kAllSides) return false;
    const vec2 p = vec2(float(departure & 0xfffu), float((departure >> 12u) & 0xfffu));
    normal = octDecode(p * (2.0f / kDepartureGrid) - vec2(1.0f));
    return true;
}

/// The departure from another vertex, radiance scaled as before.
SHARED_FN uint departFrom(uint departure, uint receiver)
{
    return receiver | (departure & 0xff000000u);
}

/// After refraction into an index of `eta` times the one before, which scales radiance by 1/eta^2:
/// the way back cancels it exactly.
SHARED_FN uint refractDeparture(uint departure, float eta)
{
    const int steps = int(floor(2.0f * kScaleSteps * abs(log2(eta)) + 0.5f));
    const int scale = int(departure >> 24u) + (eta < 1.0f ? steps : -steps);
    return (departure & kAllSides) | (uint(clamp(scale, 0, 255)) << 24u);
}

/// By how much refraction has scaled the path's radiance.
SHARED_FN float radianceScale(uint departure)
{
    return exp2(float(int(departure >> 24u) - kScaleOne) * (1.0f / kScaleSteps));
}

SHARED_END

#endif
