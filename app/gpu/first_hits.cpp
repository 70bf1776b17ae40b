// In bands of rows, so that a large image needs no large buffer.
#include "app/gpu/first_hits.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/methods/first_hits.h"
#include "spirv/first_hits.h"
#include "spirv/seen.h"

namespace gpu {

namespace {

constexpr size_t kStoredAtOnce = 1u << 13;
constexpr uint32_t kBandTiles = 1u << 12;  // of first hits on their way back: 13 MiB

/// Nothing is looked into yet.
void clearHead(VkCommandBuffer commands, const Buffer& head)
{
    const shared::QueueHead none{0, 1, 1, 0};
    vk.CmdUpdateBuffer(commands, head.get(), 0, sizeof(none), &none);
    barrier(commands);
}

}  // namespace

FirstHits::FirstHits(Context& context)
    : context_(context), hits_(context.device, k_first_hits, &context.layouts),
      seen_(context.device, k_seen, &context.layouts), hitsSet_(context.device, hits_.own()),
      seenSet_(context.device, seen_.own()),
      lookingHead_(context.device, "the head of what is looked into", sizeof(shared::QueueHead))
{
    for (DescriptorSet* set : {&hitsSet_, &seenSet_})
        set->bind(shared::kBindLookingHead, lookingHead_);
}

core::Aovs FirstHits::find(const GpuScene& scene, const Frame& frame, core::Sight sight,
                           double seconds)
{
    const uint32_t width = frame.width(), height = frame.height();
    core::Aovs aovs = core::emptyAovs(width, height);
    const uint32_t tilesPerRow = frame.data().tilesPerRow;
    const uint32_t band = std::clamp(kBandTiles / tilesPerRow, 1u, frame.tileRows());
    const bool looksThrough =
        sight == core::Sight::clear && (scene.features() & shared::kFeatureDelta) != 0;
    makeRoom(uint64_t(width) * std::min(8 * band, height),
             looksThrough ? uint64_t(band) * tilesPerRow * shared::kGroupSize : 1);
    compile(scene, frame, looksThrough);
    if (seconds < BatchPace::kLongest) pace_.again();
    std::vector<shared::FirstHit> hits;
    for (uint32_t row = 0; row < frame.tileRows(); row += band) {
        const uint32_t end = std::min(row + band, frame.tileRows());
        const uint32_t firstPixel = 8 * row * width;
        trace(scene, frame, end * tilesPerRow,
              {row * tilesPerRow, 0, firstPixel, looksThrough ? 1u : 0u}, seconds);
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
    makeRoom(1, 1);
    compile(scene, frame, (scene.features() & shared::kFeatureDelta) != 0);
}

void FirstHits::makeRoom(uint64_t pixels, uint64_t lanes)
{
    const auto grow = [&](Buffer& buffer, const char* name, uint32_t binding, uint64_t bytes) {
        if (buffer.bytes() >= bytes) return;
        for (DescriptorSet* set : {&hitsSet_, &seenSet_}) set->unbind(binding);
        buffer = {};
        buffer = Buffer(context_.device, name, bytes);
        for (DescriptorSet* set : {&hitsSet_, &seenSet_}) set->bind(binding, buffer);
    };
    grow(found_, "the first hits", shared::kBindFirstHits, pixels * sizeof(shared::FirstHit));
    grow(lookingLanes_, "what is looked into", shared::kBindLookingLanes, lanes * sizeof(uint32_t));
}

void FirstHits::compile(const GpuScene& scene, const Frame& frame, bool looksThrough)
{
    compile(hits_, hitsSet_, scene, frame);
    if (looksThrough) compile(seen_, seenSet_, scene, frame);
}

/// An empty dispatch, so that no piece is timed while software drivers compile.
void FirstHits::compile(TileKernel& kernel, const DescriptorSet& own, const GpuScene& scene,
                        const Frame& frame)
{
    if (kernel.isCompiled({scene.features()})) return;
    const Pipeline& pipeline = kernel.pipeline({scene.features()});
    context_.device.submit(
        [&](VkCommandBuffer commands) {
            clearHead(commands, lookingHead_);
            kernel.dispatch(commands, pipeline, {&scene.set(), &frame.set(), &own},
                            shared::TileRange{}, 1);
            barrier(commands);
        },
        "the compilation of the first hits");
}

/// The hits of the tiles from the first of `tiles` up to `endTile` go to `found_`.
void FirstHits::trace(const GpuScene& scene, const Frame& frame, uint32_t endTile,
                      shared::TileRange tiles, double seconds)
{
    for (uint32_t tile = tiles.firstTile; tile < endTile; tile += tiles.tileCount) {
        const uint32_t lanes = pace_.lanes(seconds, (endTile - tile) * shared::kGroupSize);
        tiles.firstTile = tile;
        tiles.tileCount = lanes / shared::kGroupSize;
        pace_.measured(lanes,
                       context_.device.submit(
                           [&](VkCommandBuffer commands) { record(commands, scene, frame, tiles); },
                           "first hits, tiles " + std::to_string(tile) + " to " +
                               std::to_string(tile + tiles.tileCount - 1) + " of " +
                               std::to_string(frame.tileCount())));
    }
}

/// How many pixels are looked at again stays on the device.
void FirstHits::record(VkCommandBuffer commands, const GpuScene& scene, const Frame& frame,
                       const shared::TileRange& tiles)
{
    const auto sets = [&](const DescriptorSet& own) {
        return KernelSets{&scene.set(), &frame.set(), &own};
    };
    const FeatureConstants constants{scene.features()};
    clearHead(commands, lookingHead_);
    hits_.dispatch(commands, hits_.pipeline(constants), sets(hitsSet_), tiles, tiles.tileCount);
    barrier(commands);
    if (tiles.looksThrough == 0) return;
    seen_.dispatchIndirect(commands, seen_.pipeline(constants), sets(seenSet_), tiles, lookingHead_,
                           0);
    barrier(commands);
}

}  // namespace gpu
