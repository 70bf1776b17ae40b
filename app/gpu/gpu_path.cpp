// Progressive path tracing in batches of lanes. Two ways to run a batch: one kernel per bounce with the surviving
// paths closed up in between (Laine, Karras, Aila, "Megakernels Considered Harmful", 2013, with the stages fused), or one
// kernel for whole paths. Both run the same text in the same order per path and give the same image.
// Batches are sized by the time that the last one took, so that no submission holds the device for long.
#include "app/gpu/gpu_path.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "app/gpu/gpu_scene.h"
#include "spirv/accumulate.h"
#include "spirv/aov.h"
#include "spirv/bounce.h"
#include "spirv/megakernel.h"

namespace gpu {

namespace {

using Clock = std::chrono::steady_clock;

double since(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

constexpr uint32_t kMaxLanes = 1u << 18;
constexpr double kTargetSeconds = 0.1;      // of one submission
// Mesa's software device ends every loop of an invocation after 65,535 iterations in all, silently: a whole path must
// stay below. Its bounces are invocations of their own in the other kernel.
constexpr uint32_t kDeepestMegakernel = 32;
constexpr uint32_t kMeasuredLanes = 1u << 14;
constexpr uint32_t kBouncesPerSubmit = 16;  // then the host looks whether any path is left

class PathRenderer final : public core::Renderer {
public:
    explicit PathRenderer(const DeviceOptions& options);

    void setWorld(std::shared_ptr<const core::World> world, const core::Progress& progress) override;
    void setView(const core::Camera& camera, uint32_t width, uint32_t height,
                 const core::PathParams& params) override;
    void advance(uint32_t samples, std::stop_token stop) override;
    uint64_t samples() const override { return samples_; }
    void setPace(const core::Pace& pace) override { pace_ = pace; }
    void readFilm(core::Film& film) override;
    core::Aovs aovs() override;
    core::RenderStats stats() const override;

private:
    struct Kernels {
        Pipeline bounce, megakernel, aov;
    };

    void makeBuffers();
    void warmUp(const Kernels& kernels);
    void chooseKernel(uint32_t samples);
    double tracePaths(const shared::Batch& batch);
    double traceByBounces(shared::Batch batch);
    double accumulate(const shared::Batch& batch);
    void dispatch(VkCommandBuffer commands, const Pipeline& pipeline, const Bindings& bindings,
                  const shared::Batch& batch, uint32_t lanes);
    void drainCounters();
    void clearCounters();
    void bindAll(uint32_t binding, const Buffer& buffer);
    uint32_t tileCount() const { return frame_.tilesPerRow * ((frame_.settings.imageHeight + 7) / 8); }

    Device device_;
    KernelLayout layout_;
    std::array<Bindings, 2> bindings_;  // they differ in which buffer of paths is read and which is written
    Pipeline accumulate_;
    std::map<Specialization, Kernels> kernels_;
    Kernels* current_ = nullptr;
    std::unique_ptr<GpuScene> scene_;
    std::shared_ptr<const core::World> world_;
    std::array<Buffer, 2> states_;
    Buffer radiance_, queues_, frameBuffer_, counters_;
    std::array<Buffer, 3> film_;
    shared::FrameData frame_{};
    core::PathParams params_;
    core::Pace pace_;
    bool wavefront_ = true, kernelChosen_ = false;
    uint64_t samples_ = 0;
    uint32_t lanesPerBatch_ = 1u << 14;
    core::RenderStats stats_;
    core::FilmCounters filmCounters_;
};

PathRenderer::PathRenderer(const DeviceOptions& options)
    : device_(options), layout_(device_), bindings_{Bindings(device_, layout_), Bindings(device_, layout_)},
      accumulate_(device_, layout_, k_accumulate, {}),
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

void PathRenderer::setWorld(std::shared_ptr<const core::World> world, const core::Progress& progress)
{
    scene_.reset();  // two scenes at once might not fit
    world_.reset();
    current_ = nullptr;
    samples_ = 0;
    scene_ = std::make_unique<GpuScene>(device_, *world, progress);
    world_ = std::move(world);
    for (Bindings& bindings : bindings_) scene_->bind(bindings);
    stats_.buildSeconds = scene_->buildSeconds();
}

void PathRenderer::setView(const core::Camera& camera, uint32_t width, uint32_t height,
                           const core::PathParams& params)
{
    CHECK(world_ != nullptr && width > 0 && height > 0);
    current_ = nullptr;  // until everything below has been had
    params_ = params;
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
    auto entry = kernels_.find(wanted);
    const bool fresh = entry == kernels_.end();
    if (fresh) {
        Kernels kernels{Pipeline(device_, layout_, k_bounce, wanted), Pipeline(device_, layout_, k_megakernel, wanted),
                        Pipeline(device_, layout_, k_aov, wanted)};
        entry = kernels_.emplace(wanted, std::move(kernels)).first;
    }
    makeBuffers();
    if (fresh) warmUp(entry->second);
    kernelChosen_ = false;
    current_ = &entry->second;
}

void PathRenderer::makeBuffers()
{
    const uint64_t pixels = uint64_t(frame_.settings.imageWidth) * frame_.settings.imageHeight;
    const uint32_t lanes = static_cast<uint32_t>(
        std::min<uint64_t>(kMaxLanes, std::max<uint64_t>(uint64_t(tileCount()) * shared::kGroupSize, 1u << 16)));
    lanesPerBatch_ = std::min(lanesPerBatch_, lanes);
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
    if (film_[2].bytes() != std::max<uint64_t>(pixels * sizeof(glm::vec4), 16)) {
        film_ = {};
        for (uint32_t i = 0; i < 3; ++i) {  // the last one tells whether all could be had
            film_[i] = Buffer(device_, "the film", pixels * sizeof(glm::vec4));
            bindAll(shared::kBindFilm0 + i, film_[i]);
        }
    }
    device_.submit([&](VkCommandBuffer commands) {
        for (const Buffer& buffer : film_) vk.CmdFillBuffer(commands, buffer.get(), 0, VK_WHOLE_SIZE, 0);
        vk.CmdFillBuffer(commands, counters_.get(), 0, VK_WHOLE_SIZE, 0);
        barrier(commands);
    });
    samples_ = 0;
    filmCounters_ = {};
}

void PathRenderer::dispatch(VkCommandBuffer commands, const Pipeline& pipeline, const Bindings& bindings,
                            const shared::Batch& batch, uint32_t lanes)
{
    bindings.use(commands, layout_);
    vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
    vk.CmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(batch), &batch);
    vk.CmdDispatch(commands, (lanes + shared::kGroupSize - 1) / shared::kGroupSize, 1, 1);
}

/// Software drivers compile at the first dispatch: an empty batch makes them do it now.
void PathRenderer::warmUp(const Kernels& kernels)
{
    const auto start = Clock::now();
    const shared::Batch empty{0, 1, 0, 0, 0};
    device_.submit([&](VkCommandBuffer commands) {
        vk.CmdFillBuffer(commands, queues_.get(), 0, VK_WHOLE_SIZE, 0);
        barrier(commands);
        const Pipeline& last = accumulate_;
        for (const Pipeline* pipeline : {&kernels.bounce, &kernels.megakernel, &kernels.aov, &last}) {
            dispatch(commands, *pipeline, bindings_[0], empty, shared::kGroupSize);
            barrier(commands);
        }
    });
    stats_.compileSeconds += since(start);
}

/// Which kernel is faster depends on the scene, the depth and the driver, so it is measured: on one batch from the
/// middle of the image, twice, in turns, the results thrown away. Not for renders that would be over as soon.
void PathRenderer::chooseKernel(uint32_t samples)
{
    kernelChosen_ = true;
    const bool tooDeep = device_.isSoftware() && params_.maxDepth > kDeepestMegakernel;
    wavefront_ = params_.kernel != core::Kernel::megakernel || tooDeep;
    const uint32_t tiles = tileCount();
    const uint32_t count = std::min(tiles, kMeasuredLanes / shared::kGroupSize);
    if (params_.kernel == core::Kernel::automatic && params_.maxDepth <= 1) wavefront_ = false;
    if (params_.kernel == core::Kernel::automatic && !tooDeep && uint64_t(samples) * tiles > 40 * uint64_t(count)) {
        const shared::Batch batch{(tiles - count) / 2, count, 0, 1, 0};
        double best[2] = {1e30, 1e30};
        for (int round = 0; round < 4; ++round) {
            wavefront_ = round % 2 == 0;
            best[round % 2] = std::min(best[round % 2], tracePaths(batch));
        }
        wavefront_ = best[0] <= best[1];
        clearCounters();
    }
    stats_.kernel = wavefront_ ? "wavefront" : "megakernel";
}

/// Bounces are submitted sixteen at a time; the sizes of their queues stay on the device.
double PathRenderer::traceByBounces(shared::Batch batch)
{
    const uint32_t lanes = batch.tileCount * batch.sampleCount * shared::kGroupSize;
    double seconds = 0;
    uint32_t side = 0, waiting = lanes;
    for (uint64_t done = 0; waiting > 0 && done <= params_.maxDepth; done += kBouncesPerSubmit) {
        const auto count = static_cast<uint32_t>(std::min<uint64_t>(kBouncesPerSubmit, params_.maxDepth + 1 - done));
        std::array<shared::QueueHead, kBouncesPerSubmit + 1> heads;
        heads.fill({0, 1, 1, 0});
        heads[0] = {(waiting + shared::kGroupSize - 1) / shared::kGroupSize, 1, 1, waiting};
        seconds += device_.submit([&](VkCommandBuffer commands) {
            vk.CmdUpdateBuffer(commands, queues_.get(), 0, sizeof(heads), heads.data());
            vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, current_->bounce.get());
            for (uint32_t b = 0; b < count; ++b, side = 1 - side) {
                barrier(commands);
                batch.bounce = b | (done + b > 0 ? shared::kBatchContinues : 0);
                bindings_[side].use(commands, layout_);
                vk.CmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(batch), &batch);
                vk.CmdDispatchIndirect(commands, queues_.get(), b * sizeof(shared::QueueHead));
            }
            barrier(commands);
        });
        shared::QueueHead next;
        queues_.read(std::as_writable_bytes(std::span(&next, 1)), count * sizeof(next));
        waiting = next.count;
    }
    return seconds;
}

