// Progressive path tracing in batches of lanes. Two ways to run a batch: one kernel per bounce with
// the surviving paths closed up in between (Laine, Karras, Aila, "Megakernels Considered Harmful",
// 2013, with the stages fused), or one kernel for whole paths. Both run the same text in the same
// order per path and give the same image. Batches are sized by the time that the last ones took
// (batch_pace.h), so that no submission holds the device for long.
#include "app/gpu/methods/path_renderer.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/base/time.h"
#include "spirv/accumulate.h"
#include "spirv/aov.h"
#include "spirv/bounce.h"
#include "spirv/mean.h"
#include "spirv/megakernel.h"

namespace gpu {

namespace {

constexpr uint32_t kMaxLanes = 1u << 18;
// Mesa's software device ends every loop of an invocation after 65,535 iterations in all, silently:
// a whole path must stay below. Its bounces are invocations of their own in the other kernel.
constexpr uint32_t kDeepestMegakernel = 32;
constexpr uint32_t kMeasuredLanes = 1u << 14;
constexpr uint64_t kLanesBeforeMeasuring = 1u << 21;  // a second kernel has to be compiled for it
constexpr uint32_t kBouncesPerSubmit = 16;  // then the host looks whether any path is left

}  // namespace

PathRenderer::PathRenderer(const DeviceOptions& options)
    : device_(options),
      layout_(device_), bindings_{Bindings(device_, layout_), Bindings(device_, layout_)},
      accumulate_(device_, layout_, k_accumulate, {}), mean_(device_, layout_, k_mean, {}),
      queues_(device_, "the queues", (kBouncesPerSubmit + 2) * sizeof(shared::QueueHead)),
      frameBuffer_(device_, "the frame's settings", sizeof(shared::FrameData)),
      counters_(device_, "the counters", sizeof(shared::Counters))
{
    bindAll(shared::kBindFrame, frameBuffer_);
    bindAll(shared::kBindQueues, queues_);
    bindAll(shared::kBindCounters, counters_);
    stats_.device = device_.info().name;
    stats_.driver = device_.info().driver;
}

void PathRenderer::bindAll(uint32_t binding, const Buffer& buffer)
{
    for (Bindings& bindings : bindings_) bindings.bind(binding, buffer);
}

void PathRenderer::setWorld(std::shared_ptr<const core::World> world,
                            const core::Progress& progress)
{
    scene_.reset();  // two scenes at once might not fit
    world_.reset();
    current_ = nullptr;
    samples_ = 0;
    roundSamples_ = nextTile_ = 0;
    ++version_;
    choices_.clear();
    batchPace_.restart();
    scene_ = std::make_unique<GpuScene>(device_, *world, progress);
    world_ = std::move(world);
    for (Bindings& bindings : bindings_) scene_->bind(bindings);
    stats_.buildSeconds = scene_->buildSeconds();
}

/// A path keeps nothing of the view before.
void PathRenderer::setView(const core::View& view, core::Start)
{
    const core::Camera& camera = view.camera;
    const uint32_t width = view.size.x, height = view.size.y;
    CHECK(world_ != nullptr && width > 0 && height > 0);
    current_ = nullptr;  // until everything below has been had
    params_ = view.params.as<core::PathParams>();
    const core::PathParams& params = params_;
    frame_ = {};
    frame_.settings = core::worldSettings(*world_);
    frame_.settings.seed = params.seed;
    frame_.settings.samplerKind = static_cast<uint32_t>(params.sampler);
    frame_.settings.strategy = static_cast<uint32_t>(params.strategy);
    frame_.settings.maxDepth = params.maxDepth;
    frame_.settings.rouletteDepth = params.rouletteDepth;
    frame_.settings.clampIndirect = params.clampIndirect;
    frame_.settings.imageWidth = width;
    frame_.settings.imageHeight = height;
    frame_.camera = core::cameraData(camera, width, height);
    frame_.gridLow = scene_->gridLow();
    frame_.gridScale = scene_->gridScale();
    frame_.tilesPerRow = (width + 7) / 8;
    frameBuffer_.write(std::as_bytes(std::span(&frame_, 1)));

    Specialization wanted;
    wanted.features = scene_->features();
    if (camera.apertureRadius > 0) wanted.features |= shared::kFeatureThinLens;
    wanted.sampler = static_cast<uint32_t>(params.sampler);
    makeBuffers();
    const auto [entry, fresh] = kernels_.try_emplace(wanted);
    if (fresh) {
        batchPace_.restart();
    } else {
        batchPace_.again();
    }
    stats_.rays = 0;
    stats_.renderSeconds = 0;
    const bool small = uint64_t(width) * height < kMeasuredLanes;
    choice_ = &choices_[{wanted, params.maxDepth, params.strategy, small}];
    choice_->lanes = 0;
    kernelsNow_ = &entry->second;
    specialization_ = wanted;
    const auto start = core::Clock::now();
    takeChoice();
    const auto which = wavefront_ ? &Kernels::bounce : &Kernels::megakernel;
    const bool missing = (kernelsNow_->*which).get() == VK_NULL_HANDLE;
    kernel(which);
    if (missing) stats_.compileSeconds += core::secondsSince(start);
    current_ = kernelsNow_;
}

void PathRenderer::makeBuffers()
{
    const uint64_t pixels = uint64_t(frame_.settings.imageWidth) * frame_.settings.imageHeight;
    // Powers of two: few sizes in all, as a new one makes Mesa's software device compile the
    // kernels again.
    const uint32_t lanes =
        std::bit_ceil(std::clamp(tileCount() * shared::kGroupSize, 1u << 16, kMaxLanes));
    if (radiance_.bytes() < lanes * sizeof(glm::vec4)) {
        radiance_ = {};  // first: its size tells whether all of these could be had
        for (uint32_t i = 0; i < 2; ++i) {
            states_[i] = {};
            states_[i] = Buffer(device_, "the paths", uint64_t(lanes) * shared::kStateWords * 16,
                                texelFormat(shared::kBindStateTexels));
        }
        radiance_ = Buffer(device_, "the paths' radiance", lanes * sizeof(glm::vec4));
        bindAll(shared::kBindRadiance, radiance_);
        for (uint32_t i = 0; i < 2; ++i) {
            bindings_[i].bind(shared::kBindStateTexels, states_[i]);
            bindings_[i].bind(shared::kBindStates, states_[1 - i]);
        }
    }
    // Larger than needed is good enough: while the camera moves, sizes change all the time.
    if (film_[2].bytes() < std::max<uint64_t>(pixels * sizeof(glm::vec4), 16)) {
        film_ = {};
        for (uint32_t i = 0; i < 3; ++i) {  // the last one tells whether all could be had
            film_[i] = Buffer(device_, "the film", pixels * sizeof(glm::vec4));
            bindAll(shared::kBindFilm0 + i, film_[i]);
        }
    }
    device_.submit(
        [&](VkCommandBuffer commands) {
            for (const Buffer& buffer : film_) {
                vk.CmdFillBuffer(commands, buffer.get(), 0, pixels * sizeof(glm::vec4), 0);
            }
            vk.CmdFillBuffer(commands, counters_.get(), 0, VK_WHOLE_SIZE, 0);
            barrier(commands);
        },
        "the clearing of the film");
    samples_ = 0;
    roundSamples_ = nextTile_ = 0;
    ++version_;
    filmCounters_ = {};
}

void PathRenderer::dispatch(VkCommandBuffer commands, const Pipeline& pipeline,
                            const Bindings& bindings, const shared::Batch& batch, uint32_t lanes)
{
    bindings.use(commands, layout_);
    vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
    vk.CmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(batch),
                        &batch);
    vk.CmdDispatch(commands, (lanes + shared::kGroupSize - 1) / shared::kGroupSize, 1, 1);
}

