// Progressive path tracing: batches of paths (path_batches.h) go to the film (film.h), tile by tile
// in rounds in which every pixel gets the same number of samples. A round that is cut short goes on
// where it was; meanwhile the weights in the film tell which pixels are ahead.
#include "app/gpu/methods/path.h"

#include <algorithm>
#include <functional>

#include "app/gpu/film.h"
#include "app/gpu/first_hits.h"
#include "app/gpu/path_batches.h"
#include "core/base/time.h"
#include "core/methods/path_params.h"

namespace gpu {

namespace {

shared::FrameData frameOf(const core::World& world, const GpuScene& scene, const core::View& view,
                          const core::PathParams& params)
{
    shared::FrameData frame{};
    frame.settings = core::worldSettings(world);
    frame.settings.seed = params.seed;
    frame.settings.samplerKind = static_cast<uint32_t>(params.sampler);
    frame.settings.strategy = static_cast<uint32_t>(params.strategy);
    frame.settings.maxDepth = params.maxDepth;
    frame.settings.rouletteDepth = params.rouletteDepth;
    frame.settings.clampIndirect = params.clampIndirect;
    frame.settings.imageWidth = view.size.x;
    frame.settings.imageHeight = view.size.y;
    frame.camera = core::cameraData(view.camera, view.size.x, view.size.y);
    frame.gridLow = scene.gridLow();
    frame.gridScale = scene.gridScale();
    frame.tilesPerRow = (view.size.x + 7) / 8;
    return frame;
}

/// Mean, variance of the mean (as core::Film::varianceOfMean) and weight of one pixel.
void storePixel(const shared::FilmPixel& p, size_t pixel, core::Estimate& estimate)
{
    const double n = double(p.weight);
    estimate.weight.pixels[pixel] = p.weight;
    if (n == 0) return;
    const glm::dvec3 mean = (glm::dvec3(p.sum) - glm::dvec3(p.sumLost)) / n;
    const glm::dvec3 squares = (glm::dvec3(p.squares) - glm::dvec3(p.squaresLost)) / n;
    for (int k = 0; k < 3; ++k) {
        const size_t i = 3 * pixel + size_t(k);
        estimate.mean.pixels[i] = static_cast<float>(mean[k]);
        if (n > 1) {
            estimate.variance.pixels[i] =
                static_cast<float>(std::max(squares[k] - mean[k] * mean[k], 0.0) / (n - 1));
        }
    }
}

class PathRenderer final : public core::Renderer {
public:
    explicit PathRenderer(std::shared_ptr<Context> context)
        : context_(std::move(context)), frame_(context_->device, context_->layouts),
          film_(*context_), firstHits_(*context_), batches_(*context_)
    {
        stats_.device = context_->device.info().name;
        stats_.driver = context_->device.info().driver;
    }

    void setWorld(std::shared_ptr<const core::World> world, const core::Progress& progress) override
    {
        std::unique_ptr<GpuScene> scene = std::move(scene_);  // gone if this throws
        const bool pose = scene && core::sameTopology(*world_, *world);
        world_.reset();
        begin();
        if (pose) {
            scene->setWorld(*world, progress);
        } else {
            scene.reset();  // two scenes at once might not fit
            batches_.forgetScene();
            scene =
                std::make_unique<GpuScene>(context_->device, context_->layouts, *world, progress);
        }
        scene_ = std::move(scene);
        world_ = std::move(world);
        stats_.buildSeconds = scene_->buildSeconds();
    }

    /// A path keeps nothing of the view before.
    void setView(const core::View& view, core::Start) override
    {
        CHECK(world_ != nullptr && view.size.x > 0 && view.size.y > 0);
        begin();
        const core::PathParams& params = view.params.as<core::PathParams>();
        frame_.write(frameOf(*world_, *scene_, view, params));
        PathWork work{scene_.get(),    &frame_,       {},
                      params.strategy, params.kernel, world_->triangles.size()};
        work.constants.features = scene_->features();
        if (view.camera.apertureRadius > 0) work.constants.features |= shared::kFeatureThinLens;
        work.constants.sampler = static_cast<uint32_t>(params.sampler);
        film_.reset(frame_);
        counts_ = {};
        stats_.renderSeconds = 0;
        batches_.makeRoom(frame_);
        film_.setRadiance(batches_.radiance());
        stats_.compileSeconds += batches_.prepare(work, accumulate_);
        frame_.clearCounters();
        ready_ = true;
    }

    void setPace(const core::Pace& pace) override { pace_ = pace; }

