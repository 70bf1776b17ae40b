// How many of the new paths a pixel gets: more where single paths differ much from each other. The
// standard deviation is learnt from the new paths of the frames before and found by backprojection,
// the mean over the pixels around. That it knows the pixel's own samples is no harm: how many paths
// a pixel takes changes what each of them counts, and never what old samples answer for
// (partOfPath).
#ifndef REKINDLE_SHARED_REUSE_ALLOCATION_H
#define REKINDLE_SHARED_REUSE_ALLOCATION_H

#include "reuse_sums.h"

SHARED_BEGIN

// Of a pixel's paths over those of all pixels on average.
SHARED_CONST float kReuseMostPart = 8.0f;

/// Whether pixels get different numbers of new paths in this pass.
SHARED_FN bool allocatesPaths(ReuseSettings settings)
{
    return (settings.flags & (kReuseAllocates | kReuseFollows)) == kReuseAllocates;
}

/// The paths that a pixel gets over those that are due on average. `perDeviation` is such that the
/// mean over the picture is one (0: not known yet). Every pixel gets one path, and shares of the
/// others: in proportion to the deviation alone, quiet pixels would get next to nothing by a
/// deviation that is known from few paths.
SHARED_FN float allocatedPart(ReuseSettings settings, float perDeviation, float deviation)
{
    if (!allocatesPaths(settings) || !(perDeviation > 0.0f) || !(deviation >= 0.0f)) return 1.0f;
    return min(1.0f / settings.rays + perDeviation * deviation, kReuseMostPart);
}

// Deviations are counted in bins of half an octave; the first has those next to nothing.
SHARED_CONST uint kDeviationBins = 64u;

SHARED_FN uint deviationBin(float deviation)
{
    if (!(deviation > 1.0e-5f)) return 0u;
    return uint(clamp(floor(2.0f * log2(deviation)) + 32.0f, 1.0f, 63.0f));
}

SHARED_FN float deviationOfBin(uint bin)
{
    return bin == 0u ? 0.0f : exp2(0.5f * (float(bin) - 31.5f));
}

SHARED_END

#endif