/// Leaves the radiance of every lane of the batch in its buffer; returns the seconds that it took.
double PathRenderer::tracePaths(const shared::Batch& batch)
{
    if (wavefront_) return traceByBounces(batch);
    return device_.submit([&](VkCommandBuffer commands) {
        dispatch(commands, current_->megakernel, bindings_[0], batch,
                 batch.tileCount * batch.sampleCount * shared::kGroupSize);
        barrier(commands);
    });
}

double PathRenderer::accumulate(const shared::Batch& batch)
{
    return device_.submit([&](VkCommandBuffer commands) {
        dispatch(commands, accumulate_, bindings_[0], batch, batch.tileCount * shared::kGroupSize);
        barrier(commands);
    });
}

void PathRenderer::advance(uint32_t samples, std::stop_token stop)
{
    CHECK(current_ != nullptr);
    const auto start = Clock::now();
    if (!kernelChosen_) chooseKernel(samples);
    const uint32_t tiles = tileCount();
    uint32_t left = samples;
    while (left > 0 && !stop.stop_requested()) {
        const uint32_t tilesPerBatch = std::max(lanesPerBatch_ / shared::kGroupSize, 1u);
        const uint32_t perBatch = tilesPerBatch >= tiles ? std::min(tilesPerBatch / tiles, left) : 1;
        // Whole samples only: once begun, a round over all tiles is finished even when a stop is requested.
        for (uint32_t tile = 0; tile < tiles;) {
            const uint32_t count = std::min(std::max(lanesPerBatch_ / (shared::kGroupSize * perBatch), 1u), tiles - tile);
            const shared::Batch batch{tile, count, static_cast<uint32_t>(samples_), perBatch, 0};
            const double seconds = tracePaths(batch) + accumulate(batch);
            const double lanes = double(count) * perBatch * shared::kGroupSize;
            const double wanted = lanes * std::clamp(kTargetSeconds / std::max(seconds, 1e-5), 0.25, 2.0);
            const double most = double(radiance_.bytes() / sizeof(glm::vec4));
            lanesPerBatch_ = static_cast<uint32_t>(std::clamp(wanted, 4096.0, most));
            tile += count;
        }
        samples_ += perBatch;
        left -= perBatch;
        drainCounters();
    }
    stats_.renderSeconds += since(start);
}

