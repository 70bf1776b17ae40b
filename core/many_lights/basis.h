// The columns of an octant that are known: what a new column is compared with on a few rows. A
// column matches if it is equal there to one of these or to its complement (S. Wang, N. Holzschuch,
// "Adaptive Matrix Completion for Fast Visibility Computations with Many Lights Rendering", 2020).
#pragma once

#include <optional>

#include "core/many_lights/bits.h"

namespace core::many_lights {

/// A column of the basis, or its complement.
struct Candidate {
    uint32_t index = 0;
    bool complement = false;

    friend bool operator==(const Candidate&, const Candidate&) = default;
};

/// What a column shows on the selected rows, packed as Basis::select asks for.
struct ColumnKey {
    Words bits, known;
};

class Basis {
public:
    explicit Basis(uint32_t rows) : words_(wordsFor(rows)) {}

    uint32_t size() const { return size_; }
    std::span<const uint64_t> bits(uint32_t k) const { return {&bits_[k * words_], words_}; }
    /// The rows in which a column is known; its bits elsewhere are zero.
    std::span<const uint64_t> known(uint32_t k) const { return {&known_[k * words_], words_}; }

    /// Appends a column, to which the rows selected now apply as well. Returns its index.
    uint32_t push(std::span<const uint64_t> bits, std::span<const uint64_t> known);

    /// A column that is the same, or its complement, in every row that both know, if these are
    /// more than half of `known`. The first of several.
    std::optional<Candidate> findEqual(std::span<const uint64_t> bits,
                                       std::span<const uint64_t> known) const;

    /// Makes rows of a column known that were not: `bits` as the candidate has them.
    void fill(Candidate candidate, std::span<const uint64_t> bits, std::span<const uint64_t> rows);

    /// The rows on which columns are compared from now on, in two stages.
    void select(std::span<const uint64_t> samples, std::span<const uint64_t> checks);

    /// Packs a column's bits in the selected rows; `known` may hold other rows, too.
    void makeKey(std::span<const uint64_t> bits, std::span<const uint64_t> known,
                 ColumnKey& key) const;

    /// Finds every candidate that agrees with the key in all selected rows that both know and has
    /// at least `fewest` of them, in the order of columns, a column before its complement. Returns
    /// whether some candidate agrees in the first stage.
    bool match(const ColumnKey& key, uint32_t fewest, std::vector<Candidate>& found) const;

    /// The candidate that disagrees in the fewest of the selected rows, the first of several, of
    /// those with at least `fewest` rows in common.
    struct Nearest {
        Candidate candidate;
        uint32_t differ = 0, common = 0;
    };
    std::optional<Nearest> nearest(const ColumnKey& key, uint32_t fewest) const;

private:
    static constexpr uint32_t kLanes = 8;  // columns that are compared at once

    uint32_t keyWords() const { return sampleWords_ + checkWords_; }
    void packLane(uint32_t k);
    const uint64_t* keys(uint32_t group) const
    {
        return &keys_[size_t(2) * kLanes * keyWords() * group];
    }

    uint32_t words_ = 0, size_ = 0;
    Words bits_, known_;
    Words samples_, checks_;  // selected rows
    uint32_t sampleWords_ = 0, checkWords_ = 0;
    // Groups of kLanes columns; in each, word by word, kLanes words of bits and kLanes of what is
    // known. Lanes without a column know nothing.
    Words keys_;
};

}  // namespace core::many_lights
