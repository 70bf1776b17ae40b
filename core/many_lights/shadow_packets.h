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

/// Lays out the rays of sixteen neighbouring rows, `first` and those after it. `blends`: their
/// seeds matter, which are 0 otherwise. Of slices through no row of which light passes.
void layOutRun(const SliceRows& rows, const ShadowTarget& target, uint32_t first, bool blends,
               RayPacket& rays);

/// How far a ray goes whose length reaches a light: a light on a surface must not be blocked by
/// that surface. As shared::connectionEnd; only beyond ten units does that ask for a root.
inline float endTowards(const glm::vec3& direction)
{
    const float squared = glm::dot(direction, direction);
    return squared > 100.0f ? shared::connectionEnd(std::sqrt(squared)) : 0.9999f;
}

/// Collects rays for `take(rays, size)`, which returns a bit for each: 1 where it is blocked.
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
        const glm::vec3 direction(target.at.x - perOrigin * x, target.at.y - perOrigin * y,
                                  target.at.z - perOrigin * z);
        rays_.originX[size_] = x;
        rays_.originY[size_] = y;
        rays_.originZ[size_] = z;
        rays_.directionX[size_] = direction.x;
        rays_.directionY[size_] = direction.y;
        rays_.directionZ[size_] = direction.z;
        rays_.tMax[size_] = target.distant ? shared::kDistant : endTowards(direction);
        rays_.seed[size_] = blends_ ? shared::hashUint(target.seed ^ rows_.seeds()[row]) : 0u;
        word_[size_] = word;
        bit_[size_] = bit;
        if (++size_ == RayPacket::kSize) flush();
    }

    /// Rays from all rows of a mask, whose answers go to the same bits of `visible`. Sixteen
    /// neighbours are a packet of their own, which is laid out in vectors.
    void addAll(const Column& column, const uint64_t* rows, uint64_t* visible)
    {
        const ShadowTarget target(column);
        const uint32_t words = wordsFor(rows_.count());
        for (uint32_t w = 0; w < words; ++w) {
            uint64_t rest = rows[w];
            if (!transmits_)
                for (uint64_t runs = runsOf(rest); runs != 0; runs = runsOf(rest)) {
                    const auto i = static_cast<uint32_t>(std::countr_zero(runs));
                    traceRun(target, 64 * w + i, visible + w, i);
                    rest &= ~(kRun << i);
                }
            for (; rest != 0; rest &= rest - 1)
                add(target, 64 * w + static_cast<uint32_t>(std::countr_zero(rest)), visible + w,
                    rest & (~rest + 1));
        }
    }

    /// Hands on what has been collected.
    void flush()
    {
        if (size_ == 0) return;
        const uint32_t blocked = take_(rays_, size_);
        for (uint32_t i = 0; i < size_; ++i) *word_[i] |= (blocked >> i & 1u) != 0 ? 0 : bit_[i];
        size_ = 0;
    }

private:
    static constexpr uint64_t kRun = (uint64_t(1) << RayPacket::kSize) - 1;

    /// Where sixteen bits in a row begin that are set.
    static uint64_t runsOf(uint64_t bits)
    {
        for (uint32_t step = 1; step < RayPacket::kSize; step *= 2) bits &= bits >> step;
        return bits;
    }

    void traceRun(const ShadowTarget& target, uint32_t first, uint64_t* word, uint32_t shift)
    {
        layOutRun(rows_, target, first, blends_, run_);
        *word |= (~uint64_t(take_(run_, RayPacket::kSize)) & kRun) << shift;
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
    RayPacket rays_, run_;
    // Where the answers of rays_ go.
    RayPacket::Lanes<uint64_t*> word_;
    RayPacket::Lanes<uint64_t> bit_;
    uint32_t size_ = 0;
};

/// Traces packets as soon as they are full.
struct TracePack {
    const Accel& accel;
    uint32_t operator()(const RayPacket& rays, uint32_t size) const
    {
        return accel.occluded(rays, size);
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