    void advance(const core::Budget& budget, std::stop_token stop) override
    {
        CHECK(ready_);
        const auto start = core::Clock::now();
        const auto over = [&] {
            return stop.stop_requested() || core::secondsSince(start) >= budget.seconds;
        };
        const uint64_t end = samples_ + budget.samples;
        const bool cut = roundSamples_ > 0;
        bool goes = !stop.stop_requested() && (!cut || advanceRound(over));
        for (bool first = !cut; goes && samples_ < end; first = false) {
            if (!first && over()) break;
            batches_.chooseKernel(pace_.dispatchSeconds);
            roundSamples_ = static_cast<uint32_t>(std::clamp<uint64_t>(
                lanesNow() / (shared::kGroupSize * frame_.tileCount()), 1, end - samples_));
            goes = advanceRound(over);
        }
        stats_.renderSeconds += core::secondsSince(start);
    }

    core::RenderProgress progress() const override
    {
        const uint32_t tiles = frame_.tileCount();
        return {version_, samples_, tiles > 0 ? double(nextTile_) / double(tiles) : 0};
    }

    core::Estimate read(core::Reading what) override
    {
        CHECK(ready_);
        const auto start = core::Clock::now();
        const uint32_t width = frame_.width(), height = frame_.height();
        core::Estimate estimate;
        estimate.mean = core::Image(width, height, 3);
        estimate.samples = samples_;
        estimate.counters = counts_.film;
        if (what == core::Reading::everything) {
            estimate.variance = core::Image(width, height, 3);
            estimate.weight = core::Image(width, height, 1);
            film_.read(
                [&estimate](size_t i, const shared::FilmPixel& p) { storePixel(p, i, estimate); });
        } else {
            film_.readMean(estimate.mean);
        }
        stats_.readbackSeconds += core::secondsSince(start);
        return estimate;
    }

    core::Aovs aovs() override
    {
        CHECK(ready_);
        return firstHits_.find(*scene_, frame_, pace_.dispatchSeconds);
    }

    core::RenderStats stats() const override
    {
        core::RenderStats stats = stats_;
        stats.details = {{"kernel", std::string(batches_.kernelName())}};
        stats.rays = counts_.rays;
        stats.paths = samples_ * frame_.width() * frame_.height() +
                      uint64_t(nextTile_) * roundSamples_ * shared::kGroupSize;
        stats.peakDeviceBytes = context_->device.peakBytes;
        return stats;
    }

private:
    /// Nothing is rendered, and nothing can be until a view has been taken.
    void begin()
    {
        ready_ = false;
        samples_ = 0;
        roundSamples_ = nextTile_ = 0;
        ++version_;
    }

    uint32_t lanesNow() const { return batches_.lanes(pace_.dispatchSeconds); }

    /// Adds the round's samples to every pixel that has not had them, in batches of tiles. When it
    /// is `over` between two batches, the other tiles are left for later: returns whether none is
    /// left.
    bool advanceRound(const std::function<bool()>& over)
    {
        const uint32_t tiles = frame_.tileCount();
        while (nextTile_ < tiles) {
            const uint32_t most = lanesNow() / (shared::kGroupSize * roundSamples_);
            const uint32_t count = std::min(std::max(most, 1u), tiles - nextTile_);
            batches_.trace({nextTile_, count, static_cast<uint32_t>(samples_), roundSamples_},
                           accumulate_);
            nextTile_ += count;
            ++version_;
            if (nextTile_ < tiles && over()) {
                frame_.drainCounters(counts_);
                return false;
            }
        }
        samples_ += roundSamples_;
        roundSamples_ = nextTile_ = 0;
        frame_.drainCounters(counts_);
        return true;
    }

    std::shared_ptr<Context> context_;  // first: everything below is made on its device
    Frame frame_;
    Film film_;
    FirstHits firstHits_;
    PathBatches batches_;
    std::unique_ptr<GpuScene> scene_;
    std::shared_ptr<const core::World> world_;
    core::Pace pace_;
    const PathBatches::Then accumulate_ = [this](VkCommandBuffer commands,
                                                 const shared::Batch& batch) {
        film_.accumulate(commands, frame_, batch);
    };
    bool ready_ = false;
    uint64_t samples_ = 0, version_ = 0;
    // The round under way: its samples (0: none) and the first tile that has not had them.
    uint32_t roundSamples_ = 0, nextTile_ = 0;
    core::RenderStats stats_;
    FrameCounts counts_;
};

}  // namespace

std::unique_ptr<core::Renderer> makePathRendererOn(std::shared_ptr<Context> context)
{
    return std::make_unique<PathRenderer>(std::move(context));
}

std::unique_ptr<core::Renderer> makePathRenderer(const DeviceOptions& options)
{
    return makePathRendererOn(std::make_shared<Context>(options));
}

}  // namespace gpu
