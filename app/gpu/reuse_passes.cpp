// See reuse_passes.h.
#include "app/gpu/reuse_passes.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "spirv/reuse_hits.h"
#include "spirv/reuse_new.h"
#include "spirv/reuse_old.h"

namespace gpu {

namespace {

constexpr uint32_t kMaxLanes =
    1u << 16;  // of a batch: what kernels leave to each other stays small
constexpr uint64_t kWord = 16;

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
      oldSets_(twoSets(context.device, old_))
{}

void ReusePasses::prepare(glm::uvec2 size, uint32_t tiles, const shared::ReuseSettings& settings)
{
    const uint64_t pixels = uint64_t(size.x) * size.y;
    shared::ReuseSettings wanted = settings;
    const uint64_t fits = context_.device.limits().maxStorageBufferRange / (pixels * kWord);
    wanted.records = static_cast<uint32_t>(std::clamp<uint64_t>(fits, 1, settings.records));
    wanted.lights = static_cast<uint32_t>(std::clamp<uint64_t>(fits, 1, settings.lights));
    if (wanted.records != settings_.records || wanted.lights != settings_.lights) {
        forget();
        stores_ = {};
    }
    settings_ = wanted;
    size_ = size;
    makeStore(side_);
    if (stores_[1 - side_].size.x == 0) makeStore(1 - side_);
    makeScratch(tiles);
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
        buffer = Buffer(context_.device, "the kept samples", pixels * perPixel * kWord, format);
    };
    constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT;
    store.means = {};  // first and last: its size tells whether all could be had
    make(store.pixels, 1, kWords);
    make(store.places, settings_.records, kWords);
    make(store.arriving, settings_.records, kWords);
    make(store.lights, settings_.lights, kWords);
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
    DescriptorSet& reads = oldSets_[1 - side];
    reads.bind(shared::kBindPlacesBefore, store.places);
    reads.bind(shared::kBindArrivingBefore, store.arriving);
    reads.bind(shared::kBindLightsBefore, store.lights);
    reads.bind(shared::kBindMeansBefore, store.means);
}

void ReusePasses::makeScratch(uint32_t tiles)
{
    const uint32_t lanes =
        std::bit_ceil(std::clamp(tiles * shared::kGroupSize, 1u << 12, kMaxLanes));
    if (lanes_ >= lanes) return;
    lanes_ = 0;
    newSamples_ = {};
    newSamples_ =
        Buffer(context_.device, "the new samples", uint64_t(lanes) * shared::kReuseNewWords * kWord,
               VK_FORMAT_R32G32B32A32_UINT);
    for (auto* sets : {&newSets_, &oldSets_})
        for (DescriptorSet& set : *sets) set.bind(shared::kBindNewSamples, newSamples_);
    lanes_ = lanes;
}

void ReusePasses::record(VkCommandBuffer commands, const GpuScene& scene, const Frame& frame,
                         const ReuseConstants& constants, const shared::ReuseBatch& push,
                         uint32_t groups)
{
    const auto dispatch = [&](ReuseKernel& kernel, const std::array<DescriptorSet, 2>& sets) {
        kernel.dispatch(commands, kernel.pipeline(constants),
                        {&scene.set(), &frame.set(), &sets[side_]}, push, groups);
        barrier(commands);
    };
    dispatch(hits_, hitsSets_);
    dispatch(new_, newSets_);
    dispatch(old_, oldSets_);
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
        [&](VkCommandBuffer commands) { record(commands, scene, frame, constants, nothing, 1); },
        "the compilation of the kernels");
    return true;
}

double ReusePasses::run(const GpuScene& scene, const Frame& frame, const ReuseConstants& constants,
                        const shared::Batch& batch, uint32_t flags)
{
    shared::ReuseBatch push{batch, settings_, camera_};
    push.settings.flags = flags;
    const glm::uvec2 before = stores_[1 - side_].size;
    push.settings.sizeBefore = before.x | (before.y << 16);
    if (settings_.strategy == shared::kReuseDiscard) push.cameraBefore = {};
    return context_.device.submit(
        [&](VkCommandBuffer commands) {
            record(commands, scene, frame, constants, push, batch.tileCount);
        },
        "sample reuse, tiles " + std::to_string(batch.firstTile) + " to " +
            std::to_string(batch.firstTile + batch.tileCount - 1) + " of " +
            std::to_string(frame.tileCount()));
}

void ReusePasses::commit(const shared::CameraData& camera)
{
    camera_ = camera;
    side_ = 1 - side_;
    makeStore(side_);  // it may be that of a smaller picture
}

}  // namespace gpu
