// One sample of the whole picture: a set of virtual lights, a set of receivers, and the slices that
// are lit one after the other.
#pragma once

#include <atomic>
#include <mutex>

#include "core/base/time.h"
#include "core/many_lights/slice_shading.h"
#include "core/many_lights/technique.h"

namespace core::many_lights {

struct FrameSettings {
    shared::PathSettings path{};
    shared::CameraData camera{};
    uint32_t lights = 10000, clusters = 250, side = 1, sliceSize = 1000;
    float clamp = 0.01f;   // as ManyLightsParams has it
    bool centred = false;  // as ReceiverJob has it
    bool compensates = true;
    bool packets = true;  // as SliceJob has it
    Technique technique = Technique::clusters;
    float error = 0.02f;  // as ManyLightsParams has it
    LightShape shape = LightShape::point;
    CompletionParams completion{.method = CompletionMethod::full};
};

/// Seconds of clocks before the first slice, and what the slices took.
struct FrameStats {
    SliceStats slices;
    uint64_t lights = 0, lightRays = 0, cameraRays = 0;
    uint64_t lightsDropped = 0;  // that were not numbers
    uint64_t techniqueRays = 0;  // before the first slice
    double lightSeconds = 0, treeSeconds = 0, receiverSeconds = 0, techniqueSeconds = 0;
    double deviceSeconds = 0;  // that a device took for its sums
};

/// The lights of one frame with their tree: what does not depend on the camera.
struct FrameLights {
    LightSet set;
    LightTree tree;
    double lightSeconds = 0, treeSeconds = 0;
};

/// The points of one frame with their slices: what does not depend on the lights.
struct FrameReceivers {
    std::vector<Receiver> receivers;
    SliceSettings slicing;  // that the slices were made with
    Slices slices;
    std::vector<glm::vec3> direct;  // what is seen beside the light of virtual lights, by place
    uint64_t rays = 0;              // from the camera
    double seconds = 0;
};

/// What is known of a world's lights before the first frame: from paths of their own.
struct LightPlan {
    uint32_t paths = 0;       // of a frame
    float clampDistance = 0;  // metres
    double bytes = 0;         // that the lights of a frame take, about
};
LightPlan planLights(const Accel& accel, const FrameSettings& settings);

/// The lights of a frame; null when `stop` came first. Throws an Error when the machine does not
/// hold them.
std::shared_ptr<const FrameLights> makeFrameLights(const Accel& accel,
                                                   const FrameSettings& settings,
                                                   const LightPlan& plan, uint32_t frame,
                                                   const std::stop_token& stop);

/// The lights of `from` with another tree over them, and so with other representatives; null when
/// `stop` came first.
std::shared_ptr<const FrameLights> withOtherTree(const Accel& accel, const FrameLights& from,
                                                 uint32_t seed, const std::stop_token& stop);

/// The receivers of a frame, found and sliced; null when `stop` came first.
std::shared_ptr<const FrameReceivers> makeFrameReceivers(const Accel& accel,
                                                         const FrameSettings& settings,
                                                         uint32_t frame,
                                                         const std::stop_token& stop);

/// What has become of a frame's slices and pixels; every slice is lit whole or not at all.
class Frame {
public:
    /// The values of a pixel's receivers are complete: called once per pixel, from any thread.
    using PixelDone = std::function<void(size_t pixel, const glm::vec3& radiance)>;

    /// Prepares the technique and hands out the pixels without receivers. Null when `stop` came
    /// first; throws an Error when the machine does not hold what lighting slices takes.
    static std::unique_ptr<Frame> begin(const Accel& accel, const FrameSettings& settings,
                                        const LightPlan& plan,
                                        std::shared_ptr<const FrameLights> lights,
                                        std::shared_ptr<const FrameReceivers> receivers,
                                        uint32_t index, const std::stop_token& stop,
                                        const PixelDone& done);

    /// Leaves out the slices that are not marked (one entry per slice): they count as done and stay
    /// dark. Before the first advance().
    void keepOnly(std::span<const uint8_t> slices);

    /// Lights slices on all threads until none is left, a stop comes or the time is over; slices
    /// under way are given up at a stop, and finished at the end of the time. `device` sums them
    /// where there is one; throws what it throws. True when none is left.
    bool advance(Clock::time_point start, double seconds, const std::stop_token& stop,
                 const PixelDone& done, BatchSum* device = nullptr);

    double fraction() const
    {
        return slices().ranges.empty() ? 1 : double(slicesDone_) / double(slices().ranges.size());
    }
    size_t slicesDone() const { return slicesDone_; }
    const FrameStats& stats() const { return stats_; }

    /// A value of each slice at the pixels of its receivers (their mean), for maps: `of` has one
    /// entry per slice. Pixels without receivers are 0.
    std::vector<float> perPixel(std::span<const float> of) const;
    /// Of every slice that has been lit.
    std::span<const SliceStats> sliceStats() const { return sliceStats_; }

    /// Radiance by place; of receivers that are not lit yet only what is seen beside virtual
    /// lights.
    std::span<const glm::vec3> radiance() const { return radiance_; }
    const SliceJob& job() const { return job_; }

private:
    Frame() = default;
    const Slices& slices() const { return points_->slices; }
    bool makeReady(const FrameSettings& settings, const std::stop_token& stop);
    void countPending();
    std::span<const uint32_t> receiversOf(size_t slice) const
    {
        const IndexRange range = slices().ranges[slice];
        return {slices().order.data() + range.begin, range.size()};
    }
    void finishSlice(size_t slice, std::span<const glm::vec3> radiance, const SliceStats& stats,
                     const PixelDone& done);
    void finishPixel(size_t pixel, const PixelDone& done) const;

    SliceJob job_;
    std::shared_ptr<const FrameLights> lights_;
    ReadyTechnique technique_;
    uint32_t perPixel_ = 1;
    std::shared_ptr<const FrameReceivers> points_;
    std::vector<glm::vec3> radiance_;            // by place
    std::vector<std::atomic<uint8_t>> pending_;  // receivers of a pixel that are not lit yet
    std::vector<uint8_t> sliceDone_;
    std::vector<SliceStats> sliceStats_;
    size_t slicesDone_ = 0;
    FrameStats stats_;
    std::mutex mutex_;
};

}  // namespace core::many_lights
