// One output pixel per lane, 8x8 to a group: the text of shared/display.h over two images of floats, in texel buffers:
// a software device loads 16 bytes at once from them and single words from others. What is shown is constant in the
// pipeline: such a device runs every branch that is left in it, for each pixel.
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

layout(set = kSetKernel, binding = kBindImageA) uniform samplerBuffer imageA;  // a value of one channel is there thrice
layout(set = kSetKernel, binding = kBindImageB) uniform samplerBuffer imageB;
layout(set = kSetKernel, binding = kBindEncoded) uniform samplerBuffer encoded;  // of kShowPreview, by encode.comp
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
        if (kShow != kShowPreview) {
            a = texelFetch(imageA, besideA ? 0 : int(pixel)).rgb;
        } else if (!besideA) {
            const vec4 own = texelFetch(encoded, int(pixel));
            uvec4 pixels;
            vec4 weights;
            displayCorners(settings, p.x, p.y, uint(own.a), pixels, weights);
            a = weights.x * own.rgb;
            for (int i = 1; i < 4; ++i) a += weights[i] * texelFetch(encoded, int(pixels[i])).rgb;
        }
    }
    if (settings.channelsB != 0u) {
        const uint pixel = displayIndexB(settings, p.x, p.y);
        besideB = pixel == kBeside;
        b = texelFetch(imageB, besideB ? 0 : int(pixel)).rgb;
    }
    const uint packed = displayPack(displayColour(settings, p.x, a, b, besideA, besideB));
    outputPixels[p.y * settings.width + p.x] = kSwapped != 0u ? displaySwap(packed) : packed;
}
