// See slice_oracle.h.
#include "core/many_lights/slice_oracle.h"

#include <bit>

#include "core/many_lights/shadow_packets.h"

namespace core::many_lights {

namespace {

/// One ray after the other: bit i is 1 where ray i is blocked.
uint32_t occludedOneByOne(const Accel& accel, const RayPacket& p, uint32_t count)
{
    uint32_t blocked = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const Ray ray{{p.originX[i], p.originY[i], p.originZ[i]},
                      p.tMax[i],
                      {p.directionX[i], p.directionY[i], p.directionZ[i]},
                      p.seed[i]};
        blocked |= (accel.occluded(ray) ? 1u : 0u) << i;
    }
    return blocked;
}

}  // namespace

void SliceOracle::trace(std::span<const TraceRequest> requests)
{
    if (stop_.stop_requested()) return;
    ShadowPacker packer(accel_, rows_, [this](const RayPacket& rays, uint32_t size) {
        return packets_ ? accel_.occluded(rays, size) : occludedOneByOne(accel_, rays, size);
    });
    for (const TraceRequest& request : requests)
        packer.addAll(columns_[request.column], request.rows, request.visible);
    packer.flush();
}

size_t packShadowRays(const Accel& accel, const SliceRows& rows, std::span<const Column> columns,
                      const BitMatrix& matters, std::vector<RayPacket>& packets)
{
    packets.clear();
    size_t rays = 0;
    ShadowPacker packer(accel, rows, [&](const RayPacket& packet, uint32_t size) {
        packets.push_back(packet);
        rays += size;
        return 0u;
    });
    Words visible(wordsFor(rows.count()));
    for (uint32_t j = 0; j < columns.size(); ++j)
        packer.addAll(columns[j], matters.column(j).data(), visible.data());
    packer.flush();
    return rays;
}

}  // namespace core::many_lights
