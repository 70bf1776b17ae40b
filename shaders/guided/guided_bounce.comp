// Bounces of guided paths. What they carry beside their state stays where their lane is.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_basic : require

#include "guided.glsl"

layout(set = kSetKernel, binding = kBindGuidedStates, scalar) buffer GuidedStateBlock
{
    GuidedState guidedStates[];
};

PathExtra loadExtra(uint lane)
{
    return guidedStates[lane];
}

void storeExtra(uint lane, PathExtra extra)
{
    guidedStates[lane] = extra;
}

#include "bounce.glsl"
