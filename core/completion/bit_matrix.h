// A matrix of bits stored by column: the visibility of clusters of lights (columns) from the
// receivers of a slice (rows).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/check.h"
#include "core/completion/bits.h"

namespace core::many_lights {

/// Bit i of a column is bit i % 64 of its word i / 64. The bits beyond the last row are zero, and
/// whoever writes whole words keeps them so.
class BitMatrix {
public:
    BitMatrix() = default;
    BitMatrix(uint32_t rows, uint32_t columns) { reset(rows, columns); }

    /// All zero, of another size; memory is kept.
    void reset(uint32_t rows, uint32_t columns)
    {
        rows_ = rows;
        columns_ = columns;
        words_.assign(size_t(wordsFor(rows)) * columns, 0);
    }

    uint32_t rows() const { return rows_; }
    uint32_t columns() const { return columns_; }
    uint32_t wordsPerColumn() const { return wordsFor(rows_); }

    std::span<uint64_t> column(uint32_t j)
    {
        DCHECK(j < columns_);
        return {words_.data() + size_t(j) * wordsPerColumn(), wordsPerColumn()};
    }
    std::span<const uint64_t> column(uint32_t j) const
    {
        DCHECK(j < columns_);
        return {words_.data() + size_t(j) * wordsPerColumn(), wordsPerColumn()};
    }

    bool get(uint32_t i, uint32_t j) const
    {
        DCHECK(i < rows_ && j < columns_);
        return ((column(j)[i / 64] >> (i % 64)) & 1) != 0;
    }
    void set(uint32_t i, uint32_t j, bool value)
    {
        DCHECK(i < rows_ && j < columns_);
        const uint64_t bit = uint64_t(1) << (i % 64);
        uint64_t& word = column(j)[i / 64];
        word = value ? word | bit : word & ~bit;
    }

    /// All columns, one after the other.
    std::span<const uint64_t> words() const { return words_; }

    friend bool operator==(const BitMatrix&, const BitMatrix&) = default;

private:
    uint32_t rows_ = 0, columns_ = 0;
    std::vector<uint64_t> words_;
};

}  // namespace core::many_lights
