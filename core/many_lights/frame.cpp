// See frame.h.
#include "core/many_lights/frame.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/base/denormals.h"
#include "core/base/machine_memory.h"
#include "core/many_lights/clamp_distance.h"
#include "core/many_lights/frame_memory.h"
#include "core/many_lights/light_paths.h"

namespace core::many_lights {

namespace {

constexpr uint32_t kPilotPaths = 1024;
constexpr uint32_t kTile = 16;
/// Lengths that stand for a unit of a normal, over the scene's radius: for slices the thesis's, for
/// lights a size below which neighbours may well belong to different surfaces.
constexpr float kSliceNormals = 0.05f, kLightNormals = 0.02f;

uint32_t treeSeed(const FrameSettings& settings, uint32_t frame)
{
    return shared::hashUint(settings.path.seed ^ shared::hashUint(frame));
}

/// The tree over the lights that are there; false when `stop` came first.
bool makeTree(const Accel& accel, uint32_t seed, const std::stop_token& stop, FrameLights& lights)
{
    const Clock::time_point start = Clock::now();
    std::optional<LightTree> made =
        makeLightTree(lights.set.lights, {kLightNormals * accel.world().radius, seed}, stop);
    if (!made) return false;
    lights.tree = *std::move(made);
    lights.treeSeconds = secondsSince(start);
    return true;
}

ReceiverJob receiverJob(const Accel& accel, const FrameSettings& settings, uint32_t frame)
{
    return {&accel, settings.path, settings.camera, settings.side, frame, settings.centred};
}

/// Throws an Error when the machine does not hold a point for each cell of the picture, or their
/// places have no numbers.
void requireReceivers(const ReceiverJob& job)
{
    const shared::PathSettings& path = job.settings;
    const double places = double(path.imageWidth) * path.imageHeight * job.side * job.side;
    // What is seen directly, the light, and the places while slices are made.
    constexpr double kBytes = sizeof(Receiver) + 2 * sizeof(glm::vec3) + 2 * sizeof(uint32_t);
    const std::string what = "a sample of " + std::to_string(path.imageWidth) + "x" +
                             std::to_string(path.imageHeight) + " with " +
                             std::to_string(job.side * job.side) + " points per pixel";
    const std::string remedy = "ask for fewer points (--receivers) or a smaller picture";
    requireMemory(kBytes * places, what, remedy);
    constexpr double kMostPlaces = 0x1p32;
    if (places < kMostPlaces) return;
    throw Error(what + " has more than " + std::to_string(~0u) + " points — " + remedy,
                ExitCode::commandLine);
}

/// Adds the receivers to `out`, pixel by pixel in tiles. False when `stop` came first.
bool findReceivers(const ReceiverJob& job, const std::stop_token& stop, FrameReceivers& out)
{
    requireReceivers(job);
    const shared::PathSettings& path = job.settings;
    const size_t perPixel = size_t(job.side) * job.side,
                 places = size_t(path.imageWidth) * path.imageHeight * perPixel;
    out.direct.assign(places, glm::vec3(0));
    out.receivers.resize(places);
    // Each tile writes to a part of its own, as long as it has places.
    struct Part {
        size_t first = 0, count = 0;
    };
    const uint32_t perRow = (path.imageWidth + kTile - 1) / kTile;
    std::vector<Part> parts(size_t(perRow) * ((path.imageHeight + kTile - 1) / kTile));
    std::atomic<uint64_t> rays = 0;
    const bool whole = parallelTiles(
        path.imageWidth, path.imageHeight, kTile,
        [&](const Tile& tile) {
            const FlushDenormals flush;
            static thread_local std::vector<Receiver> found;
            found.clear();
            rays += traceReceivers(job, tile, found, out.direct);
            const size_t before =
                size_t(tile.y0) * path.imageWidth + size_t(tile.x0) * (tile.y1 - tile.y0);
            parts[size_t(tile.y0 / kTile) * perRow + tile.x0 / kTile] = {before * perPixel,
                                                                         found.size()};
            std::ranges::copy(found, out.receivers.begin() + std::ptrdiff_t(before * perPixel));
        },
        stop);
    auto end = out.receivers.begin();
    for (const Part& part : parts) {
        const auto first = out.receivers.begin() + std::ptrdiff_t(part.first);
        end = std::copy(first, first + std::ptrdiff_t(part.count), end);
    }
    out.receivers.erase(end, out.receivers.end());
    out.rays = rays;
    return whole;
}

}  // namespace

LightPlan planLights(const Accel& accel, const FrameSettings& settings)
{
    const LightSet pilot = *traceVirtualLights(accel, settings.path, kPilotFrame, kPilotPaths);
    LightPlan plan;
    if (pathsPlaceLights(accel.world(), settings.path.maxDepth))
        plan.paths = pathsForLights(pilot, settings.lights);
    if (plan.paths > 0) plan.bytes = lightBytes(settings, pilot);
    if (settings.clamp > 0) plan.clampDistance = settings.clamp * clampDistance(accel, pilot);
    return plan;
}

std::shared_ptr<const FrameLights> makeFrameLights(const Accel& accel,
                                                   const FrameSettings& settings,
                                                   const LightPlan& plan, uint32_t frame,
                                                   const std::stop_token& stop)
{
    requireLights(settings, plan);
    const auto lights = std::make_shared<FrameLights>();
    const Clock::time_point start = Clock::now();
    std::optional<LightSet> set = traceVirtualLights(accel, settings.path, frame, plan.paths, stop);
    if (!set) return nullptr;
    lights->set = *std::move(set);
    lights->lightSeconds = secondsSince(start);
    if (!makeTree(accel, treeSeed(settings, frame), stop, *lights)) return nullptr;
    return lights;
}

std::shared_ptr<const FrameLights> withOtherTree(const Accel& accel, const FrameLights& from,
                                                 uint32_t seed, const std::stop_token& stop)
{
    const auto lights = std::make_shared<FrameLights>();
    lights->set = from.set;
    lights->lightSeconds = from.lightSeconds;
    if (!makeTree(accel, shared::hashUint(seed), stop, *lights)) return nullptr;
    return lights;
}

std::shared_ptr<const FrameReceivers> makeFrameReceivers(const Accel& accel,
                                                         const FrameSettings& settings,
                                                         uint32_t frame,
                                                         const std::stop_token& stop)
{
    const Clock::time_point start = Clock::now();
    const auto points = std::make_shared<FrameReceivers>();
    if (!findReceivers(receiverJob(accel, settings, frame), stop, *points)) return nullptr;
    points->slicing.normalScale = kSliceNormals * accel.world().radius;
    points->slicing.threshold = settings.sliceSize;
    points->slices = makeSlices(points->receivers, points->slicing, stop);
    if (stop.stop_requested()) return nullptr;
    points->seconds = secondsSince(start);
    return points;
}

std::unique_ptr<Frame> Frame::begin(const Accel& accel, const FrameSettings& settings,
                                    const LightPlan& plan,
                                    std::shared_ptr<const FrameLights> lights,
                                    std::shared_ptr<const FrameReceivers> receivers, uint32_t index,
                                    const std::stop_token& stop, const PixelDone& done)
{
    CHECK(lights != nullptr && receivers != nullptr);
    size_t mostRows = 0;
    for (const IndexRange& range : receivers->slices.ranges)
        mostRows = std::max<size_t>(mostRows, range.size());
    requireSlices(settings, lights->set.lights.size(), mostRows);
    std::unique_ptr<Frame> frame(new Frame);
    frame->lights_ = std::move(lights);
    frame->points_ = std::move(receivers);
    frame->perPixel_ = settings.side * settings.side;
    SliceJob& job = frame->job_;
    job.receivers = receiverJob(accel, settings, index);
    job.lights = &frame->lights_->set;
    job.gather = {settings.path.maxDepth, plan.clampDistance};
    job.shape = choosesColumns(settings.technique) ? settings.shape : LightShape::point;
    job.aloneRadius = plan.clampDistance;
    job.completion = settings.completion;
    job.compensates = settings.compensates;
    job.packets = settings.packets;
    FrameStats& stats = frame->stats_;
    stats.lights = frame->lights_->set.lights.size();
    stats.lightsDropped = frame->lights_->set.dropped;
    stats.lightRays = frame->lights_->set.rays;
    stats.cameraRays = frame->points_->rays;
    stats.lightSeconds = frame->lights_->lightSeconds;
    stats.treeSeconds = frame->lights_->treeSeconds;
    stats.receiverSeconds = frame->points_->seconds;
    if (!frame->makeReady(settings, stop)) return nullptr;
    // What lights with extent send is bounded by that. Columns are chosen by the clamp all the
    // same.
    if (job.shape != LightShape::point) job.gather.clampDistance = 0;
    frame->radiance_ = frame->points_->direct;
    frame->sliceDone_.assign(frame->slices().ranges.size(), 0);
    frame->sliceStats_.resize(frame->slices().ranges.size());
    frame->countPending();
    for (size_t pixel = 0; pixel < frame->pending_.size(); ++pixel)
        if (frame->pending_[pixel] == 0) frame->finishPixel(pixel, done);
    return frame;
}

/// What the technique needs before the first slice.
bool Frame::makeReady(const FrameSettings& settings, const std::stop_token& stop)
{
    const Clock::time_point start = Clock::now();
    const TechniqueInput input{job_,          lights_->tree,    points_->receivers,
                               slices(),      points_->slicing, settings.clusters,
                               settings.error};
    technique_ = makeTechnique(settings.technique, input, stop, stats_.techniqueRays);
    job_.columns = technique_.columns.get();
    job_.lighter = technique_.lighter.get();
    stats_.techniqueSeconds = secondsSince(start);
    return !stop.stop_requested() && (job_.columns != nullptr || job_.lighter != nullptr);
}

void Frame::keepOnly(std::span<const uint8_t> slices)
{
    CHECK(slices.size() == sliceDone_.size() && slicesDone_ == 0);
    for (size_t slice = 0; slice < slices.size(); ++slice)
        if (slices[slice] == 0) {
            sliceDone_[slice] = 1;
            ++slicesDone_;
        }
}

void Frame::countPending()
{
    pending_ = std::vector<std::atomic<uint8_t>>(radiance_.size() / perPixel_);
    for (const Receiver& r : points_->receivers) ++pending_[r.place / perPixel_];
}

bool Frame::advance(Clock::time_point start, double seconds, const std::stop_token& stop,
                    const PixelDone& done, BatchSum* device)
{
    std::stop_source over;
    const std::stop_callback passOn(stop, [&over] { over.request_stop(); });
    std::optional<SliceQueue> queue;
    if (device != nullptr && job_.lighter == nullptr)  // kernels sum columns
        queue.emplace(*device, sumRules(job_), stop, [&](const PendingSlice& slice) {
            finishSlice(slice.slice, slice.radiance, slice.stats, done);
        });
    parallelFor(
        slices().ranges.size(), 1,
        [&](size_t slice, size_t) {
            if (sliceDone_[slice] != 0) return;
            const FlushDenormals flush;
            static thread_local SliceWorker worker;
            const std::span<const uint32_t> chosen = receiversOf(slice);
            const auto index = static_cast<uint32_t>(slice);
            if (queue) {
                if (!worker.run(job_, points_->receivers, chosen, index, stop, *queue))
                    over.request_stop();
            } else if (worker.run(job_, points_->receivers, chosen, index, stop)) {
                finishSlice(slice, worker.radiance(), worker.stats(), done);
            }
            if (secondsSince(start) >= seconds) over.request_stop();
        },
        over.get_token());
    if (queue) stats_.deviceSeconds += queue->finish();
    return slicesDone_ == slices().ranges.size();
}

void Frame::finishSlice(size_t slice, std::span<const glm::vec3> radiance, const SliceStats& stats,
                        const PixelDone& done)
{
    const std::span<const uint32_t> chosen = receiversOf(slice);
    for (size_t i = 0; i < chosen.size(); ++i) {
        const Receiver& receiver = points_->receivers[chosen[i]];
        radiance_[receiver.place] += radiance[i] * receiver.throughput;
    }
    // The last of a pixel's receivers sees what other threads have written of the others.
    for (const uint32_t r : chosen) {
        const size_t pixel = points_->receivers[r].place / perPixel_;
        if (pending_[pixel].fetch_sub(1) == 1) finishPixel(pixel, done);
    }
    sliceStats_[slice] = stats;
    sliceDone_[slice] = 1;
    const std::lock_guard lock(mutex_);
    stats_.slices += stats;
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
    CHECK(of.size() == slices().ranges.size());
    std::vector<float> values(pending_.size()), counts(pending_.size());
    for (size_t slice = 0; slice < of.size(); ++slice)
        for (uint32_t i = slices().ranges[slice].begin; i < slices().ranges[slice].end; ++i) {
            const size_t pixel = points_->receivers[slices().order[i]].place / perPixel_;
            values[pixel] += of[slice];
            counts[pixel] += 1;
        }
    for (size_t pixel = 0; pixel < values.size(); ++pixel)
        if (counts[pixel] > 0) values[pixel] /= counts[pixel];
    return values;
}

}  // namespace core::many_lights
