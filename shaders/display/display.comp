// One output pixel per lane, 8x8 to a group: the text of shared/display.h over two images of floats. What is shown is a
// constant of the pipeline: kFeatures holds show (4 bits), tone (4), map (4), kind of error (4), logarithmic (1), channels of
// a (2) and b (2), red and blue exchanged (1).
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
layout(push_constant, scalar) uniform SettingsBlock { DisplaySettings given; };

void main()
{
    const uvec2 p = gl_GlobalInvocationID.xy;
    DisplaySettings settings = given;
    settings.show = kFeatures & 15u;
    settings.tone = (kFeatures >> 4u) & 15u;
    settings.map = (kFeatures >> 8u) & 15u;
    settings.errorKind = (kFeatures >> 12u) & 15u;
    settings.logarithmic = (kFeatures >> 16u) & 1u;
    settings.channelsA = (kFeatures >> 17u) & 3u;
    settings.channelsB = (kFeatures >> 19u) & 3u;
    if (settings.channelsA == 0u) settings.widthA = 0u;
    if (settings.channelsB == 0u) settings.widthB = 0u;
    if (p.x >= settings.width || p.y >= settings.height) return;
    vec3 a = vec3(0.0);
    vec3 b = vec3(0.0);
    if (settings.channelsA != 0u) {
        const uint i = settings.channelsA * displayIndex(p.x, p.y, settings.widthA, settings.heightA, settings.stepAx,
                                                         settings.stepAy);
        a = settings.channelsA == 1u ? vec3(imageA[i]) : vec3(imageA[i], imageA[i + 1u], imageA[i + 2u]);
    }
    if (settings.channelsB != 0u) {
        const uint i = settings.channelsB * displayIndex(p.x, p.y, settings.widthB, settings.heightB, settings.stepBx,
                                                         settings.stepBy);
        b = settings.channelsB == 1u ? vec3(imageB[i]) : vec3(imageB[i], imageB[i + 1u], imageB[i + 2u]);
    }
    const uint packed = displayPack(displayColour(settings, p.x, a, b));
    const bool swapped = (kFeatures >> 21u & 1u) != 0u;
    outputPixels[p.y * settings.width + p.x] = swapped ? displaySwap(packed) : packed;
}
