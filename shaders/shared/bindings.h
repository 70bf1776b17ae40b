// Binding numbers of the one descriptor set that all kernels share, and the push constants of the
// path tracer.
#ifndef REKINDLE_SHARED_BINDINGS_H
#define REKINDLE_SHARED_BINDINGS_H

#include "layout.h"

SHARED_BEGIN

// Uniform texel buffers. All but the last four are RGBA32UI: bits must survive the fetch.
SHARED_CONST uint kBindNodes = 0u;
SHARED_CONST uint kBindTriangles = 1u;
SHARED_CONST uint kBindIndices = 2u;
SHARED_CONST uint kBindAttributes = 3u;
SHARED_CONST uint kBindExtra = 4u;
SHARED_CONST uint kBindMaterials = 5u;
SHARED_CONST uint kBindTextureReferences = 6u;
SHARED_CONST uint kBindEmitters = 7u;
SHARED_CONST uint kBindStateTexels = 8u;      // the paths that a bounce reads
SHARED_CONST uint kBindTexels = 9u;           // RGBA16F
SHARED_CONST uint kBindEmitterCdf = 10u;      // R32F
SHARED_CONST uint kBindEnvironment = 11u;     // RGBA32F
SHARED_CONST uint kBindEnvironmentCdf = 12u;  // R32F
SHARED_CONST uint kTexelBindings = 13u;

// A uniform buffer: FrameData.
SHARED_CONST uint kBindFrame = 13u;

// Storage buffers.
// The paths that a bounce writes, three words of 16 bytes each
SHARED_CONST uint kBindStates = 14u;
SHARED_CONST uint kBindRadiance = 15u;  // vec4 per lane
SHARED_CONST uint kBindQueues = 16u;    // QueueHead per bounce
SHARED_CONST uint kBindFilm0 = 17u;     // vec4 per pixel, three buffers: see accumulate.comp
SHARED_CONST uint kBindFilm1 = 18u;
SHARED_CONST uint kBindFilm2 = 19u;
SHARED_CONST uint kBindCounters = 20u;  // Counters
SHARED_CONST uint kBindOutput = 21u;    // vec4s of the kernel's own meaning
SHARED_CONST uint kBindingCount = 22u;

// Specialization constants beside kFeatures (0).
SHARED_CONST uint kSpecializeSampler = 1u;  // the sampler's kind, so that only one is compiled

/// Everything that stays fixed between two changes of the view.
struct FrameData {
    PathSettings settings;
    CameraData camera;
    vec3 gridLow;  // of the BVH: cell = (world - gridLow) * gridScale
    uint reserved0;
    vec3 gridScale;
    uint tilesPerRow;  // 8x8 pixels each
};

/// One batch of paths: tiles [firstTile, firstTile + tileCount) times samples [firstSample,
/// firstSample + sampleCount). lane = (sample * tileCount + tile) * 64 + Morton index in the tile.
struct Batch {
    uint firstTile;
    uint tileCount;
    uint firstSample;
    uint sampleCount;
    uint bounce;  // index of the queue to read; kBatchContinues unless the bounce begins the paths
};
SHARED_CONST uint kBatchContinues = 0x80000000u;

/// Indirect dispatch arguments of one bounce, and how many paths wait in its queue.
struct QueueHead {
    uint groupsX;
    uint groupsY;
    uint groupsZ;
    uint count;
};

struct Counters {
    uint nan;
    uint inf;
    uint negative;
    uint stackOverflow;
    uint closestRays;
    uint shadowRays;
    uint reserved0;
    uint reserved1;
};

SHARED_CONST uint kGroupSize = 64u;
SHARED_CONST uint kStateWords = 3u;

#ifdef __cplusplus
static_assert(sizeof(FrameData) == 176 && sizeof(Batch) == 20 && sizeof(QueueHead) == 16 &&
              sizeof(Counters) == 32);
#endif

SHARED_END

#endif