/// A kernel for the present view, made when it is first asked for: what a picture does not need is
/// not compiled.
const Pipeline& PathRenderer::kernel(Pipeline Kernels::*which)
{
    Pipeline& pipeline = kernelsNow_->*which;
    if (pipeline.get() == VK_NULL_HANDLE) {
        const std::span<const uint32_t> code =
            which == &Kernels::bounce       ? std::span<const uint32_t>(k_bounce)
            : which == &Kernels::megakernel ? std::span<const uint32_t>(k_megakernel)
                                            : std::span<const uint32_t>(k_aov);
        pipeline = Pipeline(device_, layout_, code, specialization_);
        warmUp(pipeline);
    }
    return pipeline;
}

/// Software drivers compile at the first dispatch: an empty batch makes them do it now.
void PathRenderer::warmUp(const Pipeline& fresh)
{
    const shared::Batch empty{0, 1, 0, 0, 0};
    device_.submit(
        [&](VkCommandBuffer commands) {
            vk.CmdFillBuffer(commands, queues_.get(), 0, VK_WHOLE_SIZE, 0);
            barrier(commands);
            for (const Pipeline* pipeline : {&fresh, static_cast<const Pipeline*>(&accumulate_)}) {
                dispatch(commands, *pipeline, bindings_[0], empty, shared::kGroupSize);
                barrier(commands);
            }
        },
        "the compilation of the kernels");
}

