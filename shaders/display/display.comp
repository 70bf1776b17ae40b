// One output pixel per lane, 8x8 to a group: the text of shared/display.h over two images of floats. What is shown is
// constant in the pipeline: a software device runs every branch that is left in it, for each pixel.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "shared/bindings.h"
#include "shared/display.h"

layout(local_size_x = 8, local_size_y = 8) in;

// In the order of gpu::DisplayChoices.
layout(constant_id = kSpecializeShow) const uint kShow = kShowRadiance;
layout(constant_id = kSpecializeShow + 1u) const uint kTone = 0u;
layout(constant_id = kSpecializeShow + 2u) const uint kMap = 0u;
layout(constant_id = kSpecializeShow + 3u) const uint kErrorKind = 0u;
layout(constant_id = kSpecializeShow + 4u) const uint kLogarithmic = 0u;
layout(constant_id = kSpecializeShow + 5u) const uint kChannelsA = 0u;
layout(constant_id = kSpecializeShow + 6u) const uint kChannelsB = 0u;
layout(constant_id = kSpecializeShow + 7u) const uint kSwapped = 0u;

layout(set = kSetKernel, binding = kBindImageA, scalar) readonly buffer ImageA { float imageA[]; };
layout(set = kSetKernel, binding = kBindImageB, scalar) readonly buffer ImageB { float imageB[]; };
layout(set = kSetKernel, binding = kBindDisplayed, scalar) writeonly buffer Output { uint outputPixels[]; };
layout(push_constant, scalar) uniform SettingsBlock { DisplaySettings given; };

void main()
{
    const uvec2 p = gl_GlobalInvocationID.xy;
    DisplaySettings settings = given;
    settings.show = kShow;
    settings.tone = kTone;
    settings.map = kMap;
    settings.errorKind = kErrorKind;
    settings.logarithmic = kLogarithmic;
    settings.channelsA = kChannelsA;
    settings.channelsB = kChannelsB;
    if (settings.channelsA == 0u) settings.widthA = 0u;
    if (settings.channelsB == 0u) settings.widthB = 0u;
    if (p.x >= settings.width || p.y >= settings.height) return;
    vec3 a = vec3(0.0);
    vec3 b = vec3(0.0);
    bool besideA = false;
    bool besideB = false;
    if (settings.channelsA != 0u) {
        const uint pixel = displayIndexA(settings, p.x, p.y);
        besideA = pixel == kBeside;
        const uint i = besideA ? 0u : settings.channelsA * pixel;
        a = settings.channelsA == 1u ? vec3(imageA[i]) : vec3(imageA[i], imageA[i + 1u], imageA[i + 2u]);
    }
    if (settings.channelsB != 0u) {
        const uint pixel = displayIndexB(settings, p.x, p.y);
        besideB = pixel == kBeside;
        const uint i = besideB ? 0u : settings.channelsB * pixel;
        b = settings.channelsB == 1u ? vec3(imageB[i]) : vec3(imageB[i], imageB[i + 1u], imageB[i + 2u]);
    }
    if (kShow == kShowPreview && displayGuided(settings) && !besideA) {
        uvec4 pixels;
        vec4 weights;
        displayCorners(settings, p.x, p.y, uint(b.x), pixels, weights);
        a *= weights.x;
        for (int i = 1; i < 4; ++i) {
            const uint at = 3u * pixels[i];
            a += weights[i] * vec3(imageA[at], imageA[at + 1u], imageA[at + 2u]);
        }
    }
    const uint packed = displayPack(displayColour(settings, p.x, a, b, besideA, besideB));
    outputPixels[p.y * settings.width + p.x] = kSwapped != 0u ? displaySwap(packed) : packed;
}
