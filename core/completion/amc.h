// Adaptive matrix completion: a column is a linear combination of known columns, found by least
// squares on sampled rows (A. Krishnamurthy, A. Singh, "Low-Rank Matrix and Tensor Completion via
// Adaptive Sampling", 2013, as used in S. Wang, N. Holzschuch, "Adaptive Matrix Completion for Fast
// Visibility Computations with Many Lights Rendering", 2020). Entries are -1 and 1; columns are
// kept as they are, not orthogonalized. What differs: the combination is applied as n r
// multiplications instead of n m, and with CompletionParams::guard more rows are sampled than there
// are known columns, because fewer are explained exactly by any column.
#pragma once

#include "core/completion/dense.h"
#include "core/completion/linear_octant.h"

namespace core::many_lights {

class AmcOctant : public LinearOctant {
public:
    AmcOctant(Tracer& tracer, std::span<const uint32_t> columns, const CompletionParams& params,
              uint64_t seed, CompletedSlice& out);

private:
    uint32_t basisSize() const override { return static_cast<uint32_t>(basis_.size()); }
    uint32_t chooseRows(std::span<const uint64_t> matters, Words& rows) override;
    bool predict(std::span<const uint64_t> column, std::span<const uint64_t> matters,
                 const Words& samples) override;
    void append(std::span<const uint64_t> column) override;

    std::vector<std::vector<float>> basis_;  // columns of -1 and 1
    Words sampledRows_;
    std::vector<uint32_t> numbers_;  // of these rows
    uint32_t drawn_ = 0;             // how many draws that took; 0: the basis has grown since
    Matrix sampled_, inverse_;       // the basis in these rows, and its pseudo-inverse
};

}  // namespace core::many_lights
