// See slice_oracle.h.
#include "core/many_lights/slice_oracle.h"

#include <array>
#include <bit>

#include "shared/emitter.h"

namespace core::many_lights {

namespace {

/// Collects rays until sixteen are together.
class Packer {
public:
    Packer(const Accel& accel, const SliceRows& rows, std::span<const Column> columns)
        : accel_(accel), rows_(rows), columns_(columns),
          blends_((accel.world().features & shared::kFeatureAlpha) != 0)
    {}

    void add(const TraceRequest& request)
    {
        const Column& column = columns_[request.column];
        const VirtualLight& light = *column.light;
        const bool distant = light.kind == LightKind::directional;
        const glm::vec3 target = distant ? -light.normal : light.position;
        // A light on a surface must not be blocked by that surface.
        const float tMax = distant ? shared::kDistant : 0.9999f;
        const float perOrigin = distant ? 0.0f : 1.0f;
        const float* x = rows_.originX().data();
        const float* y = rows_.originY().data();
        const float* z = rows_.originZ().data();
        const uint32_t words = wordsFor(rows_.count());
        const bool transmits = rows_.anyTransmits();
        uint32_t size = size_;
        for (uint32_t w = 0; w < words; ++w)
            for (uint64_t rest = request.rows[w]; rest != 0; rest &= rest - 1) {
                const uint32_t row = 64 * w + static_cast<uint32_t>(std::countr_zero(rest));
                const uint32_t origin = transmits ? originOf(row, target, perOrigin) : row;
                packet_.originX[size] = x[origin];
                packet_.originY[size] = y[origin];
                packet_.originZ[size] = z[origin];
                packet_.directionX[size] = target.x - perOrigin * x[origin];
                packet_.directionY[size] = target.y - perOrigin * y[origin];
                packet_.directionZ[size] = target.z - perOrigin * z[origin];
                packet_.tMax[size] = tMax;
                packet_.seed[size] =
                    blends_ ? shared::hashUint(column.seed ^ rows_.seeds()[row]) : 0u;
                word_[size] = request.visible + w;
                bit_[size] = rest & (~rest + 1);
                if (++size == RayPacket::kSize) {
                    size_ = size;
                    flush();
                    size = 0;
                }
            }
        size_ = size;
    }

    void flush()
    {
        if (size_ == 0) return;
        const uint32_t blocked = accel_.occluded(packet_, size_);
        for (uint32_t i = 0; i < size_; ++i) *word_[i] |= (blocked >> i & 1u) != 0 ? 0 : bit_[i];
        size_ = 0;
    }

private:
    /// Where the ray of a row begins: behind it for light from there.
    uint32_t originOf(uint32_t row, const glm::vec3& target, float perOrigin) const
    {
        const glm::vec3 from(rows_.originX()[row], rows_.originY()[row], rows_.originZ()[row]);
        return rows_.fromBehind(row, target - perOrigin * from) ? rows_.count() + row : row;
    }

    const Accel& accel_;
    const SliceRows& rows_;
    std::span<const Column> columns_;
    bool blends_;
    RayPacket packet_;
    std::array<uint64_t*, RayPacket::kSize> word_;
    std::array<uint64_t, RayPacket::kSize> bit_;
    uint32_t size_ = 0;
};

}  // namespace

void SliceOracle::trace(std::span<const TraceRequest> requests)
{
    if (stop_.stop_requested()) return;
    Packer packer(accel_, rows_, columns_);
    for (const TraceRequest& request : requests) packer.add(request);
    packer.flush();
}

}  // namespace core::many_lights
