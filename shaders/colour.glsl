// What is no colour never reaches the film, and is counted.
#include "frame.glsl"
#include "shared/film.h"

/// Whether L is to be added; else it is counted.
bool isColour(vec3 L)
{
    const uint kind = kindOfSample(L);
    if (kind == kSampleNan) atomicAdd(counters.nan, 1u);
    if (kind == kSampleInfinite) atomicAdd(counters.inf, 1u);
    if (kind == kSampleNegative) atomicAdd(counters.negative, 1u);
    return kind == kSampleColour;
}
