// The film's buffers. How a pixel lies in them is known to shared/film.h.
#include "shared/bindings.h"
#include "shared/film.h"

layout(set = kSetKernel, binding = kBindFilm0, scalar) buffer Film0Block
{
    vec4 film0[];
};

layout(set = kSetKernel, binding = kBindFilm1, scalar) buffer Film1Block
{
    vec4 film1[];
};

layout(set = kSetKernel, binding = kBindFilm2, scalar) buffer Film2Block
{
    vec4 film2[];
};

layout(set = kSetKernel, binding = kBindFilmWeight, scalar) buffer FilmWeightBlock
{
    vec2 filmWeights[];
};

FilmPixel loadFilm(uint i)
{
    return unpackFilm(FilmWords(film0[i], film1[i], film2[i], filmWeights[i]));
}

void storeFilm(uint i, FilmPixel pixel)
{
    const FilmWords words = packFilm(pixel);
    film0[i] = words.word0;
    film1[i] = words.word1;
    film2[i] = words.word2;
    filmWeights[i] = words.weight;
}
