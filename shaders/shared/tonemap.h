// Scene-referred to display-referred: exposure, tone curves, the sRGB transfer function. Curves
// return linear Rec.709 in [0,1]; srgbEncode comes after. ACES is Hill's fit of RRT + ODT (with its
// own input matrix), AgX is Sobotka's with Wrensch's sixth-degree contrast, Neutral is the Khronos
// PBR Neutral specification.
#ifndef REKINDLE_SHARED_TONEMAP_H
#define REKINDLE_SHARED_TONEMAP_H

#include "lang.h"

SHARED_BEGIN

SHARED_CONST uint kToneLinear = 0u;
SHARED_CONST uint kToneAces = 1u;
SHARED_CONST uint kToneAgx = 2u;
SHARED_CONST uint kToneNeutral = 3u;

/// Radiance times 2^stops.
SHARED_FN vec3 expose(vec3 rgb, float stops)
{
    return rgb * exp2(stops);
}

SHARED_FN float srgbEncode(float x)
{
    x = clamp(x, 0.0f, 1.0f);
    return x <= 0.0031308f ? 12.92f * x : 1.055f * pow(x, 1.0f / 2.4f) - 0.055f;
}

SHARED_FN vec3 srgbEncode3(vec3 c)
{
    return vec3(srgbEncode(c.x), srgbEncode(c.y), srgbEncode(c.z));
}

SHARED_FN float srgbDecode(float x)
{
    x = clamp(x, 0.0f, 1.0f);
    return x <= 0.04045f ? x * (1.0f / 12.92f) : pow((x + 0.055f) * (1.0f / 1.055f), 2.4f);
}

SHARED_FN vec3 toneAces(vec3 rgb)
{
    vec3 v = vec3(0.59719f * rgb.x + 0.35458f * rgb.y + 0.04823f * rgb.z,
                  0.07600f * rgb.x + 0.90834f * rgb.y + 0.01566f * rgb.z,
                  0.02840f * rgb.x + 0.13383f * rgb.y + 0.83777f * rgb.z);
    // The curve has long been flat where squares would overflow.
    v = min(v, vec3(1.0e6f));
    v = (v * (v + vec3(0.0245786f)) - vec3(0.000090537f)) /
        (v * (0.983729f * v + vec3(0.4329510f)) + vec3(0.238081f));
    return vec3(1.60475f * v.x - 0.53108f * v.y - 0.07367f * v.z,
                -0.10208f * v.x + 1.10813f * v.y - 0.00605f * v.z,
                -0.00327f * v.x - 0.07276f * v.y + 1.07602f * v.z);
}

/// The contrast of AgX on log-encoded [0,1].
SHARED_FN float agxContrast(float x)
{
    return -0.00232f +
           x * (0.1191f + x * (0.4298f + x * (-6.868f + x * (31.96f + x * (-40.14f + x * 15.5f)))));
}

/// One channel through the log encoding (-12.47393 to 4.026069 stops) and the contrast.
SHARED_FN float agxChannel(float x)
{
    float stops = log2(max(x, 1.0e-10f));
    return agxContrast(clamp((stops + 12.47393f) * (1.0f / 16.499999f), 0.0f, 1.0f));
}

/// As AgX encodes it, with a plain power of 1 / 2.2; in [0, 1].
SHARED_FN vec3 agxEncoded(vec3 rgb)
{
    vec3 v = vec3(agxChannel(0.842479062f * rgb.x + 0.0784336f * rgb.y + 0.0792237451f * rgb.z),
                  agxChannel(0.0423282423f * rgb.x + 0.878468636f * rgb.y + 0.0791661275f * rgb.z),
                  agxChannel(0.0423756549f * rgb.x + 0.0784336f * rgb.y + 0.879142974f * rgb.z));
    v = vec3(1.196879005f * v.x - 0.0980208811f * v.y - 0.0990297441f * v.z,
             -0.0528968518f * v.x + 1.15190313f * v.y - 0.0989611768f * v.z,
             -0.0529716355f * v.x - 0.0980434501f * v.y + 1.15107367f * v.z);
    return clamp(v, vec3(0.0f), vec3(1.0f));
}

SHARED_FN vec3 toneAgx(vec3 rgb)
{
    vec3 v = agxEncoded(rgb);
    return vec3(pow(v.x, 2.2f), pow(v.y, 2.2f), pow(v.z, 2.2f));
}

/// srgbEncode(x^2.2) by one power, for it is most of what showing a pixel costs.
SHARED_FN float srgbFromAgx(float x)
{
    bool dark = x <= 0.0727213f;  // 0.0031308^(1 / 2.2)
    float y = pow(x, dark ? 2.2f : 2.2f / 2.4f);
    return dark ? 12.92f * y : 1.055f * y - 0.055f;
}

SHARED_FN vec3 toneNeutral(vec3 rgb)
{
    const float start = 0.8f - 0.04f;
    const float desaturation = 0.15f;
    float low = min(rgb.x, min(rgb.y, rgb.z));
    float offset = low < 0.08f ? low - 6.25f * low * low : 0.04f;
    vec3 v = rgb - vec3(offset);
    float peak = maxComponent(v);
    if (!(peak >= start)) {
        return v;
    }
    const float range = 1.0f - start;
    float newPeak = 1.0f - range * range / (peak + range - start);
    v = v * (newPeak / peak);
    float white = 1.0f - 1.0f / (desaturation * (peak - newPeak) + 1.0f);
    return v * (1.0f - white) + vec3(newPeak * white);
}

/// Negative and NaN channels count as zero, infinite ones as very bright.
SHARED_FN vec3 toneInput(vec3 rgb)
{
    return vec3(rgb.x > 0.0f ? min(rgb.x, 1.0e12f) : 0.0f,
                rgb.y > 0.0f ? min(rgb.y, 1.0e12f) : 0.0f,
                rgb.z > 0.0f ? min(rgb.z, 1.0e12f) : 0.0f);
}

/// A curve applied to linear Rec.709 of any values.
SHARED_FN vec3 toneMap(vec3 rgb, uint curve)
{
    rgb = toneInput(rgb);
    vec3 v = rgb;
    if (curve == kToneAces) {
        v = toneAces(rgb);
    } else if (curve == kToneAgx) {
        v = toneAgx(rgb);
    } else if (curve == kToneNeutral) {
        v = toneNeutral(rgb);
    }
    return clamp(v, vec3(0.0f), vec3(1.0f));
}

/// The same, sRGB-encoded.
SHARED_FN vec3 toneEncode(vec3 rgb, uint curve)
{
    if (curve == kToneAgx) {
        vec3 v = agxEncoded(toneInput(rgb));
        return vec3(srgbFromAgx(v.x), srgbFromAgx(v.y), srgbFromAgx(v.z));
    }
    return srgbEncode3(toneMap(rgb, curve));
}

SHARED_END

#endif
