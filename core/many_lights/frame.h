// One sample of the whole picture: a set of virtual lights, a set of receivers, and the slices that
// are lit one after the other.
#pragma once

#include <atomic>
#include <mutex>

#include "core/base/time.h"
#include "core/many_lights/slice_shading.h"
#include "core/many_lights/slices.h"

namespace core::many_lights {

struct FrameSettings {
    shared::PathSettings path{};
    shared::CameraData camera{};
    uint32_t lights = 10000, clusters = 250, side = 1, sliceSize = 1000;
    float clamp = 0.01f;   // as ManyLightsParams has it
    bool centred = false;  // as ReceiverJob has it
    bool compensates = true;
    CompletionParams completion{.method = CompletionMethod::full};
};

/// Seconds of clocks before the first slice, and what the slices took.
struct FrameStats {
    SliceStats slices;
    uint64_t lights = 0, lightRays = 0, cameraRays = 0;
    double lightSeconds = 0, treeSeconds = 0, receiverSeconds = 0;
};

/// The lights of one frame with their tree: what does not depend on the camera.
struct FrameLights {
    LightSet set;
    LightTree tree;
    double lightSeconds = 0, treeSeconds = 0;
};

/// What is known of a world's lights before the first frame: from paths of their own.
struct LightPlan {
    uint32_t paths = 0;       // of a frame
    float clampDistance = 0;  // metres
};
LightPlan planLights(const Accel& accel, const FrameSettings& settings);

/// The lights of a frame; null when `stop` came first.
std::shared_ptr<const FrameLights> makeFrameLights(const Accel& accel,
                                                   const FrameSettings& settings,
                                                   const LightPlan& plan, uint32_t frame,
                                                   const std::stop_token& stop);

/// What has become of a frame's slices and pixels; every slice is lit whole or not at all.
class Frame {
public:
    /// The values of a pixel's receivers are complete: called once per pixel, from any thread.
    using PixelDone = std::function<void(size_t pixel, const glm::vec3& radiance)>;

    /// Finds the receivers and their slices, hands out the pixels without any. Null when `stop`
    /// came first.
    static std::unique_ptr<Frame> begin(const Accel& accel, const FrameSettings& settings,
                                        const LightPlan& plan,
                                        std::shared_ptr<const FrameLights> lights, uint32_t index,
                                        const std::stop_token& stop, const PixelDone& done);

    /// Lights slices on all threads until none is left, a stop comes or the time is over; slices
    /// under way are given up at a stop, and finished at the end of the time. True when none is
    /// left.
    bool advance(Clock::time_point start, double seconds, const std::stop_token& stop,
                 const PixelDone& done);

    double fraction() const
    {
        return slices_.ranges.empty() ? 1 : double(slicesDone_) / double(slices_.ranges.size());
    }
    size_t slicesDone() const { return slicesDone_; }
    const FrameStats& stats() const { return stats_; }

    /// A value of each slice at the pixels of its receivers (their mean), for maps: `of` has one
    /// entry per slice. Pixels without receivers are 0.
    std::vector<float> perPixel(std::span<const float> of) const;
    /// Of every slice that has been lit.
    std::span<const SliceStats> sliceStats() const { return sliceStats_; }

private:
    Frame() = default;
    bool findReceivers(const std::stop_token& stop);
    void countPending();
    void finishSlice(size_t slice, const SliceWorker& worker, const PixelDone& done);
    void finishPixel(size_t pixel, const PixelDone& done) const;

    SliceJob job_;
    std::shared_ptr<const FrameLights> lights_;
    uint32_t perPixel_ = 1;
    std::vector<Receiver> receivers_;
    std::vector<glm::vec3> radiance_;            // by place
    std::vector<std::atomic<uint8_t>> pending_;  // receivers of a pixel that are not lit yet
    Slices slices_;
    std::vector<uint8_t> sliceDone_;
    std::vector<SliceStats> sliceStats_;
    size_t slicesDone_ = 0;
    FrameStats stats_;
    std::mutex mutex_;
};

}  // namespace core::many_lights
