// What all slices of a frame have in common, and what lighting them took.
#pragma once

#include "core/completion/completion.h"
#include "core/many_lights/light_tree.h"
#include "core/many_lights/receivers.h"
#include "core/many_lights/slice_rows.h"

namespace core::many_lights {

class ColumnSource;
class SliceLighter;

struct SliceJob {
    ReceiverJob receivers;
    const LightSet* lights = nullptr;
    const ColumnSource* columns = nullptr;
    const SliceLighter* lighter = nullptr;  // lights slices in its own way, without columns
    GatherSettings gather;
    CompletionParams completion;
    bool packets = true;  // false: every shadow ray on its own, as a baseline of measurements
    LightShape shape = LightShape::point;
    float aloneRadius = 0;    // of a light with extent that has no neighbours
    bool compensates = true;  // finds the light that is lost otherwise (lost_light.h)
};

/// Differs between the frames of a setting's seed, by bits above those of 2^20 numbers of slices.
/// From frame 4096 on the bits are those of other seeds, too: such frames may draw the same
/// numbers, but for other lights and other points.
inline uint64_t frameSeed(const ReceiverJob& job)
{
    return uint64_t(job.settings.seed) << 32 ^ uint64_t(job.frame) << 20;
}

/// What slices took; seconds are those of threads, not of clocks.
struct SliceStats {
    CompletionStats completion;
    uint64_t slices = 0, rows = 0, clusters = 0, otherRays = 0;
    double cutSeconds = 0, orderSeconds = 0, shadingSeconds = 0, lostSeconds = 0;

    SliceStats& operator+=(const SliceStats& other);
};

}  // namespace core::many_lights
