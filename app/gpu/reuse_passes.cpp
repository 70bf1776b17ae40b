// See reuse_passes.h.
#include "app/gpu/reuse_passes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "core/methods/reuse_maps.h"
#include "shared/reuse_chain.h"
#include "spirv/reuse_hits.h"
#include "spirv/reuse_new.h"
#include "spirv/reuse_old.h"

namespace gpu {

namespace {

constexpr uint32_t kMaxLanes =
    1u << 16;  // of a batch: what kernels leave to each other stays small
constexpr uint64_t kWord = 16;
constexpr uint32_t kMostPaths = 5 * kMaxLanes;  // that wait for a batch: 26 MiB

/// Places for paths that a lane may need.
uint32_t placesOfLane(const shared::ReuseSettings& settings)
{
    if (settings.strategy == shared::kReuseFull) return 1;
    const bool allocates = (settings.flags & shared::kReuseAllocates) != 0;
    const float rays = settings.rays * (allocates ? shared::kReuseMostPart : 1.0f);
    // Credit may make one of a part.
    return static_cast<uint32_t>(std::ceil(std::max(rays, 1.0f)));
}

/// Words that a store has room for in each pixel: only what the strategy reads.
struct WordsKept {
    uint64_t places, arriving, lights, remainders;
    bool operator==(const WordsKept&) const = default;
};

WordsKept wordsKept(const shared::ReuseSettings& settings)
{
    const bool samples = shared::keepsSamples(settings.strategy);
    const uint64_t records = samples ? recordsOf(settings) : 0;
    return {records, shared::hasArrivingWords(settings) ? records : 0,
            samples ? lightsOf(settings) : 0u, shared::carriesRemainder(settings) ? 1u : 0u};
}

std::array<DescriptorSet, 2> twoSets(Device& device, const KernelBase& kernel)
{
    return {DescriptorSet(device, kernel.own()), DescriptorSet(device, kernel.own())};
}

}  // namespace

ReusePasses::ReusePasses(Context& context)
    : context_(context), hits_(context.device, k_reuse_hits, &context.layouts),
      new_(context.device, k_reuse_new, &context.layouts),
      old_(context.device, k_reuse_old, &context.layouts),
      hitsSets_(twoSets(context.device, hits_)), newSets_(twoSets(context.device, new_)),
      oldSets_(twoSets(context.device, old_)), motion_(context.device)
{}

bool ReusePasses::takeMotion(const GpuScene& scene, const core::World& before,
                             const core::Bvh& hierarchyBefore,
                             std::span<const shared::MovedPiece> pieces)
{
    std::vector<DescriptorSet*> sets;
    for (auto* two : {&hitsSets_, &newSets_, &oldSets_})
        for (DescriptorSet& set : *two) sets.push_back(&set);
    return motion_.take(scene, before, hierarchyBefore, pieces, sets);
}

void ReusePasses::prepare(glm::uvec2 size, uint32_t tiles, const shared::ReuseSettings& settings,
                          float perDeviation, bool chains)
{
    const uint64_t pixels = uint64_t(size.x) * size.y;
    shared::ReuseSettings wanted = settings;
    const VkPhysicalDeviceLimits& limits = context_.device.limits();
    const uint64_t fits = std::min(limits.maxStorageBufferRange / (pixels * kWord),
                                   limits.maxTexelBufferElements / pixels);
    wanted.counts = shared::packCounts(
        static_cast<uint32_t>(std::clamp<uint64_t>(fits, 1, recordsOf(settings))),
        static_cast<uint32_t>(std::clamp<uint64_t>(fits, 1, lightsOf(settings))),
        candidatesOf(settings));
    if (wordsKept(wanted) != wordsKept(settings_)) {
        forget();
        stores_ = {};
    }
    settings_ = wanted;
    perDeviation_ = perDeviation;
    size_ = size;
    makeStore(side_);
    if (stores_[1 - side_].size.x == 0) makeStore(1 - side_);
    makeScratch(tiles, placesOfLane(settings), chains);
}

/// Makes a store one of the present size; larger than needed is good enough.
void ReusePasses::makeStore(uint32_t side)
{
    Store& store = stores_[side];
    const uint64_t pixels = uint64_t(size_.x) * size_.y;
    if (store.means.bytes() >= pixels * kWord) {
        store.size = size_;
        return;
    }
    store.size = {};
    const auto make = [&](Buffer& buffer, uint64_t perPixel, VkFormat format) {
        buffer = {};
        buffer = Buffer(context_.device, "the kept samples",
                        std::max<uint64_t>(pixels * perPixel, 1) * kWord, format);
    };
    const WordsKept words = wordsKept(settings_);
    constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT;
    store.means = {};  // first and last: its size tells whether all could be had
    make(store.pixels, 1, kWords);
    make(store.places, words.places, kWords);
    make(store.arriving, words.arriving, kWords);
    make(store.lights, words.lights, kWords);
    make(store.remainders, words.remainders, VK_FORMAT_R32G32B32A32_SFLOAT);
    make(store.means, 1, VK_FORMAT_R32G32B32A32_SFLOAT);
    store.size = size_;
    bindStore(side);
}

/// Shows a store to the kernels: as the one that is written, and as the one that is read.
void ReusePasses::bindStore(uint32_t side)
{
    const Store& store = stores_[side];
    for (auto* sets : {&hitsSets_, &newSets_, &oldSets_}) {
        (*sets)[side].bind(shared::kBindPixelsNow, store.pixels);
        (*sets)[1 - side].bind(shared::kBindPixelsBefore, store.pixels);
    }
    DescriptorSet& writes = oldSets_[side];
    writes.bind(shared::kBindPlacesNow, store.places);
    writes.bind(shared::kBindArrivingNow, store.arriving);
    writes.bind(shared::kBindLightsNow, store.lights);
    writes.bind(shared::kBindMeansNow, store.means);
    writes.bind(shared::kBindRemaindersNow, store.remainders);
    DescriptorSet& reads = oldSets_[1 - side];
    reads.bind(shared::kBindPlacesBefore, store.places);
    reads.bind(shared::kBindArrivingBefore, store.arriving);
    reads.bind(shared::kBindLightsBefore, store.lights);
    reads.bind(shared::kBindMeansBefore, store.means);
    reads.bind(shared::kBindRemaindersBefore, store.remainders);
    hitsSets_[1 - side].bind(shared::kBindMeansBefore, store.means);
}

void ReusePasses::makeScratch(uint32_t tiles, uint32_t rays, bool chains)
{
    if (chains) ++rays;  // the way not taken
    const uint32_t lanes =
        std::min(std::bit_ceil(std::clamp(tiles * shared::kGroupSize, 1u << 12, kMaxLanes)),
                 std::bit_floor(kMostPaths / rays));
    const bool hasChains = chains_.bytes() > kWord;
    if (lanes_ >= lanes && mostRays_ >= rays && (hasChains || !chains)) return;
    lanes_ = 0;
    const uint64_t paths = uint64_t(lanes) * rays;
    const auto make = [&](Buffer& buffer, uint64_t bytes, VkFormat format) {
        buffer = {};
        buffer = Buffer(context_.device, "the new samples", bytes, format);
    };
    make(newSamples_, paths * shared::kReuseNewWords * kWord, VK_FORMAT_R32G32B32A32_UINT);
    make(waiting_, paths * sizeof(uint32_t), VK_FORMAT_UNDEFINED);
    make(waitingHead_, sizeof(shared::WaitingHead), VK_FORMAT_UNDEFINED);
    make(firstNew_, lanes * sizeof(glm::uvec2), VK_FORMAT_R32G32_UINT);
    make(chains_, chains ? uint64_t(lanes) * shared::kReuseChainWords * kWord : kWord,
         VK_FORMAT_R32G32B32A32_UINT);
    for (uint32_t side = 0; side < 2; ++side) {
        for (DescriptorSet* set : {&newSets_[side], &oldSets_[side]})
            set->bind(shared::kBindNewSamples, newSamples_);
        for (DescriptorSet* set : {&hitsSets_[side], &newSets_[side]}) {
            set->bind(shared::kBindWaiting, waiting_);
            set->bind(shared::kBindWaitingHead, waitingHead_);
        }
        for (DescriptorSet* set : {&hitsSets_[side], &oldSets_[side]})
            set->bind(shared::kBindFirstNew, firstNew_);
        hitsSets_[side].bind(shared::kBindChainsNow, chains_);
        for (DescriptorSet* set : {&newSets_[side], &oldSets_[side]})
            set->bind(shared::kBindChains, chains_);
    }
    lanes_ = lanes;
    mostRays_ = rays;
}

void ReusePasses::record(VkCommandBuffer commands, const GpuScene& scene, const Frame& frame,
                         const ReuseConstants& constants, const shared::ReuseBatch& push,
                         uint32_t groups)
{
    const shared::WaitingHead nobody{{0, 1, 1, 0}, perDeviation_};
    vk.CmdUpdateBuffer(commands, waitingHead_.get(), 0, sizeof(nobody), &nobody);
    barrier(commands);
    const auto sets = [&](const std::array<DescriptorSet, 2>& own) {
        return KernelSets{&scene.set(), &frame.set(), &own[side_]};
    };
    hits_.dispatch(commands, hits_.pipeline(constants), sets(hitsSets_), push, groups);
    barrier(commands);
    new_.dispatchIndirect(commands, new_.pipeline(constants), sets(newSets_), push, waitingHead_,
                          0);
    barrier(commands);
    old_.dispatch(commands, old_.pipeline(constants), sets(oldSets_), push, groups);
    barrier(commands);
}

bool ReusePasses::compile(const GpuScene& scene, const Frame& frame,
                          const ReuseConstants& constants)
{
    if (old_.isCompiled(constants)) return false;
    for (ReuseKernel* kernel : {&hits_, &new_, &old_})
        kernel->pipeline(constants);  // where failing leaves no half-recorded commands
    shared::ReuseBatch nothing{};
    nothing.settings = settings_;
    context_.device.submit(
        [&](VkCommandBuffer commands) {
            record(commands, scene, frame, constants, nothing, 1);
            // No path waits, but the driver compiles what is dispatched.
            new_.dispatch(commands, new_.pipeline(constants),
                          {&scene.set(), &frame.set(), &newSets_[side_]}, nothing, 1);
        },
        "the compilation of the kernels");
    return true;
}

double ReusePasses::run(const GpuScene& scene, const Frame& frame, const ReuseConstants& constants,
                        const shared::Batch& batch, uint32_t flags)
{
    shared::ReuseBatch push{batch, settings_, camera_};
    push.settings.flags = flags | (motion_.count() << shared::kReuseMovedShift);
    const glm::uvec2 before = stores_[1 - side_].size;
    push.settings.sizeBefore = (before.x - 1) | ((before.y - 1) << 16);
    if (!shared::looksBack(settings_)) push.cameraBefore = {};
    return context_.device.submit(
        [&](VkCommandBuffer commands) {
            record(commands, scene, frame, constants, push, batch.tileCount);
        },
        "sample reuse, tiles " + std::to_string(batch.firstTile) + " to " +
            std::to_string(batch.firstTile + batch.tileCount - 1) + " of " +
            std::to_string(frame.tileCount()));
}

std::vector<core::Image> ReusePasses::maps(glm::uvec2 size) const
{
    const Store& store = stores_[1 - side_];
    const size_t count = size_t(size.x) * size.y;
    std::vector<glm::uvec4> pixels(count);
    std::vector<glm::vec4> maps(count);
    store.pixels.read(std::as_writable_bytes(std::span(pixels)));
    store.means.read(std::as_writable_bytes(std::span(maps)));
    return core::makeReuseMaps(
        size, settings_.strategy, [&](size_t i) { return shared::unpackReusePixel(pixels[i]); },
        [&](size_t i) { return shared::unpackReuseMap(maps[i], settings_.strategy); });
}

void ReusePasses::commit(const shared::CameraData& camera)
{
    camera_ = camera;
    motion_.rest();
    side_ = 1 - side_;
    makeStore(side_);  // it may be that of a smaller picture
}

}  // namespace gpu
