// From images of radiance, first hits or errors to the colours of the display: one text for the
// window and for files. The maps viridis and magma are after van der Walt and Smith, "A Better
// Default Colormap for Matplotlib", 2015; here as polynomials of degree 6 fitted to the published
// tables in the largest error: at most 0.010 (viridis) and 0.017 (magma) in any sRGB channel. CIE
// lightness rises along all three maps, by at least 53, 30 and 100 per unit.
#ifndef REKINDLE_SHARED_DISPLAY_H
#define REKINDLE_SHARED_DISPLAY_H

#include "tonemap.h"

SHARED_BEGIN

SHARED_CONST uint kShowRadiance = 0u;   // exposure, tone curve, sRGB
SHARED_CONST uint kShowDirection = 1u;  // unit vectors: 0.5 + 0.5 n
SHARED_CONST uint kShowColour = 2u;     // reflectances: sRGB alone
SHARED_CONST uint kShowScalar = 3u;     // one channel through the colour map, low to high
SHARED_CONST uint kShowId = 4u;  // whole numbers as colours that are told apart; negative is black
// A - b, signed: blue below, red above, `high` at full colour
SHARED_CONST uint kShowDifference = 5u;
SHARED_CONST uint kShowError = 6u;    // error of a against b through the colour map, 0 to high
SHARED_CONST uint kShowCompare = 7u;  // left of the slider a, right of it b, both as radiance
SHARED_CONST uint kShowDepth = 8u;    // as kShowScalar; 0 is no distance: nothing was hit
SHARED_CONST uint kShowPreview = 9u;  // radiance of few pixels, smooth within each surface of b

SHARED_CONST uint kMapViridis = 0u;
SHARED_CONST uint kMapMagma = 1u;
SHARED_CONST uint kMapGrey = 2u;

SHARED_CONST uint kErrorAbsolute = 0u;
SHARED_CONST uint kErrorRelative = 1u;
SHARED_CONST uint kErrorSquared = 2u;

/// `width`, `height` of the output; images of other sizes are stretched over it, or over a part of
/// it (nearest pixel), beside which there is the background. An image of width 0 is absent: without
/// a the output is the background, and what compares shows a alone without b. A value that is NaN
/// is magenta in every view.
struct DisplaySettings {
    uint width, height;
    uint widthA, heightA, channelsA;
    uint widthB, heightB, channelsB;
    uint show;
    uint channel;  // of a: which one kShowScalar and kShowId look at
    uint map, errorKind;
    uint tone;
    float exposure;
    float low, high;
    uint logarithmic;                      // of kShowScalar: the scale between low and high
    float slider;                          // of kShowCompare, in [0, 1]
    float stepAx, stepAy, stepBx, stepBy;  // pixels of an image per pixel of the output
    float fromAx, fromAy, fromBx, fromBy;  // pixels of an image at the output's corner
};

SHARED_CONST uint kBeside = 0xffffffffu;  // no pixel of the image

SHARED_CONST float kErrorFloor = 0.01f;  // of kErrorRelative and kErrorSquared, as in relMSE

SHARED_FN bool displayIsNan(float x)
{
    return (floatAsUint(x) & 0x7fffffffu) > 0x7f800000u;  // isnan may be optimised away
}

SHARED_FN bool displayIsNan3(vec3 v)
{
    return displayIsNan(v.x) || displayIsNan(v.y) || displayIsNan(v.z);
}

/// Magenta, for what is NaN.
SHARED_FN vec3 displayNoNumber()
{
    return vec3(1.0f, 0.0f, 1.0f);
}

/// Index of the pixel of an image of `w` x `h` that is shown at (x, y) of the output, or kBeside.
SHARED_FN uint displayIndex(uint x, uint y, uint w, uint h, vec2 pace, vec2 from)
{
    vec2 at = vec2((float(x) + 0.5f) * pace.x + from.x, (float(y) + 0.5f) * pace.y + from.y);
    if (!(at.x >= 0.0f && at.y >= 0.0f && at.x <= float(w) && at.y <= float(h))) {
        return kBeside;
    }
    uint column = min(uint(at.x), w - 1u);
    uint row = min(uint(at.y), h - 1u);
    return row * w + column;
}

SHARED_FN uint displayIndexA(DisplaySettings s, uint x, uint y)
{
    return displayIndex(x, y, s.widthA, s.heightA, vec2(s.stepAx, s.stepAy),
                        vec2(s.fromAx, s.fromAy));
}