/// The kernel that is the right one by what is known. False when measuring could tell more.
bool PathRenderer::takeChoice()
{
    const bool tooDeep = device_.isSoftware() && params_.maxDepth > kDeepestMegakernel;
    const bool open = params_.kernel == core::Kernel::automatic && !tooDeep && params_.maxDepth > 1;
    wavefront_ = open ? choice_->wavefront : tooDeep || params_.kernel == core::Kernel::wavefront;
    stats_.details = {{"kernel", std::string(wavefront_ ? "wavefront" : "megakernel")}};
    return !open || choice_->made;
}

/// Which kernel is faster depends on the scene, the depth and the driver, so it is measured: on one
/// small batch from the middle of the image, twice, in turns, the results thrown away. Only once so
/// much has been traced of one view that it is likely to pay, and once per kind of work: neither
/// moving nor editing is held up by it.
void PathRenderer::chooseKernel()
{
    if (takeChoice() || choice_->lanes <= kLanesBeforeMeasuring) return;
    const uint32_t count = std::min({tileCount(), kMeasuredLanes / shared::kGroupSize,
                                     std::max(lanesNow() / (2 * shared::kGroupSize), 1u)});
    const shared::Batch batch{(tileCount() - count) / 2, count, 0, 1, 0};
    kernel(&Kernels::megakernel);  // its compilation is not what is measured
    double best[2] = {1e30, 1e30};
    for (int round = 0; round < 4; ++round) {
        wavefront_ = round % 2 == 0;
        best[round % 2] = std::min(best[round % 2], tracePaths(batch, false));
    }
    choice_->wavefront = best[0] <= best[1];
    choice_->made = true;
    clearCounters();
    takeChoice();
}

/// A batch in words, for the message of a device that is lost in it.
std::string PathRenderer::workOf(const char* kernel, const shared::Batch& batch) const
{
    return std::string(kernel) + " of " + std::to_string(world_->triangles.size()) +
           " triangles, tiles " + std::to_string(batch.firstTile) + " to " +
           std::to_string(batch.firstTile + batch.tileCount - 1) + " of " +
           std::to_string(tileCount()) + ", samples " + std::to_string(batch.firstSample) + " to " +
           std::to_string(batch.firstSample + batch.sampleCount - 1);
}

/// Bounces are submitted sixteen at a time; the sizes of their queues stay on the device.
double PathRenderer::traceByBounces(shared::Batch batch, bool keep)
{
    const shared::Batch whole = batch;
    const uint32_t lanes = batch.tileCount * batch.sampleCount * shared::kGroupSize;
    double seconds = 0;
    bool kept = false;
    uint32_t side = 0, waiting = lanes;
    for (uint64_t done = 0; waiting > 0 && done <= params_.maxDepth; done += kBouncesPerSubmit) {
        const auto count = static_cast<uint32_t>(
            std::min<uint64_t>(kBouncesPerSubmit, params_.maxDepth + 1 - done));
        std::array<shared::QueueHead, kBouncesPerSubmit + 1> heads;
        heads.fill({0, 1, 1, 0});
        heads[0] = {(waiting + shared::kGroupSize - 1) / shared::kGroupSize, 1, 1, waiting};
        seconds += device_.submit(
            [&](VkCommandBuffer commands) {
                vk.CmdUpdateBuffer(commands, queues_.get(), 0, sizeof(heads), heads.data());
                vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE,
                                   kernelsNow_->bounce.get());
                for (uint32_t b = 0; b < count; ++b, side = 1 - side) {
                    barrier(commands);
                    batch.bounce = b | (done + b > 0 ? shared::kBatchContinues : 0);
                    bindings_[side].use(commands, layout_);
                    vk.CmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                                        sizeof(batch), &batch);
                    vk.CmdDispatchIndirect(commands, queues_.get(), b * sizeof(shared::QueueHead));
                }
                barrier(commands);
                kept = done + count > params_.maxDepth;  // no path can be left
                if (keep && kept) accumulate(commands, whole);
            },
            workOf("bounces", whole));
        shared::QueueHead next;
        queues_.read(std::as_writable_bytes(std::span(&next, 1)), count * sizeof(next));
        waiting = next.count;
    }
    if (keep && !kept) {
        seconds += device_.submit([&](VkCommandBuffer commands) { accumulate(commands, whole); },
                                  workOf("the sum", whole));
    }
    return seconds;
}

