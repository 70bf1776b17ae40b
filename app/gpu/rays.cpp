// Rays in a texel buffer, hits in a storage buffer, one dispatch. See rays.h.
#include "app/gpu/rays.h"

#include "spirv/bench_any.h"
#include "spirv/bench_closest.h"

namespace gpu {

static Specialization specializationFor(uint32_t features, bool alpha)
{
    Specialization s;
    s.features = alpha ? features : features & ~shared::kFeatureAlpha;
    return s;
}

GpuRays::GpuRays(Device& device, const core::World& world, bool alpha)
    : device_(device), layout_(device), bindings_(device, layout_), scene_(device, world, {}),
      frame_(device, "the frame's settings", sizeof(shared::FrameData)),
      closest_(device, layout_, k_bench_closest, specializationFor(world.features, alpha)),
      any_(device, layout_, k_bench_any, specializationFor(world.features, alpha))
{
    shared::FrameData frame{};
    frame.gridLow = scene_.gridLow();
    frame.gridScale = scene_.gridScale();
    frame_.write(std::as_bytes(std::span(&frame, 1)));
    scene_.bind(bindings_);
    bindings_.bind(shared::kBindFrame, frame_);
}

void GpuRays::setRays(std::span<const DeviceRay> rays)
{
    count_ = static_cast<uint32_t>(rays.size());
    rays_ = {};
    hits_ = {};
    rays_ = Buffer(device_, "the rays", rays.size_bytes(), texelFormat(shared::kBindStateTexels));
    hits_ = Buffer(device_, "the hits", rays.size() * sizeof(DeviceHit));
    rays_.write(std::as_bytes(rays));
    bindings_.bind(shared::kBindStateTexels, rays_);
    bindings_.bind(shared::kBindOutput, hits_);
}

double GpuRays::trace(const Pipeline& pipeline)
{
    const shared::Batch batch{0, 0, 0, count_, 0};
    return device_.submit([&](VkCommandBuffer commands) {
        bindings_.use(commands, layout_);
        vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
        vk.CmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(batch),
                            &batch);
        vk.CmdDispatch(commands, (count_ + shared::kGroupSize - 1) / shared::kGroupSize, 1, 1);
        barrier(commands);
    });
}

std::vector<DeviceHit> GpuRays::hits() const
{
    std::vector<DeviceHit> hits(count_);
    hits_.read(std::as_writable_bytes(std::span(hits)));
    return hits;
}

}  // namespace gpu
