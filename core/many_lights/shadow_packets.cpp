// See shadow_packets.h.
#include "core/many_lights/shadow_packets.h"

namespace core::many_lights {

void layOutRun(const SliceRows& rows, const ShadowTarget& target, uint32_t first, bool blends,
               RayPacket& rays)
{
    const float* x = rows.originX().data() + first;
    const float* y = rows.originY().data() + first;
    const float* z = rows.originZ().data() + first;
    const float perOrigin = target.distant ? 0.0f : 1.0f;
    for (uint32_t i = 0; i < RayPacket::kSize; ++i) {
        rays.originX[i] = x[i];
        rays.originY[i] = y[i];
        rays.originZ[i] = z[i];
        rays.directionX[i] = target.at.x - perOrigin * x[i];
        rays.directionY[i] = target.at.y - perOrigin * y[i];
        rays.directionZ[i] = target.at.z - perOrigin * z[i];
    }
    if (target.distant)
        rays.tMax.fill(shared::kDistant);
    else
        for (uint32_t i = 0; i < RayPacket::kSize; ++i)
            rays.tMax[i] = endTowards({rays.directionX[i], rays.directionY[i], rays.directionZ[i]});
    rays.seed.fill(0);
    if (!blends) return;
    const uint32_t* seeds = rows.seeds().data() + first;
    for (uint32_t i = 0; i < RayPacket::kSize; ++i)
        rays.seed[i] = shared::hashUint(target.seed ^ seeds[i]);
}

}  // namespace core::many_lights
