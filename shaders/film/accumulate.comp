// Adds the samples of a batch to the film, in their order, by compensated summation (Kahan 1965; `precise` keeps the
// compiler from undoing it). Samples that are not finite or negative are dropped and counted.
// Film words per pixel: (sum.rgb, c.r), (c.gb, square.rg), (square.b, cs.rgb); c and cs are the compensations.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/bindings.h"

layout(local_size_x = 64) in;

layout(set = 0, binding = kBindFrame, scalar) uniform FrameBlock { FrameData frame; };
layout(push_constant, scalar) uniform BatchBlock { Batch batch; };
layout(set = 0, binding = kBindRadiance, scalar) readonly buffer RadianceBlock { vec4 radiance[]; };
layout(set = 0, binding = kBindFilm0, scalar) buffer Film0Block { vec4 film0[]; };
layout(set = 0, binding = kBindFilm1, scalar) buffer Film1Block { vec4 film1[]; };
layout(set = 0, binding = kBindFilm2, scalar) buffer Film2Block { vec4 film2[]; };
layout(set = 0, binding = kBindCounters, scalar) buffer CounterBlock { Counters counters; };

void kahanAdd(inout vec3 sum, inout vec3 compensation, vec3 x)
{
    precise vec3 y = x - compensation;
    precise vec3 t = sum + y;
    precise vec3 lost = (t - sum) - y;
    compensation = lost;
    sum = t;
}

void main()
{
    const uint local = gl_GlobalInvocationID.x;
    const uint pixelsPerSample = batch.tileCount * kGroupSize;
    const uint tile = batch.firstTile + local / kGroupSize;
    const uint morton = local % kGroupSize;
    uvec2 pixel = 8u * uvec2(tile % frame.tilesPerRow, tile / frame.tilesPerRow);
    for (uint bit = 0u; bit < 3u; ++bit) {
        pixel.x |= ((morton >> (2u * bit)) & 1u) << bit;
        pixel.y |= ((morton >> (2u * bit + 1u)) & 1u) << bit;
    }
    if (local >= pixelsPerSample || pixel.x >= frame.settings.imageWidth ||
        pixel.y >= frame.settings.imageHeight) {
        return;
    }
    const uint i = pixel.y * frame.settings.imageWidth + pixel.x;
    const vec4 a = film0[i];
    const vec4 b = film1[i];
    const vec4 c = film2[i];
    vec3 sum = a.xyz;
    vec3 sumCompensation = vec3(a.w, b.xy);
    vec3 squares = vec3(b.zw, c.x);
    vec3 squaresCompensation = c.yzw;
    for (uint s = 0u; s < batch.sampleCount; ++s) {
        const vec3 L = radiance[s * pixelsPerSample + local].xyz;
        const bool isNan = any(isnan(L));
        const bool isInf = !isNan && any(isinf(L));
        const bool isNegative = !isNan && any(lessThan(L, vec3(0.0)));
        if (isNan) atomicAdd(counters.nan, 1u);
        if (isInf) atomicAdd(counters.inf, 1u);
        if (isNegative) atomicAdd(counters.negative, 1u);
        if (isNan || isInf || isNegative) continue;
        kahanAdd(sum, sumCompensation, L);
        kahanAdd(squares, squaresCompensation, L * L);
    }
    film0[i] = vec4(sum, sumCompensation.x);
    film1[i] = vec4(sumCompensation.yz, squares.xy);
    film2[i] = vec4(squares.z, squaresCompensation);
}