SHARED_FN uint displayIndexB(DisplaySettings s, uint x, uint y)
{
    return displayIndex(x, y, s.widthB, s.heightB, vec2(s.stepBx, s.stepBy),
                        vec2(s.fromBx, s.fromBy));
}

/// A colour map at t in [0, 1] (clamped), as sRGB-encoded values.
SHARED_FN vec3 displayMap(uint map, float t)
{
    t = clamp(t, 0.0f, 1.0f);
    vec3 c = vec3(t);
    if (map == kMapViridis) {
        c = vec3(-2.32847f, 2.75612f, 38.2395f);
        c = c * t + vec3(-5.8873f, -7.89668f, -101.281f);
        c = c * t + vec3(20.1412f, 7.29929f, 97.2866f);
        c = c * t + vec3(-13.1638f, -2.01791f, -40.5224f);
        c = c * t + vec3(2.08176f, -0.729049f, 5.12082f);
        c = c * t + vec3(-0.136997f, 1.48928f, 0.954385f);
        c = c * t + vec3(0.276925f, 0.00375531f, 0.337708f);
    } else if (map == kMapMagma) {
        c = vec3(12.7548f, -13.2304f, 5.37308f);
        c = c * t + vec3(-32.6581f, 34.2994f, -26.1836f);
        c = c * t + vec3(31.0815f, -33.5646f, 44.3336f);
        c = c * t + vec3(-16.1123f, 16.6741f, -28.4246f);
        c = c * t + vec3(5.39345f, -3.81999f, 3.41146f);
        c = c * t + vec3(0.542524f, 0.609317f, 2.25926f);
        c = c * t + vec3(-0.00666737f, 0.00964707f, -0.00293217f);
    }
    return clamp(c, vec3(0.0f), vec3(1.0f));
}

/// Where a value lies between `low` and `high`: 0 at or below low, 1 at or above high; a
/// logarithmic scale has its low end above zero.
SHARED_FN float displayScale(float value, float low, float high, uint logarithmic)
{
    if (logarithmic != 0u) {
        low = log2(max(low, 1.0e-30f));
        high = log2(max(high, 1.0e-30f));
        value = log2(clamp(value, 1.0e-30f, 3.0e38f));
    }
    if (!(high > low)) {
        return value > low ? 1.0f : 0.0f;
    }
    return clamp((value - low) / (high - low), 0.0f, 1.0f);
}

/// Error of luminance `image` against `reference`, by kind; never negative.
SHARED_FN float displayError(float image, float reference, uint kind)
{
    float d = abs(image - reference);
    float r = abs(reference);
    if (kind == kErrorRelative) {
        return d / (r + kErrorFloor);
    }
    if (kind == kErrorSquared) {
        return d * d / (r * r + kErrorFloor);
    }
    return d;
}

/// Signed difference over full scale: black at 0, blue at -1, red at +1, both of them light enough
/// to tell from black early (the root).
SHARED_FN vec3 displaySigned(float t)
{
    float strength = sqrt(clamp(abs(t), 0.0f, 1.0f));
    vec3 end = t < 0.0f ? vec3(0.30f, 0.58f, 1.0f) : vec3(1.0f, 0.36f, 0.22f);
    return end * strength;
}

/// A colour for a whole number: hue, saturation and value from a hash (Jarzynski, Olano 2020: pcg),
/// never dark.
SHARED_FN vec3 displayId(float id)
{
    if (id < 0.0f) {
        return vec3(0.0f);
    }
    uint h = uint(min(id, 4.0e9f)) * 747796405u + 2891336453u;
    h = ((h >> ((h >> 28u) + 4u)) ^ h) * 277803737u;
    h = (h >> 22u) ^ h;
    float hue = 6.0f * float(h & 1023u) / 1024.0f;
    float saturation = 0.35f + 0.5f * float((h >> 10u) & 255u) / 255.0f;
    float value = 0.6f + 0.4f * float((h >> 18u) & 255u) / 255.0f;
    vec3 pure =
        vec3(clamp(abs(hue - 3.0f) - 1.0f, 0.0f, 1.0f), clamp(2.0f - abs(hue - 2.0f), 0.0f, 1.0f),
             clamp(2.0f - abs(hue - 4.0f), 0.0f, 1.0f));
    return value * (vec3(1.0f - saturation) + saturation * pure);
}

