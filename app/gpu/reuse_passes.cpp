// See reuse_passes.h.
#include "app/gpu/reuse_passes.h"

#include <algorithm>
#include <bit>

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
    const bool fitsStores = pixels == pixels_ && wanted.records == settings_.records &&
                            wanted.lights == settings_.lights;
    settings_ = wanted;
    if (!fitsStores) makeStores(pixels);
    makeScratch(tiles);
}

void ReusePasses::makeStores(uint64_t pixels)
{
    forget();
    pixels_ = 0;
    stores_ = {};
    Device& device = context_.device;
    for (Store& store : stores_) {
        const auto make = [&](uint64_t perPixel, VkFormat format = VK_FORMAT_R32G32B32A32_UINT) {
            return Buffer(device, "the kept samples", pixels * perPixel * kWord, format);
        };
        store.pixels = make(1);
        store.places = make(settings_.records);
        store.arriving = make(settings_.records);
        store.lights = make(settings_.lights);
        store.means = make(1, VK_FORMAT_R32G32B32A32_SFLOAT);
    }
    for (uint32_t side = 0; side < 2; ++side) {
        const Store& now = stores_[side];
        const Store& before = stores_[1 - side];
        for (auto* sets : {&hitsSets_, &newSets_, &oldSets_}) {
            (*sets)[side].bind(shared::kBindPixelsNow, now.pixels);
            (*sets)[side].bind(shared::kBindPixelsBefore, before.pixels);
        }
        DescriptorSet& old = oldSets_[side];
        old.bind(shared::kBindPlacesBefore, before.places);
        old.bind(shared::kBindArrivingBefore, before.arriving);
        old.bind(shared::kBindLightsBefore, before.lights);
        old.bind(shared::kBindMeansBefore, before.means);
        old.bind(shared::kBindPlacesNow, now.places);
        old.bind(shared::kBindArrivingNow, now.arriving);
        old.bind(shared::kBindLightsNow, now.lights);
        old.bind(shared::kBindMeansNow, now.means);
    }
    pixels_ = pixels;
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
                        const shared::Batch& batch, bool jitters, bool follows)
{
    shared::ReuseBatch push{batch, settings_, camera_};
    push.settings.jitters = jitters ? 1 : 0;
    push.settings.follows = follows ? 1 : 0;
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
}

}  // namespace gpu
