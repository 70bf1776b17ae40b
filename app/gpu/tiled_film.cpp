// Rounds over all tiles, in batches as large as the pace allows.
#include "app/gpu/tiled_film.h"

#include <algorithm>
#include <limits>

#include "core/base/check.h"
#include "core/base/time.h"

namespace gpu {

shared::FrameData frameOf(const core::World& world, const GpuScene& scene, const core::View& view)
{
    shared::FrameData frame{};
    frame.settings = core::worldSettings(world);
    frame.settings.imageWidth = view.size.x;
    frame.settings.imageHeight = view.size.y;
    frame.settings.skyRegions = (scene.features() & shared::kFeatureSkyRegions) != 0 ? 1 : 0;
    frame.camera = core::cameraData(view.camera, view.size.x, view.size.y);
    frame.camera.centred = view.centred ? 1 : 0;
    frame.entry = scene.entry();
    frame.tilesPerRow = (view.size.x + 7) / 8;
    return frame;
}

/// Mean, variance of the mean (as core::Film::varianceOfMean) and weight of one pixel. Variances
/// end at the largest float.
static void storePixel(const shared::FilmPixel& p, size_t pixel, core::Estimate& estimate)
{
    const double n = double(p.weight) - double(p.weightLost);
    estimate.weight.pixels[pixel] = static_cast<float>(n);
    if (n == 0) return;
    const glm::dvec3 mean = (glm::dvec3(p.sum) - glm::dvec3(p.sumLost)) / n;
    const glm::dvec3 squares = (glm::dvec3(p.squares) - glm::dvec3(p.squaresLost)) / n;
    for (int k = 0; k < 3; ++k) {
        const size_t i = 3 * pixel + size_t(k);
        estimate.mean.pixels[i] = static_cast<float>(mean[k]);
        if (!(n > 1)) continue;
        // Squares of radiances above 1.8e19 are infinite, their compensation is no number.
        constexpr double kMost = std::numeric_limits<float>::max();
        const double variance = std::max(squares[k] - mean[k] * mean[k], 0.0) / (n - 1);
        estimate.variance.pixels[i] = static_cast<float>(variance < kMost ? variance : kMost);
    }
}

TiledFilm::TiledFilm(Context& context)
    : frame_(context.device, context.layouts), film_(context), firstHits_(context)
{}

void TiledFilm::drop()
{
    clear();
    firstHits_.forgetScene();
}

void TiledFilm::clear()
{
    ready_ = false;
    samples_ = 0;
    roundSamples_ = nextTile_ = 0;
    ++version_;
}

void TiledFilm::reset(const shared::FrameData& data)
{
    clear();
    frame_.write(data);
    film_.reset(frame_);
    counts_ = {};
    renderSeconds_ = readbackSeconds_ = 0;
}

void TiledFilm::begin(const Buffer& radiance)
{
    pathsOfLane_ = 1;
    film_.setRadiance(radiance);
    frame_.clearCounters();
    ready_ = true;
}

void TiledFilm::begin(DescriptorSet& set, uint32_t pathsOfLane)
{
    pathsOfLane_ = pathsOfLane;
    film_.bindTo(set);
    frame_.clearCounters();
    ready_ = true;
}

core::RenderProgress TiledFilm::progress() const
{
    const uint32_t tiles = frame_.tileCount();
    return {version_, samples_, tiles > 0 ? double(nextTile_) / double(tiles) : 0};
}

void TiledFilm::advance(const core::Budget& budget, const std::stop_token& stop,
                        const std::function<uint32_t()>& lanes, const Trace& trace,
                        const std::function<void()>& beforeRound)
{
    CHECK(ready_);
    const auto start = core::Clock::now();
    const auto over = [&] {
        return stop.stop_requested() || core::secondsSince(start) >= budget.seconds;
    };
    const uint64_t end = samples_ + budget.samples;
    const bool cut = roundSamples_ > 0;
    bool goes = !stop.stop_requested() && (!cut || advanceRound(over, lanes, trace));
    for (bool first = !cut; goes && samples_ < end; first = false) {
        if (!first && over()) break;
        if (beforeRound) beforeRound();
        roundSamples_ = static_cast<uint32_t>(std::clamp<uint64_t>(
            lanes() / (shared::kGroupSize * frame_.tileCount()), 1, end - samples_));
        goes = advanceRound(over, lanes, trace);
    }
    renderSeconds_ += core::secondsSince(start);
}

/// Adds the round's samples to every pixel that has not had them, in batches of tiles. When it is
/// `over` between two batches, the other tiles are left for later: returns whether none is left.
bool TiledFilm::advanceRound(const std::function<bool()>& over,
                             const std::function<uint32_t()>& lanes, const Trace& trace)
{
    const uint64_t mostUndrained = pathsBetweenDrains(frame_.data().settings.maxDepth);
    const uint32_t tiles = frame_.tileCount();
    uint64_t undrained = 0;
    while (nextTile_ < tiles) {
        const uint32_t most = lanes() / (shared::kGroupSize * roundSamples_);
        const uint32_t count = std::min(std::max(most, 1u), tiles - nextTile_);
        trace({nextTile_, count, static_cast<uint32_t>(samples_), roundSamples_}, accumulate_);
        nextTile_ += count;
        ++version_;
        undrained += uint64_t(count) * shared::kGroupSize * roundSamples_ * pathsOfLane_;
        if (undrained >= mostUndrained) {
            frame_.drainCounters(counts_);
            undrained = 0;
        }
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

core::Estimate TiledFilm::read(core::Reading what)
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
    readbackSeconds_ += core::secondsSince(start);
    return estimate;
}

core::Aovs TiledFilm::aovs(const GpuScene& scene, double seconds)
{
    CHECK(ready_);
    return firstHits_.find(scene, frame_, core::Sight::first, seconds);
}

core::Aovs TiledFilm::surfaces(const GpuScene& scene, const shared::FrameData& data,
                               core::Sight sight, double seconds)
{
    CHECK(ready_);
    const shared::FrameData own = frame_.data();
    frame_.write(data);
    core::Aovs found = firstHits_.find(scene, frame_, sight, seconds);
    frame_.write(own);
    return found;
}

void TiledFilm::prepareAovs(const GpuScene& scene)
{
    CHECK(ready_);
    firstHits_.prepare(scene, frame_);
}

core::Aovs TiledFilm::look(const GpuScene& scene, const shared::FrameData& data, double seconds)
{
    drop();
    frame_.write(data);
    return firstHits_.find(scene, frame_, core::Sight::first, seconds);
}

void TiledFilm::addTo(core::RenderStats& stats) const
{
    stats.renderSeconds += renderSeconds_;
    stats.readbackSeconds += readbackSeconds_;
    stats.rays += counts_.rays;
    stats.paths += samples_ * frame_.width() * frame_.height() +
                   uint64_t(nextTile_) * roundSamples_ * shared::kGroupSize;
}

}  // namespace gpu
