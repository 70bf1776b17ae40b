// Path tracing that keeps its samples when the camera moves, on all cores: views, passes, figures
// and maps. A pass takes new paths where they are due (reuse_estimator.h); the first one of a view
// looks at the samples of the view before. Two stores take turns: one is read, one is written, and
// they change places only after a whole pass. Once a view that rests has filled its history, the
// path tracer's kernel goes on.
#include <array>
#include <mutex>

#include "core/methods/method.h"
#include "core/methods/path_kernel.h"
#include "core/methods/path_settings.h"
#include "core/methods/reuse_estimator.h"
#include "core/methods/reuse_figures.h"
#include "core/methods/reuse_maps.h"
#include "core/methods/reuse_settings.h"
#include "core/methods/tiled_renderer.h"
#include "core/scene/moved_pieces.h"

namespace core {

namespace {

class SampleReuse : public TiledRenderer {
public:
    void setWorld(std::shared_ptr<const World> world, const Progress& progress) override
    {
        if (!before_.world || !sameTopology(*before_.world, *world)) forget();
        world_ = world;
        TiledRenderer::setWorld(std::move(world), progress);
    }

    void setView(const View& view, Start start) override
    {
        const ReuseParams last = params_;
        visibility_ = askedVisibility(last, visibility_, figures_);
        perDeviation_ = partPerDeviation(last, perDeviation_, figures_);
        samplesBefore_ += plainSamples_;
        plainSamples_ = 0;
        TiledRenderer::setView(view, start);
        passes_ = 0;
        figures_ = {};
        if (start == Start::anew || !(last == params_) || !takeMotion()) {
            forget();
            visibility_ = askedVisibility(params_, 0, {});
            perDeviation_ = 0;
        }
        if (start == Start::anew) samplesBefore_ = 0;
    }

    void advance(const Budget& budget, std::stop_token stop) override
    {
        const auto begin = Clock::now();
        for (uint32_t i = 0; i < std::max(budget.samples, 1u); ++i) {
            const double left = budget.seconds - secondsSince(begin);
            if (i > 0 && (left <= 0 || stop.stop_requested())) return;
            if (isSettled()) return takePlainPaths({budget.samples - i, left}, stop);
            const uint64_t had = film_.progress().samples;
            pass({std::min(budget.samples, 1u), left}, stop);
            if (film_.progress().samples == had) return;
        }
    }

    RenderStats stats() const override
    {
        RenderStats stats = TiledRenderer::stats();
        const std::lock_guard lock(figuresMutex_);
        // Figures are of the pass under way, too.
        const double part = isSettled() ? 0 : film_.progress().fraction;
        const double pixels = double(film_.size().x) * film_.size().y * (passes_ + part);
        stats.details = figures_.details(params_, world_ && mayMove(*world_), visibility_,
                                         recordsKept(params_), pixels, plainSamples_);
        return stats;
    }

    std::vector<Image> maps() override
    {
        if (passes_ == 0) return {};
        return makeReuseMaps(
            before_.size, static_cast<uint32_t>(params_.reuse),
            [this](size_t i) { return before_.pixels[i]; },
            [this](size_t i) { return before_.maps[i]; });
    }

private:
    void setParams(const AnyParams& params) override { params_ = params.as<ReuseParams>(); }

    /// The history, and what has moved since: a pass that was to take it up may have been cut
    /// short.
    void forget()
    {
        before_ = {};
        moved_.clear();
    }

    /// Finds what has moved since the last whole pass; false where nothing of it may be kept.
    bool takeMotion()
    {
        moved_.clear();
        if (!before_.world || before_.world == world_) return true;
        if (!followsMotion(params_)) return false;
        std::optional<std::vector<shared::MovedPiece>> moved = movedPieces(*before_.world, *world_);
        if (moved) moved_ = std::move(*moved);
        return moved.has_value();
    }

    /// Whether the history of this view has all that it can hold.
    bool isSettled() const { return passes_ >= passesOfHistory(params_); }

    void takePlainPaths(const Budget& budget, const std::stop_token& stop)
    {
        PathJob job{.accel = accel_.get(),
                    .scene = frameScene(),
                    .settings = frameSettings(),
                    .camera = frameCamera()};
        setPathSettings(plainPaths(params_), job.settings);
        const PathKernel kernel = leastAble(pathVariants(), frameFeatures()).kernel;
        const uint64_t had = film_.progress().samples;
        film_.advance(budget, stop,
                      [&](const Tile& tile, uint32_t first, uint32_t count, Film& film) {
                          PathJob part = job;
                          part.firstSample = samplesBefore_ + first - passes_;
                          part.sampleCount = count;
                          return kernel(part, tile, film);
                      });
        plainSamples_ += static_cast<uint32_t>(film_.progress().samples - had);
    }

