// A scene whose frames are lit in part, again and again: with the same virtual lights, receivers
// and slices, by one method after the other.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "app/bench/many_lights/many_lights_results.h"
#include "app/bench/many_lights/many_lights_subset.h"
#include "core/base/progress.h"
#include "core/scene/camera.h"

namespace app::many_lights {

/// What became of a part of a frame.
struct Lit {
    std::vector<glm::vec3> values;  // of the subset's pixels
    core::many_lights::SliceStats stats;
    double seconds = 0, wallSeconds = 0;  // of all cores (bench_clock.h); by the clock on the wall
    double beforeSeconds = 0;             // of these, what the technique needs for the whole frame
    double beforeRays = 0;
};

/// Functions that return pointers or optionals return nothing once a stop is requested.
class LitScene {
public:
    /// `common`: parameters that all methods share.
    LitScene(std::shared_ptr<const core::World> world, const core::Camera& camera, glm::uvec2 size,
             const core::ManyLightsParams& common, const core::Progress& progress,
             std::stop_token stop);

    /// Traces the virtual lights. False: stopped. Throws core::Error when there are none, or
    /// nothing to shine on.
    bool findLights();

    std::shared_ptr<const core::many_lights::FrameLights> lights() const { return lights_; }
    /// The same lights with a tree of its own for every repetition.
    std::shared_ptr<const core::many_lights::FrameLights> lightsOf(uint32_t repetition) const;

    /// Receivers, in slices of that size.
    std::shared_ptr<const core::many_lights::FrameReceivers> points(uint32_t sliceSize);

    /// Lights the subset. `seed` is that of completion.
    std::optional<Lit> light(const core::ManyLightsParams& params, bool packets,
                             std::shared_ptr<const core::many_lights::FrameLights> lights,
                             const Subset& subset, uint32_t seed);

    /// A frame of which nothing is lit yet.
    std::unique_ptr<core::many_lights::Frame>
    frame(const core::ManyLightsParams& params, bool packets,
          std::shared_ptr<const core::many_lights::FrameLights> lights, uint32_t seed);

    const core::World& world() const { return *world_; }
    const core::Accel& accel() const { return *accel_; }
    const core::Camera& camera() const { return camera_; }
    glm::uvec2 size() const { return size_; }
    const core::ManyLightsParams& common() const { return common_; }
    const std::stop_token& stop() const { return stop_; }
    uint32_t perPixel() const;
    double clampDistance() const { return double(plan_.clampDistance); }

private:
    core::many_lights::FrameSettings settings(const core::ManyLightsParams& params) const;

    std::shared_ptr<const core::World> world_;
    std::unique_ptr<core::Accel> accel_;
    core::Camera camera_;
    glm::uvec2 size_;
    core::ManyLightsParams common_;
    std::stop_token stop_;
    core::many_lights::LightPlan plan_;
    std::shared_ptr<const core::many_lights::FrameLights> lights_;
    std::map<uint32_t, std::shared_ptr<const core::many_lights::FrameReceivers>> points_;
};

}  // namespace app::many_lights
