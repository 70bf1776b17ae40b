// Set 1: the settings of the view and the counters; and the one place where lanes become pixels. Images are cut into
// tiles of 8x8 pixels, and the lanes of a tile follow the Morton curve, so that neighbours trace neighbouring rays.
#ifndef REKINDLE_FRAME_GLSL
#define REKINDLE_FRAME_GLSL

#include "shared/bindings.h"

layout(set = kSetFrame, binding = kBindFrame, scalar) uniform FrameBlock
{
    FrameData frame;
};

layout(set = kSetFrame, binding = kBindCounters, scalar) buffer CounterBlock
{
    Counters counters;
};

uint everyOtherBit(uint x)
{
    x &= 0x55u;
    x = (x | (x >> 1u)) & 0x33u;
    return (x | (x >> 2u)) & 0x0fu;
}

/// The pixel of lane `lane` (below 64) of a tile; may lie outside the image at its right and lower borders.
uvec2 tilePixel(uint tile, uint lane)
{
    const uvec2 corner = 8u * uvec2(tile % frame.tilesPerRow, tile / frame.tilesPerRow);
    return corner + uvec2(everyOtherBit(lane), everyOtherBit(lane >> 1u));
}

bool insideImage(uvec2 pixel)
{
    return pixel.x < frame.settings.imageWidth && pixel.y < frame.settings.imageHeight;
}

/// Row by row from the top.
uint pixelIndex(uvec2 pixel)
{
    return pixel.y * frame.settings.imageWidth + pixel.x;
}

uint laneCount(Batch batch)
{
    return batch.tileCount * batch.sampleCount * kGroupSize;
}

/// The pixel of a lane of a batch.
uvec2 lanePixel(Batch batch, uint lane)
{
    return tilePixel(batch.firstTile + (lane / kGroupSize) % batch.tileCount, lane % kGroupSize);
}

/// The index of the sample that a lane of a batch takes.
uint laneSample(Batch batch, uint lane)
{
    return batch.firstSample + lane / (kGroupSize * batch.tileCount);
}

#endif
