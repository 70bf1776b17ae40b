// One lane, one receiver of a slice: the sum of what the virtual lights send to it that it sees (shared/virtual_light.h).
// A workgroup has receivers of one slice, so that lights are read together.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require

#include "scene.glsl"
#include "shared/extended_light.h"

layout(local_size_x = 64) in;

layout(constant_id = kSpecializeNumbers) const uint kNumbers = 0u;  // 1: values are numbers, 0: bits

layout(constant_id = kSpecializeShape) const uint kShape = kLightShapePoint;

layout(push_constant, scalar) uniform PushBlock
{
    GatherRules push;
};

layout(set = kSetKernel, binding = kBindGathered, scalar) writeonly buffer GatheredBlock
{
    vec4 gathered[];
};
layout(set = kSetKernel, binding = kBindSliceGroups) uniform usamplerBuffer groups;
layout(set = kSetKernel, binding = kBindReceivers) uniform usamplerBuffer receivers;
layout(set = kSetKernel, binding = kBindVirtualLights) uniform usamplerBuffer lights;
layout(set = kSetKernel, binding = kBindLightDetails) uniform usamplerBuffer lightDetails;
layout(set = kSetKernel, binding = kBindSliceValues) uniform usamplerBuffer values;  // R32UI

vec4 fetchLightDetail(LightDetails details, uint word)
{
    return uintBitsToFloat(texelFetch(lightDetails, int(details.first + word)));
}

SliceGroup fetchGroup(uint i)
{
    const uvec4 a = texelFetch(groups, int(kSliceGroupWords * i));
    const uvec4 b = texelFetch(groups, int(kSliceGroupWords * i + 1u));
    return SliceGroup(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w);
}

ReceiverRecord fetchReceiver(uint i)
{
    const uvec4 a = texelFetch(receivers, int(kReceiverRecordWords * i));
    const uvec4 b = texelFetch(receivers, int(kReceiverRecordWords * i + 1u));
    const uint medium =
        FEATURE(kFeatureVolume) ? texelFetch(receivers, int(kReceiverRecordWords * i + 2u)).x : kNone;
    return ReceiverRecord(uintBitsToFloat(a.xyz), a.w, uintBitsToFloat(b.xy), b.z, b.w, medium, 0u, 0u, 0u);
}

LightRecord fetchLight(uint i)
{
    const uvec4 a = texelFetch(lights, int(kLightRecordWords * i));
    const uvec4 b = texelFetch(lights, int(kLightRecordWords * i + 1u));
    const uvec4 c = texelFetch(lights, int(kLightRecordWords * i + 2u));
    return LightRecord(uintBitsToFloat(a.xyz), a.w, uintBitsToFloat(b.xyz), uintBitsToFloat(b.w),
                       uintBitsToFloat(c.xyz), c.w);
}

/// How much of the light `column` the row of this lane sees.
float seen(SliceGroup group, uint row, uint column)
{
    return uintBitsToFloat(texelFetch(values, int(group.firstValue + column * kSliceGroup + row)).x);
}

vec3 contribution(LightReceiver r, LightDetails details, LightRecord light)
{
    return kShape == kLightShapePoint ? lightContribution(r, details, light, push)
                                      : extendedContribution(r, details, light, push, kShape);
}

vec3 sumNumbers(SliceGroup group, LightReceiver r, LightDetails details, uint row)
{
    vec3 sum = vec3(0.0);
    uint column = 0u;
    do {
        float value;
        do {
            value = column < group.columns ? seen(group, row, column) : 1.0;
            ++column;
        } while (value == 0.0);
        if (column <= group.columns)
            sum += value * contribution(r, details, fetchLight(group.firstLight + column - 1u));
    } while (column < group.columns);
    return sum;
}

/// On to the next light that any lane of the subgroup sees, then all lanes shade it: lights are read by all lanes together,
/// and the lights that nobody sees cost a look at their bits. (A software device shades in a loop only where it has to, but
/// in a condition always; the search is a loop for that reason.)
vec3 sumBits(SliceGroup group, LightReceiver r, LightDetails details, uint row)
{
    const uint lanes = min(gl_SubgroupSize, kSliceWord);
    const uint together =
        lanes == kSliceWord ? 0xffffffffu : ((1u << lanes) - 1u) << (row & (kSliceWord - 1u) & ~(lanes - 1u));
    const uint mine = 1u << (row & (kSliceWord - 1u));
    const uint first = group.firstValue + row / kSliceWord * group.columns;
    vec3 sum = vec3(0.0);
    uint column = 0u;
    do {
        uint word;
        do {
            word = column < group.columns ? texelFetch(values, int(first + column)).x : 0xffffffffu;
            ++column;
        } while ((word & together) == 0u);
        if (column <= group.columns && (word & mine) != 0u)
            sum += contribution(r, details, fetchLight(group.firstLight + column - 1u));
    } while (column < group.columns);
    return sum;
}

void main()
{
    const SliceGroup group = fetchGroup(gl_WorkGroupID.x);
    const uint row = gl_LocalInvocationID.x;
    if (row >= group.rows || group.columns == 0u) {
        gathered[gl_GlobalInvocationID.x] = vec4(0.0);
        return;
    }
    const LightReceiver r = lookUpReceiver(scene, fetchReceiver(group.firstReceiver + row));
    const LightDetails details = LightDetails(group.firstDetail);
    const vec3 sum = kNumbers != 0u ? sumNumbers(group, r, details, row) : sumBits(group, r, details, row);
    gathered[gl_GlobalInvocationID.x] = vec4(sum, 0.0);
}
