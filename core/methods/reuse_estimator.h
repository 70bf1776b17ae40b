// What sample reuse does at one pixel, on the CPU, and what a view leaves to the next one. The
// estimator is that of shaders/shared/reuse_new.h.
#pragma once

#include <memory>
#include <span>
#include <vector>

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

/// What all pixels of a pass have in common. Old samples are read from `before`, and what is kept
/// is written to `now`, whose camera and size are those of the picture. Different pixels may be
/// estimated at the same time.
class ReuseEstimator {
public:
    /// Refers to all three and to `moved`, which must outlive it: what of the scene has moved since
    /// `before`. `perDeviation`: see allocatedPart; `firstSample`: the index of the pass's first
    /// sample.
    ReuseEstimator(const Accel& accel, const ReuseStore& before, ReuseStore& now,
                   std::span<const shared::MovedPiece> moved, const shared::PathSettings& path,
                   const shared::ReuseSettings& settings, float perDeviation, uint32_t firstSample);

    /// What a pass finds at a pixel, and in the store what it leaves there. Adds its rays to
    /// `tally`.
    shared::ReuseSums estimate(glm::uvec2 pixel, shared::ReuseTally& tally) const;

private:
    struct Pixel;
    template <class Record> struct Competition;

    bool findVertex(glm::uvec2 pixel, Pixel& p, shared::ReuseSums& sums) const;
    ptrdiff_t findHistory(const Pixel& p, const shared::ReuseChain& chain,
                          const shared::CameraData& cameraBefore) const;
    float deviationAround(size_t source) const;
    void takePaths(Pixel& p, uint32_t taken, shared::ReuseSums& sums) const;
    glm::vec3 takeRest(const shared::ReuseChain& chain, Pixel& p) const;
    void keepSamples(Pixel& p, std::span<const shared::ReuseNew> fresh,
                     shared::ReuseSums& sums) const;
    void keepMean(const Pixel& p, const shared::ReuseSums& sums) const;
    void lookAtOld(Pixel& p, Competition<shared::ReuseSample>& samples,
                   Competition<shared::ReuseLight>& lights, shared::ReuseSums& sums) const;
    glm::vec3 meanOfTaps(const Pixel& p, glm::vec3 nearest) const;
    bool keepsMeans() const { return shared::keepsMeans(settings_.strategy); }
    bool keepsSamples() const { return shared::keepsSamples(settings_.strategy); }

    TracedScene scene_;
    const ReuseStore& before_;
    ReuseStore& now_;
    shared::PathSettings path_;
    shared::ReuseSettings settings_;
    float perDeviation_;
    uint32_t records_, lights_, firstSample_;
};

}  // namespace core
