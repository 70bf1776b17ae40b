// See reuse_passes.h.
#include "app/gpu/reuse_passes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "core/methods/reuse_maps.h"
#include "shared/reuse_new.h"
#include "spirv/reuse_bounce.h"
#include "spirv/reuse_bounce_panes.h"
#include "spirv/reuse_full.h"
#include "spirv/reuse_full_panes.h"
#include "spirv/reuse_hits.h"
#include "spirv/reuse_new.h"
#include "spirv/reuse_new_panes.h"
#include "spirv/reuse_old.h"
#include "spirv/reuse_old_panes.h"
#include "spirv/reuse_weigh.h"

namespace gpu {

namespace {

// Lanes of a batch: what kernels leave to each other stays small.
constexpr uint32_t kMaxLanes = 1u << 16;
constexpr uint32_t kMaxSoftwareLanes = 1u << 15;  // fills a software device just as well
constexpr uint64_t kWord = 16;
constexpr uint32_t kMostPaths = 2 * kMaxLanes;   // that wait for a batch: 44 MiB
constexpr uint32_t kMostChunks = 8 * kMaxLanes;  // the same of `full`: 42 MiB
// Rays that a lane of `full` traces in a row: software devices cut rays short after too many
// (traverse.glsl), others are not to be held for long by one lane.
constexpr uint32_t kSoftwareRaysInARow = 32, kRaysInARow = 1024;
constexpr uint32_t kMostBounces = 33;  // of paths of at most 32 scattering events

/// New paths that a pixel may have: credit may make one of a part.
uint32_t mostPaths(const shared::ReuseSettings& settings, float old)
{
    const bool allocates = (settings.flags & shared::kReuseAllocates) != 0;
    return static_cast<uint32_t>(std::ceil((std::max(settings.rays, 1.0f) + old) *
                                           (allocates ? shared::kReuseMostPart : 1.0f)));
}

/// Those among which some are kept.
uint32_t freshPaths(const shared::ReuseSettings& settings)
{
    return settings.strategy == shared::kReuseFull ? 1 : mostPaths(settings, 0);
}

/// Places for paths that a lane may need; of `full` for chunks of them.
uint32_t placesOfLane(const shared::ReuseSettings& settings)
{
    if (settings.strategy != shared::kReuseFull) return freshPaths(settings);
    const uint32_t chunk = shared::pathsOfChunk(settings);
    return (std::min(mostPaths(settings, settings.cap), shared::kReuseMostFresh) + chunk - 1) /
           chunk;
}

/// Paths of `full`, each of so many rays at most, that a lane takes one after the other.
uint32_t chunkFor(bool software, uint32_t raysOfPath)
{
    const uint32_t rays = software ? kSoftwareRaysInARow : kRaysInARow;
    return std::clamp(rays / raysOfPath, 1u, 255u);
}

/// The constants of kernels with these settings: on software devices arrays whose lengths are known
/// lie in registers.
ReuseConstants specialised(ReuseConstants constants, const shared::ReuseSettings& settings)
{
    constants.records = recordsOf(settings);
    constants.lights = lightsOf(settings);
    constants.fresh = freshPaths(settings);
    return constants;
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
      weigh_(context.device, k_reuse_weigh, &context.layouts),
      new_{{context.device, k_reuse_new, &context.layouts},
           {context.device, k_reuse_new_panes, &context.layouts}},
      full_{{context.device, k_reuse_full, &context.layouts},
            {context.device, k_reuse_full_panes, &context.layouts}},
      old_{{context.device, k_reuse_old, &context.layouts},
           {context.device, k_reuse_old_panes, &context.layouts}},
      bounce_{{context.device, k_reuse_bounce, &context.layouts},
              {context.device, k_reuse_bounce_panes, &context.layouts}},
      hitsSets_(twoSets(context.device, hits_)), newSets_(twoSets(context.device, new_.plain)),
      weighSets_(twoSets(context.device, weigh_)), fullSets_(twoSets(context.device, full_.plain)),
      oldSets_(twoSets(context.device, old_.plain)),
      bounceSets_(twoSets(context.device, bounce_.plain)), motion_(context.device),
      queues_(context.device, "the queues", (kMostBounces + 1) * sizeof(shared::QueueHead))
{
    for (TwoSets* two : {&newSets_, &bounceSets_})
        for (DescriptorSet& set : *two) set.bind(shared::kBindPathQueues, queues_);
}

bool ReusePasses::takeMotion(const GpuScene& scene, const core::World& before,
                             const core::Bvh& hierarchyBefore,
                             std::span<const shared::MovedPiece> pieces)
{
    std::vector<DescriptorSet*> sets;
    for (TwoSets* two : {&hitsSets_, &newSets_, &bounceSets_, &weighSets_, &fullSets_, &oldSets_})
        for (DescriptorSet& set : *two) sets.push_back(&set);
    return motion_.take(scene, before, hierarchyBefore, pieces, sets);
}

void ReusePasses::prepare(glm::uvec2 size, uint32_t tiles, const shared::ReuseSettings& settings,
                          uint32_t raysOfPath, float perDeviation, bool chains)
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
    wanted.counts =
        shared::packChunk(wanted.counts, chunkFor(context_.device.isSoftware(), raysOfPath));
    if (wordsKept(wanted) != wordsKept(settings_)) {
        forget();
        stores_ = {};
    }
    settings_ = wanted;
    perDeviation_ = perDeviation;
    size_ = size;
    makeStore(side_);
    if (stores_[1 - side_].size.x == 0) makeStore(1 - side_);
    makeScratch(tiles, placesOfLane(wanted), chains);
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
    for (TwoSets* sets : {&hitsSets_, &newSets_, &weighSets_, &fullSets_, &oldSets_}) {
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
    const uint32_t most = context_.device.isSoftware() ? kMaxSoftwareLanes : kMaxLanes;
    const uint32_t lanes =
        std::min(std::bit_ceil(std::clamp(tiles * shared::kGroupSize, 1u << 12, most)),
                 std::max(std::bit_floor((takesAll() ? kMostChunks : kMostPaths) / rays),
                          shared::kGroupSize));
    const bool hasChains = chains_.bytes() > kWord;
    if (lanes_ >= lanes && mostRays_ >= rays && (hasChains || !chains) &&
        (hasTrails_ || takesAll()))
        return;
    lanes_ = 0;
    const uint64_t paths = uint64_t(lanes) * rays;
    const uint64_t trails = takesAll() ? 1 : paths;
    const auto make = [&](Buffer& buffer, uint64_t bytes, VkFormat format) {
        buffer = {};
        buffer = Buffer(context_.device, "the new samples", bytes, format);
    };
    constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT;
    make(newSamples_, paths * shared::kReuseNewWords * kWord, kWords);
    make(waiting_, paths * sizeof(uint32_t), VK_FORMAT_UNDEFINED);
    make(waitingHead_, sizeof(shared::WaitingHead), VK_FORMAT_UNDEFINED);
    make(firstNew_, lanes * sizeof(glm::uvec2), VK_FORMAT_R32G32_UINT);
    make(chains_, chains ? uint64_t(lanes) * shared::kReuseChainWords * kWord : kWord, kWords);
    make(trails_, trails * shared::kReuseTrailWords * kWord, kWords);
    make(gathered_, trails * kWord, VK_FORMAT_UNDEFINED);
    for (Buffer& side : paths_) make(side, trails * shared::kReuseStateWords * kWord, kWords);
    bindScratch();
    lanes_ = lanes;
    mostRays_ = rays;
    hasTrails_ = !takesAll();
}

/// Shows what kernels leave to each other to those that know it.
void ReusePasses::bindScratch()
{
    const auto bind = [&](uint32_t binding, const Buffer& buffer) {
        for (TwoSets* two :
             {&hitsSets_, &newSets_, &bounceSets_, &weighSets_, &fullSets_, &oldSets_})
            for (DescriptorSet& set : *two)
                if (set.knows(binding)) set.bind(binding, buffer);
    };
    bind(shared::kBindNewSamples, newSamples_);
    bind(shared::kBindWaiting, waiting_);
    bind(shared::kBindWaitingHead, waitingHead_);
    bind(shared::kBindFirstNew, firstNew_);
    bind(shared::kBindChainsNow, chains_);
    bind(shared::kBindChains, chains_);
    bind(shared::kBindTrails, trails_);
    bind(shared::kBindTrailsNow, trails_);
    bind(shared::kBindPathGathered, gathered_);
    for (uint32_t side = 0; side < 2; ++side) {
        newSets_[side].bind(shared::kBindPathStates, paths_[0]);
        bounceSets_[side].bind(shared::kBindPathTexels, paths_[side]);
        bounceSets_[side].bind(shared::kBindPathStates, paths_[1 - side]);
    }
}

void ReusePasses::record(VkCommandBuffer commands, const GpuScene& scene, const Frame& frame,
                         const ReuseConstants& constants, const shared::ReuseBatch& push,
                         uint32_t groups)
{
    const shared::WaitingHead nobody{{0, 1, 1, 0}, perDeviation_};
    vk.CmdUpdateBuffer(commands, waitingHead_.get(), 0, sizeof(nobody), &nobody);
    barrier(commands);
    const auto sets = [&](const TwoSets& own) {
        return KernelSets{&scene.set(), &frame.set(), &own[side_]};
    };
    hits_.dispatch(commands, hits_.pipeline(constants), sets(hitsSets_), push, groups);
    barrier(commands);
    if (takesAll()) {
        ReuseKernel& full = full_.of(constants);
        full.dispatchIndirect(commands, full.pipeline(constants), sets(fullSets_), push,
                              waitingHead_, 0);
    } else {
        recordNewPaths(commands, scene, frame, constants, push);
    }
    barrier(commands);
    ReuseKernel& old = old_.of(constants);
    old.dispatch(commands, old.pipeline(constants), sets(oldSets_), push, groups);
    barrier(commands);
}

/// The sizes of queues stay on the device: of bounces that no path needs nothing is dispatched.
void ReusePasses::recordNewPaths(VkCommandBuffer commands, const GpuScene& scene,
                                 const Frame& frame, const ReuseConstants& constants,
                                 const shared::ReuseBatch& push)
{
    std::array<shared::QueueHead, kMostBounces + 1> heads;
    heads.fill({0, 1, 1, 0});
    vk.CmdUpdateBuffer(commands, queues_.get(), 0, sizeof(heads), heads.data());
    barrier(commands);
    const auto sets = [&](const DescriptorSet& own) {
        return KernelSets{&scene.set(), &frame.set(), &own};
    };
    ReuseKernel& first = new_.of(constants);
    first.dispatchIndirect(commands, first.pipeline(constants), sets(newSets_[side_]), push,
                           waitingHead_, 0);
    BounceKernel& bounce = bounce_.of(constants);
    const uint32_t bounces = std::min(frame.data().settings.maxDepth + 1, kMostBounces);
    for (uint32_t b = 0; b < bounces; ++b) {
        barrier(commands);
        bounce.dispatchIndirect(commands, bounce.pipeline(constants), sets(bounceSets_[b % 2]),
                                {push.batch, push.settings, b}, queues_,
                                b * sizeof(shared::QueueHead));
    }
    barrier(commands);
    weigh_.dispatchIndirect(commands, weigh_.pipeline(constants), sets(weighSets_[side_]), push,
                            waitingHead_, 0);
}

void ReusePasses::makePipelines(const ReuseConstants& constants)
{
    hits_.pipeline(constants);
    old_.of(constants).pipeline(constants);
    if (takesAll()) {
        full_.of(constants).pipeline(constants);
        return;
    }
    new_.of(constants).pipeline(constants);
    bounce_.of(constants).pipeline(constants);
    weigh_.pipeline(constants);
}

bool ReusePasses::hasKernels(const ReuseConstants& wanted,
                             const shared::ReuseSettings& settings) const
{
    const ReuseConstants constants = specialised(wanted, settings);
    const TwoForms<ReuseKernel>& paths = settings.strategy == shared::kReuseFull ? full_ : new_;
    return old_.of(constants).isCompiled(constants) && paths.of(constants).isCompiled(constants);
}

bool ReusePasses::compile(const GpuScene& scene, const Frame& frame, const ReuseConstants& wanted)
{
    if (hasKernels(wanted, settings_)) return false;
    const ReuseConstants constants = specialised(wanted, settings_);
    makePipelines(constants);  // where failing leaves no half-recorded commands
    shared::ReuseBatch nothing{};
    nothing.settings = settings_;
    context_.device.submit(
        [&](VkCommandBuffer commands) {
            record(commands, scene, frame, constants, nothing, 1);
            // No path waits, but the driver compiles what is dispatched.
            const auto sets = [&](const DescriptorSet& own) {
                return KernelSets{&scene.set(), &frame.set(), &own};
            };
            const auto one = [&](const auto& kernel, const Pipeline& pipeline,
                                 const DescriptorSet& own, const auto& push) {
                kernel.dispatch(commands, pipeline, sets(own), push, 1);
                barrier(commands);
            };
            if (takesAll()) {
                ReuseKernel& full = full_.of(constants);
                one(full, full.pipeline(constants), fullSets_[side_], nothing);
                return;
            }
            ReuseKernel& first = new_.of(constants);
            BounceKernel& bounce = bounce_.of(constants);
            one(first, first.pipeline(constants), newSets_[side_], nothing);
            one(bounce, bounce.pipeline(constants), bounceSets_[0],
                shared::ReuseBounceBatch{nothing.batch, nothing.settings, 0});
            one(weigh_, weigh_.pipeline(constants), weighSets_[side_], nothing);
        },
        "the compilation of the kernels");
    return true;
}

double ReusePasses::run(const GpuScene& scene, const Frame& frame, const ReuseConstants& wanted,
                        const shared::Batch& batch, uint32_t flags)
{
    const ReuseConstants constants = specialised(wanted, settings_);
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