/// Where no surface was hit, in a view of distances: no colour of any map but grey's.
SHARED_FN vec3 displayNothing()
{
    return vec3(0.17f, 0.17f, 0.18f);
}

SHARED_FN vec3 displayRadiance(DisplaySettings s, vec3 radiance)
{
    return toneEncode(expose(radiance, s.exposure), s.tone);
}

/// The colour of a pixel of radiance. Of kShowPreview it is what displayCorners weights: few pixels
/// are encoded, many are shown.
SHARED_FN vec3 displayEncoded(DisplaySettings s, vec3 radiance)
{
    return displayIsNan3(radiance) ? displayNoNumber() : displayRadiance(s, radiance);
}

/// Of kShowPreview: whether b is a guide to a. Bit 3 (dy + 1) + dx + 1 of its values says whether
/// the pixel and its neighbour at (dx, dy) show one surface. The bits above are a cut, see
/// displayCut(); none at all: there is none.
SHARED_FN bool displayGuided(DisplaySettings s)
{
    return s.channelsA == 3u && s.channelsB == 1u && s.widthA == s.widthB && s.heightA == s.heightB;
}

SHARED_CONST uint kCutBits = 9u;  // of a guide's values: where those of the cut begin
SHARED_CONST uint kMostCutRun = 15u;

/// An edge that is aslant in few pixels is a row of steps; a line from the middle of one step to
/// that of the next takes a part of each pixel beside them for the neighbour across the edge. Of a
/// step of `run` pixels, 1 to kMostCutRun: the pixel is the one `away` from its end, less than half
/// of it. `side`: where the neighbour is, 0 right, 1 left, 2 below, 3 above. `back`: the end is to
/// the left or above, not to the right or below.
SHARED_FN uint displayCut(uint run, uint away, uint side, bool back)
{
    return (run | (away << 4u) | (side << 7u) | (back ? 1u << 9u : 0u)) << kCutBits;
}

/// How much of an output pixel, `wide` as a pixel of a and at `t` from that one's middle, is beyond
/// the cut `cut`; 0 where there is none. By the distance of its own middle, so that edges are as
/// smooth as by area to a twentieth.
SHARED_FN float displayBeyond(uint cut, vec2 t, float wide)
{
    float run = float(cut & 15u);
    bool upright = ((cut >> 8u) & 1u) == 0u;
    float over = upright ? t.x : t.y;
    float along = upright ? t.y : t.x;
    over = ((cut >> 7u) & 1u) == 0u ? over : -over;
    along = ((cut >> 9u) & 1u) == 0u ? along : -along;
    float ahead = run * over + along - float((cut >> 4u) & 7u) - 0.5f;
    return run > 0.0f ? clamp(0.5f + ahead / (wide * sqrt(run * run + 1.0f)), 0.0f, 1.0f) : 0.0f;
}

/// Of kShowPreview: the four pixels of a around (x, y) of the output, the one that it lies in
/// first, and their bilinear weights, which sum up to one. `alike` is the guide there: who is of
/// another surface leaves its weight to the first. What is beyond the pixel's cut has the weight of
/// the neighbour across the edge and the one next to it.
SHARED_FN void displayCorners(DisplaySettings s, uint x, uint y, uint alike, OUT(uvec4) pixels,
                              OUT(vec4) weights)
{
    vec2 at =
        vec2((float(x) + 0.5f) * s.stepAx + s.fromAx, (float(y) + 0.5f) * s.stepAy + s.fromAy);
    uint column = min(uint(max(at.x, 0.0f)), s.widthA - 1u);
    uint row = min(uint(max(at.y, 0.0f)), s.heightA - 1u);
    float tx = at.x - float(column) - 0.5f;
    float ty = at.y - float(row) - 0.5f;
    uint cut = alike >> kCutBits;
    float beyond = displayBeyond(cut, vec2(tx, ty), s.stepAx);
    bool upright = ((cut >> 8u) & 1u) == 0u;  // the edge, so that the neighbour is beside the pixel
    bool cutsX = beyond > 0.0f && upright;
    bool cutsY = beyond > 0.0f && !upright;
    int towards = ((cut >> 7u) & 1u) == 0u ? 1 : -1;
    int dx = cutsX ? towards : tx < 0.0f ? -1 : 1;
    int dy = cutsY ? towards : ty < 0.0f ? -1 : 1;
    tx = cutsX ? beyond : min(abs(tx), 0.5f);
    ty = cutsY ? beyond : min(abs(ty), 0.5f);
    bool aside = cutsX || ((alike >> uint(4 + dx)) & 1u) != 0u;
    bool below = cutsY || ((alike >> uint(4 + 3 * dy)) & 1u) != 0u;
    bool across = ((alike >> uint(4 + 3 * dy + dx)) & 1u) != 0u;
    int pixel = int(row * s.widthA + column);
    int line = dy * int(s.widthA);
    int right = aside ? pixel + dx : pixel;
    int down = below ? pixel + line : pixel;
    int corner = across ? pixel + line + dx : pixel;
    // The surface across the edge goes on along it where the pixel's own does, and at its end.
    int end = ((cut >> 9u) & 1u) == 0u ? 1 : -1;
    if (cutsX) corner = right + (below || dy == end ? line : 0);
    if (cutsY) corner = down + (aside || dx == end ? dx : 0);
    pixels = uvec4(uint(pixel), uint(right), uint(down), uint(corner));
    weights = vec4((1.0f - tx) * (1.0f - ty), tx * (1.0f - ty), (1.0f - tx) * ty, tx * ty);
}

