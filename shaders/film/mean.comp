// The film's mean radiance as three floats per pixel: a quarter of what the film itself is. `batch.sampleCount` is the
// number of samples in it, and of tiles below `firstSample` `bounce` more; `firstTile` and `tileCount` count groups of 64
// pixels. The film's words: see accumulate.comp.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/bindings.h"

layout(local_size_x = 64) in;

layout(set = 0, binding = kBindFrame, scalar) uniform FrameBlock { FrameData frame; };
layout(push_constant, scalar) uniform BatchBlock { Batch batch; };
layout(set = 0, binding = kBindFilm0, scalar) readonly buffer Film0Block { vec4 film0[]; };
layout(set = 0, binding = kBindFilm1, scalar) readonly buffer Film1Block { vec4 film1[]; };
layout(set = 0, binding = kBindOutput, scalar) writeonly buffer OutputBlock { vec3 mean[]; };

void main()
{
    const uint i = batch.firstTile * kGroupSize + gl_GlobalInvocationID.x;
    if (gl_GlobalInvocationID.x >= batch.tileCount * kGroupSize ||
        i >= frame.settings.imageWidth * frame.settings.imageHeight) return;
    const uvec2 tile = uvec2(i % frame.settings.imageWidth, i / frame.settings.imageWidth) / 8u;
    const bool ahead = tile.y * frame.tilesPerRow + tile.x < batch.firstSample;
    const uint n = batch.sampleCount + (ahead ? batch.bounce : 0u);
    const vec4 a = film0[i];
    mean[i] = n > 0u ? (a.xyz - vec3(a.w, film1[i].xy)) / float(n) : vec3(0.0);
}
