// What a path knows where it scatters, and the random numbers it may use there: what methods that
// choose directions in their own way are given (see directions.h).
#ifndef REKINDLE_SHARED_VERTEX_H
#define REKINDLE_SHARED_VERTEX_H

#include "sampler.h"
#include "surface.h"

SHARED_BEGIN

/// A point where a path may scatter. `wo` points to where the path came from, in the surface's
/// frame; `lobes` are those of the BSDF there.
struct Vertex {
    SurfacePoint surface;
    Bsdf bsdf;
    vec3 wo;
    LobeChoice lobes;
    uint skyRegion;  // sky_regions.h; 0: none
};

/// The random numbers of a path's vertex. Drawn before the vertex is shaded, so that a CPU can draw
/// those of many paths together.
struct VertexNumbers {
    vec2 bsdf;
    vec2 lobe;  // x which lobe, y roulette
    vec2 light;
    float choice;  // of the emitter
};

SHARED_FN VertexNumbers drawVertexNumbers(SampleStream stream, uint depth)
{
    const uint dimension = kDimensionPath + depth * kDimensionsPerVertex;
    VertexNumbers n;
    n.bsdf = streamVec2(stream, dimension + kDimensionBsdf);
    n.lobe = streamVec2(stream, dimension + kDimensionLobe);
    n.light = streamVec2(stream, dimension + kDimensionLight);
    n.choice = FEATURE(kFeatureManyEmitters)
                   ? streamFloat(stream, dimension + kDimensionLightChoice)
                   : 0.0f;
    return n;
}

SHARED_END

#endif