/// The sRGB-encoded colour of an output pixel of column x, from the values that the images have
/// there (images of one channel: thrice the same; of kShowPreview a is a colour already);
/// `besideA`, `besideB`: they have none there.
SHARED_FN vec3 displayColour(DisplaySettings s, uint x, vec3 a, vec3 b, bool besideA, bool besideB)
{
    const vec3 background = vec3(0.07f, 0.075f, 0.085f);
    if (s.widthA == 0u) {
        return background;
    }
    uint show = s.show;
    if (s.widthB == 0u && (show == kShowDifference || show == kShowError || show == kShowCompare)) {
        show = kShowRadiance;
    }
    if (show == kShowCompare) {
        float distance = abs(float(x) + 0.5f - s.slider * float(s.width));
        if (distance < 1.0f) {
            return vec3(0.95f);
        }
        if (distance < 2.0f) {
            return vec3(0.05f);
        }
        if (float(x) + 0.5f > s.slider * float(s.width)) {
            a = b;
            besideA = besideB;
        }
        show = kShowRadiance;
    } else if (show == kShowDifference || show == kShowError) {
        besideA = besideA || besideB;
    }
    if (besideA) {
        return background;
    }
    if (show == kShowPreview) {
        return a;
    }
    float value = s.channel == 0u ? a.x : s.channel == 1u ? a.y : a.z;
    if (show == kShowScalar || show == kShowId || show == kShowDepth) {
        if (displayIsNan(value)) {
            return displayNoNumber();
        }
        if (show == kShowDepth && !(value > 0.0f)) {
            return displayNothing();
        }
        return show == kShowId
                   ? displayId(value)
                   : displayMap(s.map, displayScale(value, s.low, s.high, s.logarithmic));
    }
    if (displayIsNan3(a)) {
        return displayNoNumber();
    }
    if (show == kShowDirection) {
        return clamp(vec3(0.5f) + 0.5f * a, vec3(0.0f), vec3(1.0f));
    }
    if (show == kShowColour) {
        return srgbEncode3(a);
    }
    if (show == kShowDifference || show == kShowError) {
        float image = luminance(a);
        float reference = luminance(b);
        float d =
            show == kShowError ? displayError(image, reference, s.errorKind) : image - reference;
        if (displayIsNan(d)) {
            return displayNoNumber();
        }
        return show == kShowError ? displayMap(s.map, displayScale(d, 0.0f, s.high, 0u))
                                  : displaySigned(d / max(s.high, 1.0e-30f));
    }
    return displayRadiance(s, a);
}

/// Red in the lowest byte, alpha 255 in the highest.
SHARED_FN uint displayPack(vec3 c)
{
    c = clamp(c, vec3(0.0f), vec3(1.0f)) * 255.0f + vec3(0.5f);
    return uint(c.x) | (uint(c.y) << 8u) | (uint(c.z) << 16u) | 0xff000000u;
}

/// The same with red and blue exchanged: B8G8R8A8.
SHARED_FN uint displaySwap(uint packed)
{
    return (packed & 0xff00ff00u) | ((packed & 0xffu) << 16u) | ((packed >> 16u) & 0xffu);
}

SHARED_END

#endif
