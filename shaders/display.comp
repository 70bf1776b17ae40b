// One output pixel per lane, 8x8 to a group: the text of shared/display.h over two images of floats.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/bindings.h"
#include "shared/display.h"

layout(local_size_x = 8, local_size_y = 8) in;

// The layout of all kernels, with meanings of its own.
layout(set = 0, binding = kBindStates, scalar) readonly buffer ImageA { float imageA[]; };
layout(set = 0, binding = kBindRadiance, scalar) readonly buffer ImageB { float imageB[]; };
layout(set = 0, binding = kBindOutput, scalar) writeonly buffer Output { uint outputPixels[]; };
layout(push_constant, scalar) uniform SettingsBlock
{
    DisplaySettings settings;
    uint swapped;
};

void main()
{
    const uvec2 p = gl_GlobalInvocationID.xy;
    if (p.x >= settings.width || p.y >= settings.height) return;
    vec3 a = vec3(0.0);
    vec3 b = vec3(0.0);
    if (settings.widthA != 0u) {
        const uint i = settings.channelsA * displayIndex(p.x, p.y, settings.width, settings.height, settings.widthA,
                                                         settings.heightA);
        a = settings.channelsA == 1u ? vec3(imageA[i]) : vec3(imageA[i], imageA[i + 1u], imageA[i + 2u]);
    }
    if (settings.widthB != 0u) {
        const uint i = settings.channelsB * displayIndex(p.x, p.y, settings.width, settings.height, settings.widthB,
                                                         settings.heightB);
        b = settings.channelsB == 1u ? vec3(imageB[i]) : vec3(imageB[i], imageB[i + 1u], imageB[i + 2u]);
    }
    const uint packed = displayPack(displayColour(settings, p.x, a, b));
    outputPixels[p.y * settings.width + p.x] = swapped != 0u ? displaySwap(packed) : packed;
}
