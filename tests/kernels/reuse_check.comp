// The shared text of sample reuse on the device: one record of inputs and one of outputs per lane
// (reuse_check.h).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "reuse_check.h"
#include "shared/bindings.h"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform PushBlock
{
    ItemRange range;
};

layout(set = kSetKernel, binding = 0, scalar) readonly buffer InputBlock
{
    ReuseCheckInput inputs[];
};

layout(set = kSetKernel, binding = 1, scalar) writeonly buffer OutputBlock
{
    ReuseCheckOutput outputs[];
};

void main()
{
    const uint lane = gl_GlobalInvocationID.x;
    if (lane >= range.count) return;
    outputs[lane] = checkReuse(inputs[lane]);
}
