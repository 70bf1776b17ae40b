// The shared text of the film on the device: one record of inputs and one of outputs per lane (film_check.h).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "film_check.h"
#include "shared/bindings.h"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform PushBlock
{
    ItemRange range;
};

layout(set = kSetKernel, binding = 0, scalar) readonly buffer InputBlock
{
    FilmCheckInput inputs[];
};

layout(set = kSetKernel, binding = 1, scalar) writeonly buffer OutputBlock
{
    FilmCheckOutput outputs[];
};

void main()
{
    const uint lane = gl_GlobalInvocationID.x;
    if (lane >= range.count) return;
    outputs[lane] = checkFilm(inputs[lane]);
}
