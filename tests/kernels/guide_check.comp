// The shared text of guides on the device: one record of inputs and one of outputs per lane (guide_check.h).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "guide_check.h"
#include "shared/bindings.h"

layout(local_size_x = 64) in;

layout(constant_id = kSpecializeGuided) const uint kGuided = 1u;

layout(push_constant, scalar) uniform PushBlock
{
    ItemRange range;
};

layout(set = kSetKernel, binding = 0, scalar) readonly buffer InputBlock
{
    GuideCheckInput inputs[];
};

layout(set = kSetKernel, binding = 1, scalar) writeonly buffer OutputBlock
{
    GuideCheckOutput outputs[];
};

layout(set = kSetKernel, binding = 2) uniform usamplerBuffer guideNodes;
layout(set = kSetKernel, binding = 3) uniform usamplerBuffer guideLeaves;
layout(set = kSetKernel, binding = 4) uniform samplerBuffer guideDirections;

uvec4 fetchGuideNode(GuideView view, uint i)
{
    return texelFetch(guideNodes, int(i));
}

uvec4 fetchGuideLeaf(GuideView view, uint leaf)
{
    return texelFetch(guideLeaves, int(leaf));
}

vec4 fetchGuideDirections(GuideView view, uint i)
{
    return texelFetch(guideDirections, int(i));
}

void main()
{
    const uint lane = gl_GlobalInvocationID.x;
    if (lane >= range.count) return;
    outputs[lane] = checkGuide(GuideView(kGuided), inputs[lane]);
}