    /// One pass over the picture, or what a budget allows of it.
    void pass(const Budget& budget, const std::stop_token& stop)
    {
        now_.reset(film_.size(), params_);
        now_.camera = frameCamera();
        now_.world = world_;
        shared::PathSettings path = frameSettings();
        setPathSettings(params_, path);
        shared::ReuseSettings settings = reuseSettings(params_);
        settings.visibility = visibility_;
        settings.flags = reuseFlags(params_, passes_, mayMove(*world_));
        const ReuseJob job = makeReuseJob(*accel_, before_, now_, moved_, path, settings,
                                          perDeviation_, samplesBefore_);
        const ReuseKernel kernel =
            leastAble(reuseVariants(), reuseFeatures(params_, frameFeatures(), mayMove(*world_)))
                .kernel;
        const uint64_t had = film_.progress().samples;
        film_.advance(budget, stop, [&](const Tile& tile, uint32_t, uint32_t, Film& film) {
            std::array<shared::ReuseSums, size_t(kFilmTile) * kFilmTile> found;
            const std::span sums =
                std::span(found).first(size_t(tile.x1 - tile.x0) * (tile.y1 - tile.y0));
            shared::ReuseTally rays{0, 0};
            kernel(job, tile, sums, rays);
            TileTally tally;
            tally.rays = uint64_t(rays.closestRays) + rays.shadowRays;
            ReuseFigures figures;
            size_t i = 0;
            for (uint32_t y = tile.y0; y < tile.y1; ++y)
                for (uint32_t x = tile.x0; x < tile.x1; ++x)
                    addPixel(sums[i++], job.magnified(), size_t(y) * film.width + x, film, tally,
                             figures);
            count(figures);
            return tally;
        });
        if (film_.progress().samples == had) return;
        std::swap(before_, now_);
        moved_.clear();
        samplesBefore_ += samplesOfPass(params_, passes_);
        ++passes_;
    }

    void count(const ReuseFigures& figures)
    {
        const std::lock_guard lock(figuresMutex_);
        figures_.add(figures);
    }

    void addPixel(const shared::ReuseSums& sums, float magnified, size_t i, Film& film,
                  TileTally& tally, ReuseFigures& figures)
    {
        const float weight = shared::weightAtRest(sums, magnified);
        if (passes_ > 0) {
            film.add(i, shared::plainRadiance(sums), tally.counters);
        } else if (keepsMeans()) {
            // A sample that is no number is dropped from the picture, as it is from the mean.
            const glm::vec3 plain = shared::plainRadiance(sums);
            const glm::vec3 mean = shared::isNumber(plain) ? now_.means[i] : plain;
            film.begin(i, mean, mean * mean, weight, tally.counters);
        } else {
            film.begin(i, shared::reusedRadiance(sums), shared::reusedSquares(sums, weight), weight,
                       tally.counters);
        }
        const bool scatters = shared::unpackHistory(now_.pixels[i].history).nominal > 0;
        const uint32_t paths = scatters ? sums.taken : 1;
        figures.scatters += scatters ? 1 : 0;
        figures.withHistory += sums.nominal > 0 ? 1 : 0;
        figures.weights += double(sums.weightSum);
        figures.shares += double(sums.nominal / (sums.nominal + sums.rays));
        figures.paths += paths;
        if (sums.noise >= 0) ++figures.deviations[shared::deviationBin(sums.noise)];
        if (passes_ == 0) {
            figures.asked += scatters ? 1 : 0;
            figures.leaked += double(shared::biasShare(sums, sums.leaked));
            figures.lost += double(shared::biasShare(sums, sums.lost));
        }
        tally.paths += paths;
    }

    bool keepsMeans() const { return shared::keepsMeans(static_cast<uint32_t>(params_.reuse)); }

    ReuseParams params_;
    std::shared_ptr<const World> world_;
    ReuseStore before_, now_;
    std::vector<shared::MovedPiece> moved_;  // from that of `before_`
    float visibility_ = 0;
    float perDeviation_ = 0;
    uint32_t passes_ = 0;         // of this view, as far as they go to the history
    uint32_t plainSamples_ = 0;   // of this view that have left the history alone
    uint32_t samplesBefore_ = 0;  // of all views since the last that began anew
    mutable std::mutex figuresMutex_;
    ReuseFigures figures_;  // of this view
};

}  // namespace

std::unique_ptr<Renderer> makeSampleReuse()
{
    return std::make_unique<SampleReuse>();
}

std::span<const MapInfo> reuseMaps()
{
    static constexpr std::array kMaps{
        MapInfo{"history", "samples that the history of a pixel stands for (N)"},
        MapInfo{"alpha", "share of the picture that old samples answer for", 1},
        MapInfo{"c", "N / (N + n): the share where the surface's lobe has not turned", 1},
        MapInfo{"residual", "share that is left to new paths: 1 - alpha", 1},
        MapInfo{"ess", "equal samples that would be as good as the weights are (ESS)"},
        MapInfo{"rays", "new paths of the last pass"},
    };
    return kMaps;
}

std::span<const MethodPreset> reusePresets()
{
    static const std::array kPresets{
        MethodPreset{"flight", ReuseParams{}, "Reweighting-Augmentation with four samples a pixel"},
        MethodPreset{"ample", ReuseParams{.records = 8, .lights = 4},
                     "eight samples a pixel: hardly less noise, but more time and nearly twice the "
                     "memory"},
        MethodPreset{"balance", ReuseParams{.reuse = ReuseStrategy::mis},
                     "the balance heuristic between old and new samples: nearly as good, cheaper"},
        MethodPreset{"fresh", ReuseParams{.reuse = ReuseStrategy::discard},
                     "nothing is kept: what the others are measured against"},
        MethodPreset{"ceiling", ReuseParams{.reuse = ReuseStrategy::full},
                     "as many fresh paths as the history stands for: the best that reuse could be, "
                     "at many times the cost"},
    };
    return kPresets;
}

}  // namespace core
