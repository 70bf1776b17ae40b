// Multiple importance sampling: the power heuristic with exponent 2 (Veach 1997, 9.2.4) by ratios,
// because squares of densities overflow at small lamps and narrow lobes.
#ifndef REKINDLE_SHARED_MIS_H
#define REKINDLE_SHARED_MIS_H

#include "lang.h"

SHARED_BEGIN

/// Weight of a sample drawn with density `a` that another technique would have drawn with density
/// `b`. 0 when `a` is not positive; 1 when `b` is not.
SHARED_FN float powerHeuristic(float a, float b)
{
    if (!(a > 0.0f)) {
        return 0.0f;
    }
    if (!(b > 0.0f)) {
        return 1.0f;
    }
    float ratio = a > b ? b / a : a / b;  // at most one; an infinite density wins
    float square = ratio * ratio;
    return (a > b ? 1.0f : square) / (1.0f + square);
}

SHARED_END

#endif
