// One tile of guided paths on the CPU, compiled for different features like those of the path
// tracer (path_kernel.h).
#pragma once

#include <span>

#include "core/guiding/guide.h"
#include "core/methods/path_kernel.h"
#include "shared/guided_path.h"

namespace core {

struct GuidedJob {
    PathJob path;
    shared::GuideView guide{};
    std::span<const float> image{};  // estimates of the pixels, or empty
};

/// As PathKernel; appends what recorded paths leave to `records`.
using GuidedKernel = TileTally (*)(const GuidedJob& job, const Tile& tile, Film& film,
                                   guiding::PathRecords& records);

/// What shared::shadeGuided is told of one vertex, beside scene, guide and settings.
struct GuidedStep {
    bool follows;
    const shared::VertexNumbers& numbers;
    const shared::Hit& hit;
    shared::PathState& path;
    shared::GuidedState& state;
    shared::ShadowRay& shadow;
    shared::GuideRecord& record;
    uint32_t& recorded;
    glm::vec3& L;
};

/// shared::shadeGuided.
using GuidedShade = bool (*)(const GuidedJob& job, const GuidedStep& step);

bool shadeFlatGuided(const GuidedJob& job, const GuidedStep& step);
bool shadeAnyGuided(const GuidedJob& job, const GuidedStep& step);
bool shadeAnyTreeGuided(const GuidedJob& job, const GuidedStep& step);

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
TileTally renderAnyTreeGuidedTile(const GuidedJob& job, const Tile& tile, Film& film,
                                  guiding::PathRecords& records);

}  // namespace core