/// Traces a batch and, if it is to be kept, adds it to the film; returns the seconds that it took.
double PathRenderer::tracePaths(const shared::Batch& batch, bool keep)
{
    kernel(wavefront_ ? &Kernels::bounce : &Kernels::megakernel);
    if (wavefront_) return traceByBounces(batch, keep);
    return device_.submit(
        [&](VkCommandBuffer commands) {
            dispatch(commands, kernelsNow_->megakernel, bindings_[0], batch,
                     batch.tileCount * batch.sampleCount * shared::kGroupSize);
            barrier(commands);
            if (keep) accumulate(commands, batch);
        },
        workOf("whole paths", batch));
}

/// The batch's radiance goes to the film.
void PathRenderer::accumulate(VkCommandBuffer commands, const shared::Batch& batch)
{
    dispatch(commands, accumulate_, bindings_[0], batch, batch.tileCount * shared::kGroupSize);
    barrier(commands);
}

uint32_t PathRenderer::lanesNow() const
{
    return batchPace_.lanes(pace_.dispatchSeconds,
                            static_cast<uint32_t>(radiance_.bytes() / sizeof(glm::vec4)));
}

core::RenderProgress PathRenderer::progress() const
{
    return {version_, samples_, tileCount() > 0 ? double(nextTile_) / double(tileCount()) : 0};
}

void PathRenderer::advance(const core::Budget& budget, std::stop_token stop)
{
    CHECK(current_ != nullptr);
    const auto start = core::Clock::now();
    const auto over = [&] {
        return stop.stop_requested() || core::secondsSince(start) >= budget.seconds;
    };
    const uint64_t end = samples_ + budget.samples;
    const bool cut = roundSamples_ > 0;
    bool goes = !stop.stop_requested() && (!cut || advanceRound(over));
    for (bool first = !cut; goes && samples_ < end; first = false) {
        if (!first && over()) break;
        chooseKernel();
        roundSamples_ = static_cast<uint32_t>(std::clamp<uint64_t>(
            lanesNow() / (shared::kGroupSize * tileCount()), 1, end - samples_));
        goes = advanceRound(over);
    }
    stats_.renderSeconds += core::secondsSince(start);
}

/// Adds the round's samples to every pixel that has not had them, in batches of tiles. When it is
/// `over` between two batches, the other tiles are left for later: returns whether none is left.
bool PathRenderer::advanceRound(const std::function<bool()>& over)
{
    const uint32_t tiles = tileCount();
    while (nextTile_ < tiles) {
        const uint32_t count = std::min(
            std::max(lanesNow() / (shared::kGroupSize * roundSamples_), 1u), tiles - nextTile_);
        const shared::Batch batch{nextTile_, count, static_cast<uint32_t>(samples_), roundSamples_,
                                  0};
        const double seconds = tracePaths(batch, true);
        const uint32_t lanes = count * roundSamples_ * shared::kGroupSize;
        batchPace_.measured(lanes, seconds);
        choice_->lanes += lanes;
        nextTile_ += count;
        ++version_;
        if (nextTile_ < tiles && over()) {
            drainCounters();
            return false;
        }
    }
    samples_ += roundSamples_;
    roundSamples_ = nextTile_ = 0;
    drainCounters();
    return true;
}

/// Moves the device's 32-bit counts to the host's 64-bit ones.
void PathRenderer::drainCounters()
{
    shared::Counters counts;
    counters_.read(std::as_writable_bytes(std::span(&counts, 1)));
    clearCounters();
    filmCounters_ += {counts.nan, counts.inf, counts.negative, counts.stackOverflow};
    stats_.rays += uint64_t(counts.closestRays) + counts.shadowRays;
}

void PathRenderer::clearCounters()
{
    const shared::Counters zero{};
    counters_.write(std::as_bytes(std::span(&zero, 1)));
}

std::unique_ptr<core::Renderer> makePathRenderer(const DeviceOptions& options)
{
    return std::make_unique<PathRenderer>(options);
}

}  // namespace gpu
