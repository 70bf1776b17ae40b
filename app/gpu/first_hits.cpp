// In bands of rows, so that a large image needs no large buffer.
#include "app/gpu/first_hits.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/methods/first_hits.h"
#include "spirv/first_hits.h"

namespace gpu {

namespace {

constexpr size_t kStoredAtOnce = 1u << 13;
constexpr uint32_t kBandTiles = 1u << 12;  // of first hits on their way back: 13 MiB

}  // namespace

FirstHits::FirstHits(Context& context)
    : context_(context), kernel_(context.device, k_first_hits, &context.layouts),
      set_(context.device, kernel_.own())
{}

core::Aovs FirstHits::find(const GpuScene& scene, const Frame& frame, core::Sight sight,
                           double seconds)
{
    const uint32_t width = frame.width(), height = frame.height();
    core::Aovs aovs = core::emptyAovs(width, height);
    const uint32_t tilesPerRow = frame.data().tilesPerRow;
    const uint32_t band = std::clamp(kBandTiles / tilesPerRow, 1u, frame.tileRows());
    const uint64_t bytes = uint64_t(width) * std::min(8 * band, height) * sizeof(shared::FirstHit);
    makeRoom(bytes);
    compile(scene, frame);
    if (seconds < BatchPace::kLongest) pace_.again();
    std::vector<shared::FirstHit> hits;
    for (uint32_t row = 0; row < frame.tileRows(); row += band) {
        const uint32_t end = std::min(row + band, frame.tileRows());
        const uint32_t firstPixel = 8 * row * width;
        trace(scene, frame, end * tilesPerRow,
              {row * tilesPerRow, 0, firstPixel, sight == core::Sight::clear ? 1u : 0u}, seconds);
        hits.resize(std::min(8 * end, height) * size_t(width) - firstPixel);
        found_.read(std::as_writable_bytes(std::span(hits)));
        core::parallelFor(hits.size(), kStoredAtOnce, [&](size_t begin, size_t stop) {
            for (size_t i = begin; i < stop; ++i)
                core::storeFirstHit(hits[i], firstPixel + i, aovs);
        });
    }
    return aovs;
}

void FirstHits::prepare(const GpuScene& scene, const Frame& frame)
{
    makeRoom(sizeof(shared::FirstHit));
    compile(scene, frame);
}

void FirstHits::makeRoom(uint64_t bytes)
{
    if (found_.bytes() >= bytes) return;
    set_.unbind(shared::kBindFirstHits);
    found_ = {};
    found_ = Buffer(context_.device, "the first hits", bytes);
    set_.bind(shared::kBindFirstHits, found_);
}

/// An empty dispatch, so that no piece is timed while software drivers compile.
void FirstHits::compile(const GpuScene& scene, const Frame& frame)
{
    if (kernel_.isCompiled({scene.features()})) return;
    const Pipeline& pipeline = kernel_.pipeline({scene.features()});
    context_.device.submit(
        [&](VkCommandBuffer commands) {
            kernel_.dispatch(commands, pipeline, {&scene.set(), &frame.set(), &set_}, {}, 1);
            barrier(commands);
        },
        "the compilation of the first hits");
}

/// The hits of the tiles from the first of `tiles` up to `endTile` go to `found_`.
void FirstHits::trace(const GpuScene& scene, const Frame& frame, uint32_t endTile,
                      shared::TileRange tiles, double seconds)
{
    const Pipeline& pipeline = kernel_.pipeline({scene.features()});
    for (uint32_t tile = tiles.firstTile; tile < endTile; tile += tiles.tileCount) {
        const uint32_t lanes = pace_.lanes(seconds, (endTile - tile) * shared::kGroupSize);
        tiles.firstTile = tile;
        tiles.tileCount = lanes / shared::kGroupSize;
        const auto record = [&](VkCommandBuffer commands) {
            kernel_.dispatch(commands, pipeline, {&scene.set(), &frame.set(), &set_}, tiles,
                             tiles.tileCount);
            barrier(commands);
        };
        pace_.measured(lanes, context_.device.submit(
                                  record, "first hits, tiles " + std::to_string(tile) + " to " +
                                              std::to_string(tile + tiles.tileCount - 1) + " of " +
                                              std::to_string(frame.tileCount())));
    }
}

}  // namespace gpu
