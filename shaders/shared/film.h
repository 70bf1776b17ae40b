// A pixel of the film: sums over its samples, and over their squares, each with its compensation
// (Kahan, "Further remarks on reducing truncation errors", 1965), and the weight that the sums are
// to be divided by. The one place that knows how they are packed: three words of 16 bytes and one
// of 8, each in a buffer of its own, as a storage buffer of some devices ends at 128 MiB and 4K
// images have to fit.
#ifndef REKINDLE_SHARED_FILM_H
#define REKINDLE_SHARED_FILM_H

#include "lang.h"

SHARED_BEGIN

/// The weight is the number of samples that were taken: `weight` less `weightLost`, since a float
/// alone stays at 2^24 while the sums go on. Samples that were dropped count: they are taken for
/// black, not for absent.
struct FilmPixel {
    vec3 sum;
    vec3 sumLost;  // what the sum is too large by, for having been rounded
    vec3 squares;
    vec3 squaresLost;
    float weight;
    float weightLost;
};

/// A pixel as it lies in memory.
struct FilmWords {
    vec4 word0;
    vec4 word1;
    vec4 word2;
    vec2 weight;
};

SHARED_FN FilmWords packFilm(FilmPixel p)
{
    FilmWords w;
    w.word0 = vec4(p.sum, p.sumLost.x);
    w.word1 = vec4(p.sumLost.y, p.sumLost.z, p.squares.x, p.squares.y);
    w.word2 = vec4(p.squares.z, p.squaresLost.x, p.squaresLost.y, p.squaresLost.z);
    w.weight = vec2(p.weight, p.weightLost);
    return w;
}

SHARED_FN FilmPixel unpackFilm(FilmWords w)
{
    FilmPixel p;
    p.sum = xyz(w.word0);
    p.sumLost = vec3(w.word0.w, w.word1.x, w.word1.y);
    p.squares = vec3(w.word1.z, w.word1.w, w.word2.x);
    p.squaresLost = vec3(w.word2.y, w.word2.z, w.word2.w);
    p.weight = w.weight.x;
    p.weightLost = w.weight.y;
    return p;
}

// What a sample is: anything but a colour is dropped, and counted by its kind.
SHARED_CONST uint kSampleColour = 0u;
SHARED_CONST uint kSampleNan = 1u;
SHARED_CONST uint kSampleInfinite = 2u;
SHARED_CONST uint kSampleNegative = 3u;

/// Which of them L is; the first that holds for any channel.
SHARED_FN uint kindOfSample(vec3 L)
{
    if (any(isnan(L))) return kSampleNan;
    if (any(isinf(L))) return kSampleInfinite;
    return any(lessThan(L, vec3(0.0f))) ? kSampleNegative : kSampleColour;
}

/// sum += x, with what the rounding takes away kept in `lost`. PRECISE keeps compilers from undoing
/// it.
SHARED_FN void addCompensated(INOUT(vec3) sum, INOUT(vec3) lost, vec3 x)
{
    PRECISE vec3 y = x - lost;
    PRECISE vec3 t = sum + y;
    PRECISE vec3 rounded = (t - sum) - y;
    lost = rounded;
    sum = t;
}

/// Counts `x` more samples, in the same way.
SHARED_FN void addWeight(INOUT(FilmPixel) p, float x)
{
    PRECISE float y = x - p.weightLost;
    PRECISE float t = p.weight + y;
    PRECISE float rounded = (t - p.weight) - y;
    p.weightLost = rounded;
    p.weight = t;
}

/// Adds one sample, which is a colour, to the sums. The weight is the caller's.
SHARED_FN void addSample(INOUT(FilmPixel) p, vec3 L)
{
    addCompensated(p.sum, p.sumLost, L);
    addCompensated(p.squares, p.squaresLost, L * L);
}

/// Mean radiance from the words that hold it; black where nothing has been added.
SHARED_FN vec3 filmMean(vec4 word0, vec4 word1, vec2 weight)
{
    const vec3 sum = xyz(word0) - vec3(word0.w, word1.x, word1.y);
    return weight.x > 0.0f ? sum / (weight.x - weight.y) : vec3(0.0f);
}

SHARED_END

#endif
