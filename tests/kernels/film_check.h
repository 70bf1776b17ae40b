// Every function of shared/film.h on one record of inputs: compiled for the device and for the
// host, whose answers must agree.
#ifndef REKINDLE_TESTS_FILM_CHECK_H
#define REKINDLE_TESTS_FILM_CHECK_H

#include "shared/film.h"

SHARED_BEGIN

SHARED_CONST uint kFilmCheckSamples = 32u;

/// Samples may be anything; `before` is a film of finite numbers.
struct FilmCheckInput {
    FilmWords before;
    vec3 samples[kFilmCheckSamples];
};

struct FilmCheckOutput {
    FilmWords after;
    vec3 mean;
    uint kinds[4];  // how many samples are of each kind
    FilmWords packedAgain;
};

SHARED_FN FilmCheckOutput checkFilm(IN(FilmCheckInput) a)
{
    FilmCheckOutput r;
    for (uint k = 0u; k < 4u; ++k) r.kinds[k] = 0u;
    FilmPixel p = unpackFilm(a.before);
    r.packedAgain = packFilm(p);
    for (uint s = 0u; s < kFilmCheckSamples; ++s) {
        const uint kind = kindOfSample(a.samples[s]);
        r.kinds[kind] += 1u;
        if (kind == kSampleColour) addSample(p, a.samples[s]);
    }
    addWeight(p, float(kFilmCheckSamples));
    r.after = packFilm(p);
    r.mean = filmMean(r.after.word0, r.after.word1, r.after.weight);
    return r;
}

SHARED_END

#endif
