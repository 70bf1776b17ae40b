// What host and kernels exchange: the numbers of descriptor sets and bindings, the push constants
// of every kernel, and the records of the frame. Three sets, each with its bindings counted from
// zero:
//   0  the scene   uniform texel buffers (scene.glsl)
//   1  the frame   what stays fixed between two changes of the view, and the counters (frame.glsl)
//   2  the kernel  buffers of its own; the host reads their kinds from the kernel's SPIR-V
#ifndef REKINDLE_SHARED_BINDINGS_H
#define REKINDLE_SHARED_BINDINGS_H

#include "intersect.h"
#include "layout.h"
#include "reuse_allocation.h"

SHARED_BEGIN

SHARED_CONST uint kSetScene = 0u;
SHARED_CONST uint kSetFrame = 1u;
SHARED_CONST uint kSetKernel = 2u;
SHARED_CONST uint kSetCount = 3u;

// Set 0. All but four are RGBA32UI: bits must survive the fetch.
SHARED_CONST uint kBindNodes = 0u;
SHARED_CONST uint kBindTriangles = 1u;
SHARED_CONST uint kBindIndices = 2u;
SHARED_CONST uint kBindAttributes = 3u;
SHARED_CONST uint kBindExtra = 4u;
SHARED_CONST uint kBindMaterials = 5u;
SHARED_CONST uint kBindTextureReferences = 6u;
SHARED_CONST uint kBindEmitters = 7u;
SHARED_CONST uint kBindTexels = 8u;           // RGBA16F
SHARED_CONST uint kBindEmitterCdf = 9u;       // R32F
SHARED_CONST uint kBindEnvironment = 10u;     // RGBA32F
SHARED_CONST uint kBindEnvironmentCdf = 11u;  // R32F
SHARED_CONST uint kBindEmitterTree = 12u;     // emitter_tree.h
SHARED_CONST uint kBindInstances = 13u;       // instances.h
SHARED_CONST uint kBindSkyRegions = 14u;      // sky_regions.h
SHARED_CONST uint kSceneBindings = 15u;

// Set 1.
SHARED_CONST uint kBindFrame = 0u;     // uniform buffer: FrameData
SHARED_CONST uint kBindCounters = 1u;  // storage buffer: Counters

// Set 2 of bounce, megakernel and accumulate.
SHARED_CONST uint kBindRadiance = 0u;     // vec4 per lane of a batch
SHARED_CONST uint kBindStateTexels = 1u;  // bounce: the paths that are read, kStateWords each
SHARED_CONST uint kBindStates = 2u;       // bounce: the paths that are written
SHARED_CONST uint kBindQueues = 3u;       // bounce: QueueHead per bounce

// And beside these, of guided paths: the guide and the pixels' estimates as texels, what they carry
// and what they leave (guided_path.h).
SHARED_CONST uint kBindGuideNodes = 4u;
SHARED_CONST uint kBindGuideLeaves = 5u;
SHARED_CONST uint kBindGuideDirections = 6u;
SHARED_CONST uint kBindPixelEstimates = 7u;  // a float per pixel, four to a word
SHARED_CONST uint kBindGuidedStates = 8u;    // guided_bounce: GuidedState per lane
SHARED_CONST uint kBindGuideRecords = 9u;    // GuideRecord, kGuideVertices per recorded path
SHARED_CONST uint kBindPathEnds = 10u;       // GuidePathEnd per recorded path

// Set 2 of accumulate and mean: the words of film.h, one buffer each, and the mean.
SHARED_CONST uint kBindFilm0 = 1u;  // vec4 per pixel, in three buffers
SHARED_CONST uint kBindFilm1 = 2u;
SHARED_CONST uint kBindFilm2 = 3u;
SHARED_CONST uint kBindFilmWeight = 4u;  // vec2 per pixel
SHARED_CONST uint kBindMean = 0u;        // vec3 per pixel

// Set 2 of first_hits and seen.
SHARED_CONST uint kBindFirstHits = 0u;     // FirstHit per pixel
SHARED_CONST uint kBindLookingLanes = 1u;  // lanes of first_hits that are left to seen,
SHARED_CONST uint kBindLookingHead = 2u;   // and their QueueHead

