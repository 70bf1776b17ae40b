// Shadow rays from rows of a slice to lights, collected until sixteen are together.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "core/completion/bits.h"
#include "core/many_lights/slice_rows.h"
#include "core/trace/accel.h"
#include "shared/connection.h"

namespace core::many_lights {

/// What all rays to one column have in common.
struct ShadowTarget {
    explicit ShadowTarget(const Column& column)
        : distant(column.light->kind == LightKind::directional),
          at(distant ? -column.light->normal : column.light->position), seed(column.seed)
    {}

    bool distant;
    glm::vec3 at;
    uint32_t seed;
};

/// A packet and where its answers go: word and bit of each ray.
struct ShadowPack {
    RayPacket rays;
    std::array<uint64_t*, RayPacket::kSize> word;
    std::array<uint64_t, RayPacket::kSize> bit;

    /// Sets the bits of rays that nothing blocks.
    void answer(uint32_t blocked, uint32_t size) const
    {
        for (uint32_t i = 0; i < size; ++i) *word[i] |= (blocked >> i & 1u) != 0 ? 0 : bit[i];
    }
};

/// Collects rays for `take(pack, size)`.
template <class Take> class ShadowPacker {
public:
    /// Keeps both by reference.
    ShadowPacker(const Accel& accel, const SliceRows& rows, Take take)
        : take_(std::move(take)), rows_(rows), transmits_(rows.anyTransmits()),
          blends_((accel.world().features & shared::kFeatureAlpha) != 0)
    {}

    /// A ray from the row to the light, whose answer goes to `bit` of `word`.
    void add(const ShadowTarget& target, uint32_t row, uint64_t* word, uint64_t bit)
    {
        const float perOrigin = target.distant ? 0.0f : 1.0f;
        const uint32_t origin = transmits_ ? originOf(row, target.at, perOrigin) : row;
        const float x = rows_.originX()[origin], y = rows_.originY()[origin],
                    z = rows_.originZ()[origin];
        RayPacket& rays = pack_.rays;
        const glm::vec3 direction(target.at.x - perOrigin * x, target.at.y - perOrigin * y,
                                  target.at.z - perOrigin * z);
        rays.originX[size_] = x;
        rays.originY[size_] = y;
        rays.originZ[size_] = z;
        rays.directionX[size_] = direction.x;
        rays.directionY[size_] = direction.y;
        rays.directionZ[size_] = direction.z;
        rays.tMax[size_] = target.distant ? shared::kDistant : endTowards(direction);
        rays.seed[size_] = blends_ ? shared::hashUint(target.seed ^ rows_.seeds()[row]) : 0u;
        pack_.word[size_] = word;
        pack_.bit[size_] = bit;
        if (++size_ == RayPacket::kSize) flush();
    }

    /// Rays from all rows of a mask, whose answers go to the same bits of `visible`.
    void addAll(const Column& column, const uint64_t* rows, uint64_t* visible)
    {
        const ShadowTarget target(column);
        const uint32_t words = wordsFor(rows_.count());
        for (uint32_t w = 0; w < words; ++w)
            for (uint64_t rest = rows[w]; rest != 0; rest &= rest - 1)
                add(target, 64 * w + static_cast<uint32_t>(std::countr_zero(rest)), visible + w,
                    rest & (~rest + 1));
    }

    /// Hands on what has been collected.
    void flush()
    {
        if (size_ > 0) take_(pack_, size_);
        size_ = 0;
    }

private:
    /// How far a ray goes whose length reaches a light: a light on a surface must not be blocked by
    /// that surface. As shared::connectionEnd; only beyond ten units does that ask for a root.
    static float endTowards(const glm::vec3& direction)
    {
        const float squared = glm::dot(direction, direction);
        return squared > 100.0f ? shared::connectionEnd(std::sqrt(squared)) : 0.9999f;
    }

    /// Where the ray of a row begins: behind it for light from there.
    uint32_t originOf(uint32_t row, const glm::vec3& target, float perOrigin) const
    {
        const glm::vec3 from(rows_.originX()[row], rows_.originY()[row], rows_.originZ()[row]);
        return rows_.fromBehind(row, target - perOrigin * from) ? rows_.count() + row : row;
    }

    Take take_;
    const SliceRows& rows_;
    bool transmits_, blends_;
    ShadowPack pack_;
    uint32_t size_ = 0;
};

/// Traces packets as soon as they are full.
struct TracePack {
    const Accel& accel;
    void operator()(const ShadowPack& pack, uint32_t size) const
    {
        pack.answer(accel.occluded(pack.rays, size), size);
    }
};

/// Collects rays and traces them: add() sets bits when nothing lies between row and light, not
/// before flush().
class ShadowPackets : public ShadowPacker<TracePack> {
public:
    ShadowPackets(const Accel& accel, const SliceRows& rows)
        : ShadowPacker(accel, rows, TracePack{accel})
    {}
};

}  // namespace core::many_lights
