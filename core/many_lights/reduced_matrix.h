// The reduced matrix of many lights: what a few receivers (rows) get from every light (columns),
// visibility included. Columns that are alike there are taken to be alike everywhere (M. Hasan, F.
// Pellacini, K. Bala, "Matrix Row-Column Sampling for the Many-Light Problem", 2007). What differs:
// an entry is a luminance, not a colour, a third of the memory.
#pragma once

#include <optional>

#include "core/many_lights/slice_job.h"

namespace core::many_lights {

class ReducedMatrix {
public:
    static constexpr uint32_t kLanes = 8;

    ReducedMatrix() = default;
    ReducedMatrix(uint32_t rows, uint32_t columns) { reset(rows, columns); }

    /// That a matrix of so many rows and columns takes.
    static uint64_t bytes(uint64_t rows, uint64_t columns)
    {
        return ((rows + kLanes - 1) / kLanes * kLanes + 1) * columns * sizeof(float);
    }

    /// All zero, of another size; memory is kept.
    void reset(uint32_t rows, uint32_t columns);

    uint32_t rows() const { return rows_; }
    uint32_t columns() const { return static_cast<uint32_t>(norms_.size()); }
    /// A column, padded with zeros to whole lanes.
    std::span<float> column(uint32_t j) { return {values_.data() + size_t(j) * stride_, stride_}; }
    std::span<const float> column(uint32_t j) const
    {
        return {values_.data() + size_t(j) * stride_, stride_};
    }
    /// Its length; of use once updateNorm has been called after the last change.
    float norm(uint32_t j) const { return norms_[j]; }
    void updateNorm(uint32_t j);

private:
    uint32_t rows_ = 0, stride_ = 0;
    std::vector<float> values_, norms_;
};

/// Inner product of padded columns. The order of the sum is always the same.
float innerProduct(std::span<const float> a, std::span<const float> b);

/// Traces the matrix of the receivers that `chosen` lists against all lights of the job; adds its
/// shadow rays to `rays`. Nothing when `stop` came first.
std::optional<ReducedMatrix> traceReducedMatrix(const SliceJob& job,
                                                std::span<const Receiver> receivers,
                                                std::span<const uint32_t> chosen,
                                                const std::stop_token& stop, uint64_t& rays);

}  // namespace core::many_lights