// Set 2 of the kernels of sample reuse, beside those of the film: what the frame before has left
// (texels), what this one leaves to the next, and what one kernel leaves to the next.
SHARED_CONST uint kBindPixelsBefore = 5u;    // ReusePixel
SHARED_CONST uint kBindPlacesBefore = 6u;    // ReuseSample, its first word
SHARED_CONST uint kBindArrivingBefore = 7u;  // and its second
SHARED_CONST uint kBindLightsBefore = 8u;    // ReuseLight
SHARED_CONST uint kBindMeansBefore = 9u;     // means, maps, deviations
SHARED_CONST uint kBindPixelsNow = 10u;
SHARED_CONST uint kBindPlacesNow = 11u;
SHARED_CONST uint kBindArrivingNow = 12u;
SHARED_CONST uint kBindLightsNow = 13u;
SHARED_CONST uint kBindMeansNow = 14u;
SHARED_CONST uint kBindNewSamples = 15u;        // ReuseNew per new path, kReuseNewWords each
SHARED_CONST uint kBindWaiting = 16u;           // lanes that get a new path, with its number above
SHARED_CONST uint kBindWaitingHead = 17u;       // WaitingHead of these
SHARED_CONST uint kBindFirstNew = 18u;          // per lane: which are the pixel's, and its credit
SHARED_CONST uint kBindChainsNow = 19u;         // ReuseChain per lane, where there is one,
SHARED_CONST uint kBindChains = 20u;            // and as it is read
SHARED_CONST uint kBindMovedPieces = 21u;       // MovedPiece, two texels each
SHARED_CONST uint kBindTrianglesBefore = 22u;   // three texels each
SHARED_CONST uint kBindSlotsNow = 23u;          // uint per slot of the frame before
SHARED_CONST uint kBindRemaindersBefore = 24u;  // remainderNow of strategies that keep samples
SHARED_CONST uint kBindRemaindersNow = 25u;
SHARED_CONST uint kBindTrails = 26u;        // ReuseTrail per new path, kReuseTrailWords each,
SHARED_CONST uint kBindTrailsNow = 27u;     // and as it is written
SHARED_CONST uint kBindPathGathered = 28u;  // vec4 per new path
SHARED_CONST uint kBindPathTexels = 29u;    // paths under way that are read, kReuseStateWords each,
SHARED_CONST uint kBindPathStates = 30u;    // and those that are written
SHARED_CONST uint kBindPathQueues = 31u;    // QueueHead per bounce

// Set 2 of bench_closest and bench_any.
SHARED_CONST uint kBindRays = 0u;  // texels, two per ray
SHARED_CONST uint kBindHits = 1u;  // vec4 per ray

// Set 2 of display and encode.
SHARED_CONST uint kBindImageA = 0u;
SHARED_CONST uint kBindImageB = 1u;
SHARED_CONST uint kBindDisplayed = 2u;
SHARED_CONST uint kBindEncoded = 3u;  // of encode written, of display read: vec4 per pixel

// Set 2 of gather: all but the first are texels, the last of one number each (virtual_light.h).
SHARED_CONST uint kBindGathered = 0u;  // vec4 per lane
SHARED_CONST uint kBindSliceGroups = 1u;
SHARED_CONST uint kBindReceivers = 2u;
SHARED_CONST uint kBindVirtualLights = 3u;
SHARED_CONST uint kBindLightDetails = 4u;
SHARED_CONST uint kBindSliceValues = 5u;

// The most that any one kernel sees in its three sets.
SHARED_CONST uint kMostTexelBuffers = 27u;    // reuse_old
SHARED_CONST uint kMostStorageBuffers = 11u;  // reuse_old
SHARED_CONST uint kMostResources = 39u;       // reuse_old
SHARED_CONST uint kMostPushBytes = 128u;      // what every device has

// Specialization constants: kFeatures is number 0 (lang.h). Those of path kernels and of the
// display follow it.
SHARED_CONST uint kSpecializeSampler = 1u;  // the sampler's kind, so that only one is compiled
SHARED_CONST uint kSpecializeGuided = 2u;   // guided paths: the kind of guide, 0 for none,
SHARED_CONST uint kSpecializeNee = 3u;      // and what connections are weighted against
SHARED_CONST uint kSpecializeRecords = 2u;  // sample reuse: samples that a pixel keeps,
SHARED_CONST uint kSpecializeLights = 3u;   // connections,
SHARED_CONST uint kSpecializeFresh = 4u;    // and new paths that it may have
SHARED_CONST uint kSpecializeNumbers = 1u;  // gather: numbers in place of bits,
SHARED_CONST uint kSpecializeShape = 2u;    // and the shape of the lights
SHARED_CONST uint kSpecializeShow = 1u;     // the display's first: see app/gpu/window/display.cpp

