// A film that is filled tile by tile on all cores: what the progressive CPU methods have in common.
// A pixel adds its samples in their order, so that neither threads nor pauses nor the sizes of
// steps change a bit of the picture.
#pragma once

#include <functional>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/time.h"
#include "core/methods/renderer.h"

namespace core {

/// Side of the squares of pixels that are rendered together. Which rays share a packet follows from
/// it, so it is part of what an image is.
inline constexpr uint32_t kFilmTile = 16;

/// What a tile found besides its pixels.
struct TileTally {
    FilmCounters counters;
    uint64_t rays = 0, paths = 0;
};

class TiledFilm {
public:
    /// Adds samples [first, first + count) to every pixel of `tile`, in order; called for several
    /// tiles at a time, each from one thread, with denormals flushed.
    using RenderTile =
        std::function<TileTally(const Tile& tile, uint32_t first, uint32_t count, Film& film)>;

    /// Empties it.
    void reset(glm::uvec2 size);

    /// As Renderer::advance; pieces are tiles.
    void advance(const Budget& budget, const std::stop_token& stop, const RenderTile& render);

    glm::uvec2 size() const { return {film_.width, film_.height}; }
    RenderProgress progress() const;
    Estimate estimate(Reading what) const { return film_.estimate(what == Reading::mean); }

    /// Adds what has been traced since the last reset, and how long it took.
    void addTo(RenderStats& stats) const;

private:
    uint32_t stepFor(uint64_t left) const;
    bool renderStep(Clock::time_point start, double seconds, const std::stop_token& stop,
                    const RenderTile& render);

    Film film_;
    uint64_t version_ = 0;
    // The step under way: its samples (0: none) and the tiles that have had them.
    uint32_t stepSamples_ = 0;
    std::vector<uint8_t> tileDone_;
    size_t tilesDone_ = 0;
    uint64_t rays_ = 0, paths_ = 0;
    double seconds_ = 0;
};

}  // namespace core
