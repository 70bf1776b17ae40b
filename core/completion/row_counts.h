// Small numbers of many rows at once: bit d of a row's number stands in word d of the rows' words,
// so that 64 rows are counted, compared and searched by operations on whole words.
#pragma once

#include "core/completion/bits.h"

namespace core::many_lights {

/// Counts, for each row, how many of some sets it is in. Memory is kept from one use to the next.
class RowCounts {
public:
    /// Counts the rows of `open` from zero, in up to `most` sets.
    void begin(std::span<const uint64_t> open, uint32_t most);

    /// Leaves only those of `rows` open.
    void keep(std::span<const uint64_t> rows);

    /// One set more: `rows`, or all others.
    void add(std::span<const uint64_t> rows, bool others);

    /// The open rows that divide the sets most evenly: those of the greatest min(number, sets -
    /// number). Empty where that is zero. To be asked once.
    std::span<const uint64_t> mostEven();

private:
    uint64_t* digit(size_t d) { return &digits_[d * words_]; }
    uint64_t* lack(size_t d) { return &lacks_[d * words_]; }
    void foldHalves();

    size_t words_ = 0;
    uint32_t added_ = 0;
    Words digits_, open_, carry_;
    Words lacks_, less_, equal_;  // what numbers lack of `added_`, where that is less, where equal
};

}  // namespace core::many_lights
