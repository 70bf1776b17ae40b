// The columns of an octant that are known: what a new column is compared with on a few rows. A
// column matches if it is equal there to one of these or to its complement (S. Wang, N. Holzschuch,
// "Adaptive Matrix Completion for Fast Visibility Computations with Many Lights Rendering", 2020).
#pragma once

#include <optional>

#include "core/completion/bits.h"

namespace core::many_lights {

/// A column of the basis, or its complement.
struct Candidate {
    uint32_t index = 0;
    bool complement = false;

    friend bool operator==(const Candidate&, const Candidate&) = default;
};

/// What a column shows on the selected rows, packed.
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
    /// `key`, of the same column, spares comparing it with most others; null: there is none.
    std::optional<Candidate> findEqual(std::span<const uint64_t> bits,
                                       std::span<const uint64_t> known,
                                       const ColumnKey* key = nullptr) const;

    /// Makes rows of a column known that were not: `bits` as the candidate has them.
    void fill(Candidate candidate, std::span<const uint64_t> bits, std::span<const uint64_t> rows);

    /// The rows on which columns are compared from now on. `checks` are others than `samples`.
    void select(std::span<const uint64_t> samples, std::span<const uint64_t> checks);

    /// Packs a column's bits in the selected rows; `known` may hold other rows, too.
    void makeKey(std::span<const uint64_t> bits, std::span<const uint64_t> known,
                 ColumnKey& key) const;

    /// Finds every candidate that agrees with the key in all selected rows that both know and has
    /// at least `fewest` of them, in the order of columns, a column before its complement.
    void match(const ColumnKey& key, uint32_t fewest, std::vector<Candidate>& found) const;

    /// Whether some candidate agrees in the samples alone.
    bool matchesSamples(const ColumnKey& key) const;

    /// The candidate that disagrees in the fewest of the selected rows, the first of several, of
    /// those with at least `fewest` rows in common.
    struct Nearest {
        Candidate candidate;
        uint32_t differ = 0, common = 0;
    };
    std::optional<Nearest> nearest(const ColumnKey& key, uint32_t fewest) const;

private:
    static constexpr uint32_t kLanes = 8;  // columns that are compared at once

    /// The bits of one word of a column that are selected, and where they go in its key.
    struct Part {
        uint32_t word = 0, shift = 0, count = 0;
        uint64_t mask = 0;
    };

    void pack(std::span<const uint64_t> words, uint64_t* key, size_t stride = 1) const;
    bool knowsSelected(std::span<const uint64_t> known) const;
    void packLane(uint32_t k);
    size_t groupSize() const { return size_t(2) * kLanes * keyWords_; }
    const uint64_t* group(uint32_t k) const { return keys_.data() + groupSize() * (k / kLanes); }
    uint32_t commonRows(const ColumnKey& key, uint32_t k) const;
    bool isEqual(std::span<const uint64_t> bits, std::span<const uint64_t> known,
                 Candidate& candidate) const;

    uint32_t words_ = 0, size_ = 0;
    Words bits_, known_;
    Words selected_;           // rows
    std::vector<Part> parts_;  // of these
    uint32_t keyWords_ = 0;
    bool unfinished_ = false;     // the last word of a key has bits to spare
    Words sampleKey_, wholeKey_;  // which bits of a key are samples, and all of them
    // Groups of kLanes columns; in each, word by word, kLanes words of bits and kLanes of what is
    // known. Lanes without a column know nothing.
    Words keys_;
};

}  // namespace core::many_lights
