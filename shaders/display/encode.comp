// The colours of a picture of few pixels, each with what the guide says there, for display.comp to enlarge: tone curve and
// encoding are most of what a pixel costs to show.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/bindings.h"
#include "shared/display.h"

layout(local_size_x = 64) in;

layout(constant_id = kSpecializeShow) const uint kTone = 0u;

layout(set = kSetKernel, binding = kBindImageA) uniform samplerBuffer imageA;
layout(set = kSetKernel, binding = kBindImageB) uniform samplerBuffer guide;
layout(set = kSetKernel, binding = kBindEncoded, scalar) writeonly buffer Encoded { vec4 encoded[]; };
layout(push_constant, scalar) uniform SettingsBlock { DisplaySettings given; };

void main()
{
    const uint pixel = rowsLane(gl_GlobalInvocationID, gl_NumWorkGroups);
    DisplaySettings settings = given;
    settings.tone = kTone;
    if (pixel >= settings.widthA * settings.heightA) return;
    const vec3 radiance = texelFetch(imageA, int(pixel)).rgb;
    encoded[pixel] = vec4(displayEncoded(settings, radiance), texelFetch(guide, int(pixel)).r);
}
