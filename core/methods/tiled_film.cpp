// Steps over all tiles; a step that is cut short remembers which tiles it has done.
#include "core/methods/tiled_film.h"

#include <algorithm>
#include <mutex>

#include "core/base/check.h"
#include "core/base/denormals.h"

namespace core {

void TiledFilm::reset(glm::uvec2 size)
{
    film_.reset(size.x, size.y);
    const glm::uvec2 tiles = (size + kFilmTile - 1u) / kFilmTile;
    tileDone_.assign(size_t(tiles.x) * tiles.y, 0);
    tilesDone_ = 0;
    stepSamples_ = 0;
    rays_ = paths_ = 0;
    seconds_ = 0;
    ++version_;
}

RenderProgress TiledFilm::progress() const
{
    const size_t tiles = tileDone_.size();
    return {version_, film_.samples, tiles > 0 ? double(tilesDone_) / double(tiles) : 0};
}

void TiledFilm::addTo(RenderStats& stats) const
{
    stats.rays += rays_;
    stats.paths += paths_;
    stats.renderSeconds += seconds_;
}

void TiledFilm::advance(const Budget& budget, const std::stop_token& stop, const RenderTile& render)
{
    CHECK(!film_.sum.empty());
    const Clock::time_point start = Clock::now();
    const uint64_t end = film_.samples + budget.samples;
    const bool cut = stepSamples_ > 0;
    bool goes = !cut || renderStep(start, budget.seconds, stop, render);
    for (bool first = !cut; goes && film_.samples < end; first = false) {
        if (stop.stop_requested() || (!first && secondsSince(start) >= budget.seconds)) break;
        stepSamples_ = stepFor(end - film_.samples);
        goes = renderStep(start, budget.seconds, stop, render);
    }
    seconds_ += secondsSince(start);
}

/// Samples of one step over all tiles: several where one would be over at once.
uint32_t TiledFilm::stepFor(uint64_t left) const
{
    constexpr uint64_t kStepPaths = 1u << 18;
    const uint64_t several = std::clamp<uint64_t>(kStepPaths / film_.sum.size(), 1, 64);
    return static_cast<uint32_t>(std::min(left, several));
}

/// Adds the step's samples to every tile that has not had them. A stop, or the end of the time,
/// leaves tiles for later: returns whether none is left.
bool TiledFilm::renderStep(Clock::time_point start, double seconds, const std::stop_token& stop,
                           const RenderTile& render)
{
    const size_t tilesPerRow = (film_.width + kFilmTile - 1) / kFilmTile;
    const auto firstSample = static_cast<uint32_t>(film_.samples);
    std::stop_source over;
    const std::stop_callback passOn(stop, [&over] { over.request_stop(); });
    std::mutex mutex;
    TileTally total;
    size_t done = 0;
    const auto body = [&](const Tile& tile) {
        uint8_t& tileDone = tileDone_[tile.y0 / kFilmTile * tilesPerRow + tile.x0 / kFilmTile];
        if (tileDone != 0) return;
        const FlushDenormals flush;
        const TileTally tally = render(tile, firstSample, stepSamples_, film_);
        tileDone = 1;
        if (secondsSince(start) >= seconds) over.request_stop();
        const std::lock_guard lock(mutex);
        total.rays += tally.rays;
        total.paths += tally.paths;
        total.counters += tally.counters;
        ++done;
    };
    parallelTiles(film_.width, film_.height, kFilmTile, body, over.get_token());
    film_.counters += total.counters;
    rays_ += total.rays;
    paths_ += total.paths;
    tilesDone_ += done;
    if (done > 0) ++version_;
    if (tilesDone_ < tileDone_.size()) return false;
    film_.samples += stepSamples_;
    stepSamples_ = 0;
    tilesDone_ = 0;
    std::fill(tileDone_.begin(), tileDone_.end(), uint8_t(0));
    return true;
}

}  // namespace core
