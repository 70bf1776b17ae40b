// The path tracer on all cores: reference for every other renderer, and `--device cpu`. The
// estimator is that of shaders/shared/path.h; a sample depends on seed, pixel and index alone, and
// a pixel adds its samples in their order, so neither threads nor the sizes of steps change a bit
// of the image.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>

#include <pmmintrin.h>
#include <xmmintrin.h>

#include "core/base/check.h"
#include "core/methods/methods.h"
#include "core/methods/path_aovs.h"
#include "core/methods/path_kernel.h"
#include "core/trace/scene_view.h"

namespace core {

std::span<const PathVariant> pathVariants()
{
    using namespace shared;
    static constexpr PathVariant kVariants[] = {
        {"flat", kFeatureEmissiveTriangles | kFeatureManyEmitters, renderFlatTile},
        {"any", 0xffffffffu, renderAnyTile},
    };
    return kVariants;
}

namespace {

/// Denormals count as zero while it lives, as on GPUs and as Embree asks for.
class FlushDenormals {
public:
    FlushDenormals() : before_(_mm_getcsr())
    {
        _mm_setcsr(before_ | _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON);
    }
    ~FlushDenormals() { _mm_setcsr(before_); }
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;

private:
    unsigned before_;
};

shared::PathSettings settingsFor(const World& world, const PathParams& params, uint32_t width,
                                 uint32_t height)
{
    shared::PathSettings s = worldSettings(world);
    s.seed = params.seed;
    s.samplerKind = static_cast<uint32_t>(params.sampler);
    s.strategy = static_cast<uint32_t>(params.strategy);
    s.maxDepth = params.maxDepth;
    s.rouletteDepth = params.rouletteDepth;
    s.clampIndirect = params.clampIndirect;
    s.imageWidth = width;
    s.imageHeight = height;
    return s;
}

class PathTracer : public Renderer {
public:
    void setWorld(std::shared_ptr<const World> world, const Progress& progress) override
    {
        accel_.reset();  // frees the old hierarchy before the new one is built
        film_.reset(film_.width, film_.height);
        accel_ = std::make_unique<Accel>(std::move(world), progress);
        stats_.buildSeconds = accel_->stats().buildSeconds;
        forgetWork();
    }

    void setView(const Camera& camera, uint32_t width, uint32_t height,
                 const PathParams& params) override
    {
        camera_ = camera;
        params_ = params;
        film_.reset(width, height);
        discarded_ = false;
        forgetWork();
    }

    void advance(uint32_t samples, std::stop_token stop) override
    {
        CHECK(accel_ != nullptr);
        const auto start = std::chrono::steady_clock::now();
        const uint64_t pixels = uint64_t(film_.width) * film_.height;
        const uint32_t step = static_cast<uint32_t>(
            std::clamp<uint64_t>((1u << 20) / std::max<uint64_t>(pixels, 1), 1, 64));
        CHECK(!discarded_);  // a stop has left the film to the next setView
        for (uint32_t done = 0; done < samples && !stop.stop_requested();) {
            const uint32_t count = std::min(step, samples - done);
            if (!renderPass(count, stop)) break;
            done += count;
        }
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        stats_.renderSeconds += seconds.count();
    }

    uint64_t samples() const override { return discarded_ ? 0 : film_.samples; }

    /// Pieces are tiles, far below any wish; what matters is whether the film is kept for a stop.
    void setPace(const Pace& pace) override { discardOnStop_ = pace.discardOnStop; }
    void readFilm(Film& film) override { film = film_; }
    void readMean(Image& mean) override { mean = film_.mean(); }

    Aovs aovs() override
    {
        CHECK(accel_ != nullptr);
        return traceAovs(*accel_, cameraData(camera_, film_.width, film_.height), film_.width,
                         film_.height);
    }

    RenderStats stats() const override
    {
        RenderStats s = stats_;
        s.device = "cpu";
        s.driver = "Embree";
        s.kernel = accel_ ? variant().name : "";
        return s;
    }

private:
    void forgetWork()
    {
        stats_.renderSeconds = 0;
        stats_.rays = stats_.paths = 0;
    }

    /// The least able kernel that knows everything the scene and the camera hold.
    const PathVariant& variant() const
    {
        uint32_t needed = accel_->world().features & ~shared::kFeatureThinLens;
        if (camera_.apertureRadius > 0) needed |= shared::kFeatureThinLens;
        for (const PathVariant& v : pathVariants()) {
            if ((needed & ~v.features) == 0) return v;
        }
        return pathVariants().back();
    }

    /// Adds `count` samples to every pixel. When stopped, returns false: the film is as it was, or,
    /// at a pace that allows it, no film any more.
    bool renderPass(uint32_t count, std::stop_token stop)
    {
        PathJob job;
        job.accel = accel_.get();
        job.scene = sceneView(accel_->world());
        job.settings = settingsFor(accel_->world(), params_, film_.width, film_.height);
        job.camera = cameraData(camera_, film_.width, film_.height);
        job.firstSample = static_cast<uint32_t>(film_.samples);
        job.sampleCount = count;
        const PathKernel kernel = variant().kernel;
        if (stop.stop_possible() && !discardOnStop_) before_ = film_;
        std::mutex mutex;
        PathTally total;
        const auto body = [&](const Tile& tile) {
            const FlushDenormals flush;
            const PathTally tally = kernel(job, tile, film_);
            const std::lock_guard lock(mutex);
            total.rays += tally.rays;
            total.counters.nan += tally.counters.nan;
            total.counters.inf += tally.counters.inf;
            total.counters.negative += tally.counters.negative;
        };
        if (!parallelTiles(film_.width, film_.height, kPathTile, body, stop)) {
            if (discardOnStop_) {
                discarded_ = true;
            } else {
                std::swap(film_, before_);
            }
            return false;
        }
        film_.samples += count;
        film_.counters.nan += total.counters.nan;
        film_.counters.inf += total.counters.inf;
        film_.counters.negative += total.counters.negative;
        stats_.rays += total.rays;
        stats_.paths += uint64_t(count) * film_.width * film_.height;
        return true;
    }

    std::unique_ptr<Accel> accel_;
    Camera camera_;
    PathParams params_;
    Film film_;
    Film before_;  // the film at the last pass's start
    bool discardOnStop_ = false, discarded_ = false;
    RenderStats stats_;
};

}  // namespace

std::unique_ptr<Renderer> makePathTracer()
{
    return std::make_unique<PathTracer>();
}

}  // namespace core
