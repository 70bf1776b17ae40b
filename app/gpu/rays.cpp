// Rays in a texel buffer, hits in a storage buffer, one dispatch. See rays.h.
#include "app/gpu/rays.h"

#include "spirv/bench_any.h"
#include "spirv/bench_closest.h"

namespace gpu {

GpuRays::GpuRays(Device& device, const core::World& world, bool alpha)
    : device_(device), layouts_(device), scene_(device, layouts_, world, {}),
      frame_(device, layouts_), closest_(device, k_bench_closest, &layouts_),
      any_(device, k_bench_any, &layouts_), closestSet_(device, closest_.own()),
      anySet_(device, any_.own()), constants_{alpha ? scene_.features()
                                                    : scene_.features() & ~shared::kFeatureAlpha}
{
    shared::FrameData frame{};
    frame.entry = scene_.entry();
    frame_.write(frame);
}

void GpuRays::setRays(std::span<const DeviceRay> rays)
{
    count_ = static_cast<uint32_t>(rays.size());
    rays_ = {};
    hits_ = {};
    rays_ = Buffer(device_, "the rays", rays.size_bytes(), VK_FORMAT_R32G32B32A32_UINT);
    hits_ = Buffer(device_, "the hits", rays.size() * sizeof(DeviceHit));
    rays_.write(std::as_bytes(rays));
    for (DescriptorSet* set : {&closestSet_, &anySet_}) {
        set->bind(shared::kBindRays, rays_);
        set->bind(shared::kBindHits, hits_);
    }
}

double GpuRays::trace(RayKernel& kernel, const DescriptorSet& set)
{
    const Pipeline& pipeline = kernel.pipeline(constants_);
    return device_.submit([&](VkCommandBuffer commands) {
        const GroupRows groups = groupRows(count_);
        kernel.dispatch(commands, pipeline, {&scene_.set(), &frame_.set(), &set}, {count_},
                        groups.x, groups.y);
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