/// Moves the device's 32-bit counts to the host's 64-bit ones.
void PathRenderer::drainCounters()
{
    shared::Counters counts;
    counters_.read(std::as_writable_bytes(std::span(&counts, 1)));
    clearCounters();
    filmCounters_.nan += counts.nan;
    filmCounters_.inf += counts.inf;
    filmCounters_.negative += counts.negative;
    filmCounters_.stackOverflow += counts.stackOverflow;
    stats_.rays += uint64_t(counts.closestRays) + counts.shadowRays;
}

void PathRenderer::readFilm(core::Film& film)
{
    const auto start = Clock::now();
    film.reset(frame_.settings.imageWidth, frame_.settings.imageHeight);
    film.samples = samples_;
    film.counters = filmCounters_;
    const size_t pixels = film.sum.size();
    std::array<std::vector<glm::vec4>, 3> words;
    for (uint32_t i = 0; i < 3; ++i) {
        words[i].resize(pixels);
        film_[i].read(std::as_writable_bytes(std::span(words[i])));
    }
    for (size_t p = 0; p < pixels; ++p) {
        const glm::dvec4 a = words[0][p], b = words[1][p], c = words[2][p];
        film.sum[p] = glm::dvec3(a.x, a.y, a.z) - glm::dvec3(a.w, b.x, b.y);
        film.sumOfSquares[p] = glm::dvec3(b.z, b.w, c.x) - glm::dvec3(c.y, c.z, c.w);
    }
    stats_.readbackSeconds += since(start);
}

