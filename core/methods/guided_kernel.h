// One tile of guided paths on the CPU, compiled for different features like those of the path
// tracer (path_kernel.h).
#pragma once

#include <span>

#include "core/guiding/guide.h"
#include "core/methods/path_kernel.h"

namespace core {

struct GuidedJob {
    PathJob path;
    shared::GuideView guide{};
    std::span<const float> image{};  // estimates of the pixels, or empty
};

/// As PathKernel; appends what recorded paths leave to `records`.
using GuidedKernel = TileTally (*)(const GuidedJob& job, const Tile& tile, Film& film,
                                   guiding::PathRecords& records);

struct GuidedVariant {
    uint32_t features;
    GuidedKernel kernel;
};

/// From the least able to the one that knows everything.
std::span<const GuidedVariant> guidedVariants();

TileTally renderFlatGuidedTile(const GuidedJob& job, const Tile& tile, Film& film,
                               guiding::PathRecords& records);
TileTally renderAnyGuidedTile(const GuidedJob& job, const Tile& tile, Film& film,
                              guiding::PathRecords& records);

}  // namespace core
