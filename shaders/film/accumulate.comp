// Adds the samples of a batch to the film, in their order. Samples that are no colours are dropped and counted.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "colour.glsl"
#include "film.glsl"
#include "radiance.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform PushBlock
{
    Batch batch;
};

void main()
{
    const uint lane = gl_GlobalInvocationID.x;  // of the batch's first sample
    const uint lanesPerSample = batch.tileCount * kGroupSize;
    const uvec2 pixel = lanePixel(batch, lane);
    if (lane >= lanesPerSample || !insideImage(pixel)) return;
    const uint i = pixelIndex(pixel);
    FilmPixel p = loadFilm(i);
    for (uint s = 0u; s < batch.sampleCount; ++s) {
        const vec3 L = radiance[s * lanesPerSample + lane].xyz;
        if (isColour(L)) addSample(p, L);
    }
    addWeight(p, float(batch.sampleCount));
    storeFilm(i, p);
}