core::Aovs PathRenderer::aovs()
{
    CHECK(current_ != nullptr);
    const uint32_t width = frame_.settings.imageWidth, height = frame_.settings.imageHeight;
    const Buffer output(device_, "the AOVs", uint64_t(width) * height * 3 * sizeof(glm::vec4));
    bindAll(shared::kBindOutput, output);
    const shared::Batch batch{0, tileCount(), 0, 1, 0};
    device_.submit([&](VkCommandBuffer commands) {
        dispatch(commands, current_->aov, bindings_[0], batch, batch.tileCount * shared::kGroupSize);
        barrier(commands);
    });
    std::vector<glm::vec4> words(size_t(width) * height * 3);
    output.read(std::as_writable_bytes(std::span(words)));
    for (Bindings& bindings : bindings_) bindings.unbind(shared::kBindOutput);
    core::Aovs aovs{core::Image(width, height, 1), core::Image(width, height, 3), core::Image(width, height, 3),
                    core::Image(width, height, 3)};
    for (size_t p = 0; p < size_t(width) * height; ++p) {
        const glm::vec4 a = words[3 * p], b = words[3 * p + 1], c = words[3 * p + 2];
        aovs.depth.pixels[p] = a.x;
        for (int k = 0; k < 3; ++k) {
            aovs.normal.pixels[3 * p + size_t(k)] = a[k + 1];
            aovs.albedo.pixels[3 * p + size_t(k)] = b[k];
            aovs.ids.pixels[3 * p + size_t(k)] = c[k];
        }
    }
    return aovs;
}

void PathRenderer::clearCounters()
{
    const shared::Counters zero{};
    counters_.write(std::as_bytes(std::span(&zero, 1)));
}

core::RenderStats PathRenderer::stats() const
{
    core::RenderStats stats = stats_;
    stats.paths = samples_ * frame_.settings.imageWidth * frame_.settings.imageHeight;
    stats.peakDeviceBytes = device_.peakBytes;
    return stats;
}

}  // namespace

std::unique_ptr<core::Renderer> makePathRenderer(const DeviceOptions& options)
{
    return std::make_unique<PathRenderer>(options);
}

}  // namespace gpu