/// Everything that stays fixed between two changes of the view.
struct FrameData {
    PathSettings settings;
    CameraData camera;
    BvhEntry entry;
    uint tilesPerRow;  // 8x8 pixels each
};

/// Lanes that trace paths: tiles [firstTile, firstTile + tileCount) times samples [firstSample,
/// firstSample + sampleCount). lane = (sample * tileCount + tile) * 64 + Morton index in the tile.
struct Batch {
    uint firstTile;
    uint tileCount;
    uint firstSample;
    uint sampleCount;
};

/// One bounce of a batch.
struct BounceBatch {
    Batch batch;
    uint queue;   // index of the one to read; the next one is written
    uint begins;  // 1: the paths begin here, and nothing is read
};

/// A pass of sample reuse over some tiles, whose sample indices begin at `firstSample`; how many
/// there are follows from the settings.
struct ReuseBatch {
    Batch batch;
    ReuseSettings settings;
    CameraData cameraBefore;
};

/// One bounce of the new paths of such a pass.
struct ReuseBounceBatch {
    Batch batch;
    ReuseSettings settings;
    uint queue;  // index of the one to read; the next one is written
};

/// Consecutive pixels, row by row.
struct PixelRange {
    uint firstPixel;
    uint pixelCount;
};

/// First hits of tiles; `firstPixel` is where the output begins. `looksThrough`: not 0 where
/// mirrors and glass are looked into (seen.h).
struct TileRange {
    uint firstTile;
    uint tileCount;
    uint firstPixel;
    uint looksThrough;
};

/// The first `count` items of an array: rays, or whatever a kernel works on one by one.
struct ItemRange {
    uint count;
};

/// Indirect dispatch arguments of one bounce, and how many paths wait in its queue.
struct QueueHead {
    uint groupsX;
    uint groupsY;
    uint groupsZ;
    uint count;
};

/// Of the pixels that wait for new paths; `perDeviation`: see allocatedPart.
struct WaitingHead {
    QueueHead queue;
    float perDeviation;
};

struct Counters {
    uint nan;
    uint inf;
    uint negative;
    uint closestRays;
    uint shadowRays;
    uint cutRays;      // whose traversal ended before all was looked at (traverse.glsl)
    uint scatters;     // of sample reuse: first hits that scatter,
    uint withHistory;  // those with a history,
    uint weightSum;    // and over all of them the sum of v and that of c, in units of
    uint shareSum;     // 1 / kCountedUnit
    uint newPaths;     // of sample reuse, too
    uint asked;        // and where visibility was asked for across a move: first hits that scatter,
    uint leaked;       // biasShare, in units of 1 / kCountedBias
    uint lost;
    uint deviations[kDeviationBins];  // where paths are allocated: pixels by deviationBin
};
SHARED_CONST float kCountedUnit = 256.0f;
SHARED_CONST float kCountedBias = 2048.0f;

SHARED_CONST uint kGroupSize = 64u;

/// The number of a lane of rows of groups (groupRows in app/gpu/base/kernel.h).
SHARED_FN uint rowsLane(uvec3 invocation, uvec3 groups)
{
    return invocation.y * groups.x * kGroupSize + invocation.x;
}

// Of 16 bytes: origin, lane with depth above it; direction, pdf; beta, departure; and where there
// are panes or regions of the sky, what of PathState they need.
SHARED_CONST uint kStateWords = 4u;
SHARED_CONST uint kStateLaneBits = 18u;

#ifdef __cplusplus
static_assert(sizeof(FrameData) == 240 && sizeof(QueueHead) == 16 && sizeof(WaitingHead) == 20 &&
              sizeof(Counters) == 56 + 4 * kDeviationBins);
static_assert(sizeof(ReuseBatch) == kMostPushBytes);
#endif

SHARED_END

#endif
