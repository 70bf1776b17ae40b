// The film's mean radiance as three floats per pixel: a quarter of what the film itself is.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "film.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform PushBlock
{
    PixelRange range;
};

layout(set = kSetKernel, binding = kBindMean, scalar) writeonly buffer MeanBlock
{
    vec3 mean[];
};

void main()
{
    if (gl_GlobalInvocationID.x >= range.pixelCount) return;
    const uint i = range.firstPixel + gl_GlobalInvocationID.x;
    mean[i] = filmMean(film0[i], film1[i], filmWeights[i]);
}
