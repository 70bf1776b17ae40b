// What sample reuse does at the pixels of a tile, on the CPU, and what a view leaves to the next
// one. The estimator is that of shaders/shared/reuse_new.h. Compiled for different features like
// the path tracer (path_kernel.h).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/base/parallel.h"
#include "core/methods/reuse_params.h"
#include "core/trace/accel.h"
#include "core/trace/scene_view.h"
#include "shared/reuse_new.h"

namespace core {

/// What a view leaves to the next one.
struct ReuseStore {
    std::shared_ptr<const World> world;  // as it was then
    std::vector<shared::ReusePixel> pixels;
    std::vector<shared::ReuseSample> samples;  // `records` per pixel, where the strategy keeps any
    std::vector<shared::ReuseLight> lights;    // `lights` per pixel, likewise
    std::vector<glm::vec3> means;              // of strategies that keep one
    std::vector<glm::vec3> remainders;         // of those that keep samples (remainderNow)
    std::vector<shared::ReuseMapPixel> maps;
    shared::CameraData camera{};
    glm::uvec2 size{0};  // 0: there is nothing

    /// Makes room for a picture of that size; what was there is no longer of use.
    void reset(glm::uvec2 newSize, const ReuseParams& params);
};

/// The scene as the shared text reads it, rays through it, and what has moved since the view
/// before.
struct TracedScene : shared::SceneView {
    const Accel* accel = nullptr;
    const World* worldBefore = nullptr;
    std::span<const shared::MovedPiece> moved;
};

/// Whether a connection that is found blocked comes to its end nonetheless, through panes, by which
/// it is dimmed.
bool comesThroughPanes(const TracedScene& scene, shared::ShadowRay& shadow, uint32_t seed,
                       shared::ReuseTally& tally);

/// What all pixels of a pass have in common. Old samples are read from `before`, and what is kept
/// is written to `now`, whose camera and size are those of the picture. Different tiles may be
/// estimated at the same time.
struct ReuseJob {
    TracedScene scene;
    const ReuseStore& before;
    ReuseStore& now;
    shared::PathSettings path;
    shared::ReuseSettings settings;
    float perDeviation;    // see allocatedPart
    uint32_t firstSample;  // the index of the pass's first sample

    /// Pixels of the picture for each of the one before; 1 where there was none.
    float magnified() const
    {
        const float had = float(before.size.x) * float(before.size.y);
        return had > 0 ? float(now.size.x) * float(now.size.y) / had : 1;
    }
};

/// Refers to all three and to `moved`, which must outlive it: what of the scene has moved since
/// `before`.
ReuseJob makeReuseJob(const Accel& accel, const ReuseStore& before, ReuseStore& now,
                      std::span<const shared::MovedPiece> moved, const shared::PathSettings& path,
                      const shared::ReuseSettings& settings, float perDeviation,
                      uint32_t firstSample);

/// What a pass finds at the pixels of a tile of at most kFilmTile x kFilmTile, row by row in
/// `sums`, and in the store what it leaves there. Adds its rays to `tally`.
using ReuseKernel = void (*)(const ReuseJob& job, const Tile& tile,
                             std::span<shared::ReuseSums> sums, shared::ReuseTally& tally);

struct ReuseVariant {
    uint32_t features;
    ReuseKernel kernel;
};

/// From the least able to the one that knows everything.
std::span<const ReuseVariant> reuseVariants();

void estimateFlatReuseTile(const ReuseJob& job, const Tile& tile, std::span<shared::ReuseSums> sums,
                           shared::ReuseTally& tally);
void estimateAnyReuseTile(const ReuseJob& job, const Tile& tile, std::span<shared::ReuseSums> sums,
                          shared::ReuseTally& tally);

}  // namespace core
