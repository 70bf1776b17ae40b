// From images of radiance, first hits or errors to the colours of the display: one text for the window and for files.
#ifndef REKINDLE_SHARED_DISPLAY_H
#define REKINDLE_SHARED_DISPLAY_H

#include "tonemap.h"

SHARED_BEGIN

SHARED_CONST uint kShowRadiance = 0u;    // exposure, tone curve, sRGB
SHARED_CONST uint kShowDirection = 1u;   // unit vectors: 0.5 + 0.5 n
SHARED_CONST uint kShowColour = 2u;      // reflectances: sRGB alone
SHARED_CONST uint kShowScalar = 3u;      // one channel through the colour map, low to high
SHARED_CONST uint kShowId = 4u;          // whole numbers as colours that are told apart; negative is black
SHARED_CONST uint kShowDifference = 5u;  // a - b, signed: blue below, red above, `high` at full colour
SHARED_CONST uint kShowError = 6u;       // error of a against b through the colour map, 0 to high
SHARED_CONST uint kShowCompare = 7u;     // left of the slider a, right of it b, both as radiance

SHARED_CONST uint kMapViridis = 0u;
SHARED_CONST uint kMapMagma = 1u;
SHARED_CONST uint kMapGrey = 2u;

SHARED_CONST uint kErrorAbsolute = 0u;
SHARED_CONST uint kErrorRelative = 1u;
SHARED_CONST uint kErrorSquared = 2u;

/// `width`, `height` of the output; images of other sizes are stretched over it (nearest pixel).
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
    uint logarithmic;  // of kShowScalar: the scale between low and high
    float slider;      // of kShowCompare, in [0, 1]
};

SHARED_END

#endif
