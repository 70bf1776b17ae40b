// Completion by sums of known columns over GF(2) (S. Wang, "Efficient Sample Usage in
// Photo-Realistic Rendering", 2022, section 5.6.1). What differs: the basis grows by one
// elimination step instead of being eliminated anew, and with CompletionParams::guard every pivot
// row is sampled, because a sum is arbitrary in columns whose pivots are not.
#pragma once

#include "core/completion/linear_octant.h"

namespace core::many_lights {

/// Columns in reduced row-echelon form: each has a pivot row in which it alone is 1.
class EchelonBasis {
public:
    explicit EchelonBasis(uint32_t rows) : words_(wordsFor(rows)), pivotRows_(words_) {}

    uint32_t size() const { return static_cast<uint32_t>(pivots_.size()); }
    std::span<const uint64_t> column(uint32_t k) const { return {&columns_[k * words_], words_}; }
    uint32_t pivot(uint32_t k) const { return pivots_[k]; }
    std::span<const uint64_t> pivotRows() const { return pivotRows_; }

    /// Adds a column unless it is a sum of others; returns whether it did.
    bool insert(std::span<const uint64_t> column);

    /// The sum of columns that agrees with `column` in every pivot row among `rows`, and has no
    /// columns whose pivots are elsewhere.
    void combine(std::span<const uint64_t> column, std::span<const uint64_t> rows,
                 std::span<uint64_t> sum) const;

private:
    void add(uint32_t k, std::span<uint64_t> to) const;

    size_t words_;
    Words columns_, pivotRows_;
    std::vector<uint32_t> pivots_;
};

class GaussJordanOctant : public LinearOctant {
public:
    GaussJordanOctant(Tracer& tracer, std::span<const uint32_t> columns,
                      const CompletionParams& params, uint64_t seed, CompletedSlice& out);

private:
    uint32_t basisSize() const override { return basis_.size(); }
    uint32_t chooseRows(std::span<const uint64_t> matters, Words& rows) override;
    bool predict(std::span<const uint64_t> column, std::span<const uint64_t> matters,
                 const Words& samples) override;
    void append(std::span<const uint64_t> column) override { basis_.insert(column); }

    EchelonBasis basis_;
    Words others_, chosen_;  // rows to draw from and drawn, then the sum
};

}  // namespace core::many_lights
