// See frame.h.
#include "core/many_lights/frame.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/base/denormals.h"
#include "core/many_lights/clamp_distance.h"
#include "core/many_lights/light_paths.h"

namespace core::many_lights {

namespace {

constexpr uint32_t kPilotPaths = 1024;
constexpr uint32_t kTile = 16;
/// Lengths that stand for a unit of a normal, over the scene's radius: for slices the thesis's, for
/// lights a size below which neighbours may well belong to different surfaces.
constexpr float kSliceNormals = 0.05f, kLightNormals = 0.02f;

}  // namespace

LightPlan planLights(const Accel& accel, const FrameSettings& settings)
{
    const LightSet pilot = *traceVirtualLights(accel, settings.path, kPilotFrame, kPilotPaths);
    LightPlan plan;
    plan.paths = pathsForLights(pilot, settings.lights);
    if (settings.clamp > 0) plan.clampDistance = settings.clamp * clampDistance(accel, pilot);
    return plan;
}

std::shared_ptr<const FrameLights> makeFrameLights(const Accel& accel,
                                                   const FrameSettings& settings,
                                                   const LightPlan& plan, uint32_t frame,
                                                   const std::stop_token& stop)
{
    const auto lights = std::make_shared<FrameLights>();
    Clock::time_point start = Clock::now();
    std::optional<LightSet> set = traceVirtualLights(accel, settings.path, frame, plan.paths, stop);
    if (!set) return nullptr;
    lights->set = *std::move(set);
    lights->lightSeconds = secondsSince(start);
    start = Clock::now();
    const LightTreeSettings tree{kLightNormals * accel.world().radius,
                                 shared::hashUint(settings.path.seed ^ shared::hashUint(frame))};
    std::optional<LightTree> made = makeLightTree(lights->set.lights, tree, stop);
    if (!made) return nullptr;
    lights->tree = *std::move(made);
    lights->treeSeconds = secondsSince(start);
    return lights;
}

std::unique_ptr<Frame> Frame::begin(const Accel& accel, const FrameSettings& settings,
                                    const LightPlan& plan,
                                    std::shared_ptr<const FrameLights> lights, uint32_t index,
                                    const std::stop_token& stop, const PixelDone& done)
{
    std::unique_ptr<Frame> frame(new Frame);
    frame->lights_ = std::move(lights);
    frame->perPixel_ = settings.side * settings.side;
    SliceJob& job = frame->job_;
    job.receivers = {&accel,        settings.path, settings.camera,
                     settings.side, index,         settings.centred};
    job.lights = &frame->lights_->set;
    job.tree = &frame->lights_->tree;
    job.gather = {settings.path.maxDepth, plan.clampDistance};
    job.completion = settings.completion;
    job.clusters = settings.clusters;
    job.compensates = settings.compensates;
    FrameStats& stats = frame->stats_;
    stats.lights = frame->lights_->set.lights.size();
    stats.lightRays = frame->lights_->set.rays;
    stats.lightSeconds = frame->lights_->lightSeconds;
    stats.treeSeconds = frame->lights_->treeSeconds;
    const Clock::time_point start = Clock::now();
    if (!frame->findReceivers(stop)) return nullptr;
    SliceSettings slicing;
    slicing.normalScale = kSliceNormals * accel.world().radius;
    slicing.threshold = settings.sliceSize;
    frame->slices_ = makeSlices(frame->receivers_, slicing, stop);
    if (stop.stop_requested()) return nullptr;
    frame->sliceDone_.assign(frame->slices_.ranges.size(), 0);
    frame->sliceStats_.resize(frame->slices_.ranges.size());
    frame->countPending();
    stats.receiverSeconds = secondsSince(start);
    for (size_t pixel = 0; pixel < frame->pending_.size(); ++pixel)
        if (frame->pending_[pixel] == 0) frame->finishPixel(pixel, done);
    return frame;
}

bool Frame::findReceivers(const std::stop_token& stop)
{
    const shared::PathSettings& path = job_.receivers.settings;
    const size_t pixels = size_t(path.imageWidth) * path.imageHeight;
    radiance_.assign(pixels * perPixel_, glm::vec3(0));
    const uint32_t perRow = (path.imageWidth + kTile - 1) / kTile;
    std::vector<std::vector<Receiver>> tiles(size_t(perRow) *
                                             ((path.imageHeight + kTile - 1) / kTile));
    std::atomic<uint64_t> rays = 0;
    const bool whole = parallelTiles(
        path.imageWidth, path.imageHeight, kTile,
        [&](const Tile& tile) {
            const FlushDenormals flush;
            std::vector<Receiver>& mine = tiles[size_t(tile.y0 / kTile) * perRow + tile.x0 / kTile];
            rays += traceReceivers(job_.receivers, tile, mine, radiance_);
        },
        stop);
    size_t count = 0;
    for (const auto& tile : tiles) count += tile.size();
    receivers_.reserve(count);
    for (auto& tile : tiles) {
        receivers_.insert(receivers_.end(), tile.begin(), tile.end());
        tile = {};
    }
    stats_.cameraRays = rays;
    return whole;
}

void Frame::countPending()
{
    pending_ = std::vector<std::atomic<uint8_t>>(radiance_.size() / perPixel_);
    for (const Receiver& r : receivers_) ++pending_[r.place / perPixel_];
}

bool Frame::advance(Clock::time_point start, double seconds, const std::stop_token& stop,
                    const PixelDone& done)
{
    std::stop_source over;
    const std::stop_callback passOn(stop, [&over] { over.request_stop(); });
    parallelFor(
        slices_.ranges.size(), 1,
        [&](size_t slice, size_t) {
            if (sliceDone_[slice] != 0) return;
            const FlushDenormals flush;
            static thread_local SliceWorker worker;
            const IndexRange range = slices_.ranges[slice];
            const std::span<const uint32_t> chosen(slices_.order.data() + range.begin,
                                                   range.size());
            if (!worker.run(job_, receivers_, chosen, static_cast<uint32_t>(slice), stop)) return;
            finishSlice(slice, worker, done);
            if (secondsSince(start) >= seconds) over.request_stop();
        },
        over.get_token());
    return slicesDone_ == slices_.ranges.size();
}

void Frame::finishSlice(size_t slice, const SliceWorker& worker, const PixelDone& done)
{
    const IndexRange range = slices_.ranges[slice];
    for (uint32_t i = 0; i < range.size(); ++i)
        radiance_[receivers_[slices_.order[range.begin + i]].place] += worker.radiance()[i];
    // The last of a pixel's receivers sees what other threads have written of the others.
    for (uint32_t i = 0; i < range.size(); ++i) {
        const size_t pixel = receivers_[slices_.order[range.begin + i]].place / perPixel_;
        if (pending_[pixel].fetch_sub(1) == 1) finishPixel(pixel, done);
    }
    sliceStats_[slice] = worker.stats();
    sliceDone_[slice] = 1;
    const std::lock_guard lock(mutex_);
    stats_.slices += worker.stats();
    ++slicesDone_;
}

void Frame::finishPixel(size_t pixel, const PixelDone& done) const
{
    glm::vec3 sum(0);
    for (uint32_t i = 0; i < perPixel_; ++i) sum += radiance_[pixel * perPixel_ + i];
    done(pixel, sum / static_cast<float>(perPixel_));
}

std::vector<float> Frame::perPixel(std::span<const float> of) const
{
    CHECK(of.size() == slices_.ranges.size());
    std::vector<float> values(pending_.size()), counts(pending_.size());
    for (size_t slice = 0; slice < of.size(); ++slice)
        for (uint32_t i = slices_.ranges[slice].begin; i < slices_.ranges[slice].end; ++i) {
            const size_t pixel = receivers_[slices_.order[i]].place / perPixel_;
            values[pixel] += of[slice];
            counts[pixel] += 1;
        }
    for (size_t pixel = 0; pixel < values.size(); ++pixel)
        if (counts[pixel] > 0) values[pixel] /= counts[pixel];
    return values;
}

}  // namespace core::many_lights
