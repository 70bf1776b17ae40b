// Visibility between the rows of a slice and its columns, traced in packets of sixteen, or ray by
// ray.
#pragma once

#include <stop_token>

#include "core/completion/completion.h"
#include "core/many_lights/slice_rows.h"

namespace core::many_lights {

class SliceOracle final : public VisibilityOracle {
public:
    /// Everything is kept by reference. `matters` has a column for each of `columns`, `brightness`
    /// an entry, or none where it is not known. Once `stop` is requested the answers mean nothing.
    SliceOracle(const Accel& accel, const SliceRows& rows, std::span<const Column> columns,
                const BitMatrix& matters, std::stop_token stop, bool packets = true,
                std::span<const float> brightness = {})
        : accel_(accel), rows_(rows), columns_(columns), matters_(matters), brightness_(brightness),
          stop_(std::move(stop)), packets_(packets)
    {}

    void trace(std::span<const TraceRequest> requests) override;
    const uint64_t* matters(uint32_t column) const override
    {
        return matters_.column(column).data();
    }
    std::optional<float> brightness(uint32_t column) const override
    {
        return brightness_.empty() ? std::nullopt : std::optional(brightness_[column]);
    }

private:
    const Accel& accel_;
    const SliceRows& rows_;
    std::span<const Column> columns_;
    const BitMatrix& matters_;
    std::span<const float> brightness_;
    std::stop_token stop_;
    bool packets_;
};

/// The packets in which all rays between rows and columns that matter are traced, for measurements
/// of the tracing alone. All are full but the last; returns the number of rays.
size_t packShadowRays(const Accel& accel, const SliceRows& rows, std::span<const Column> columns,
                      const BitMatrix& matters, std::vector<RayPacket>& packets);

}  // namespace core::many_lights
