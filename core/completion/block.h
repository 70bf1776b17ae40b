// Columns that are completed together: the rows of each that have been traced, those set aside for
// the residual, and requests for more. What is fetched is never traced twice.
#pragma once

#include "core/completion/tracer.h"

namespace core::many_lights {

class Block {
public:
    /// Keeps everything by reference; room for `capacity` columns.
    Block(Tracer& tracer, BitMatrix& visible, uint32_t capacity)
        : tracer_(tracer), visible_(visible), traced_(visible.rows(), capacity),
          residual_(visible.rows(), capacity), residualBits_(visible.rows(), capacity),
          ask_(visible.wordsPerColumn())
    {}

    /// Begins with other columns, of which nothing has been traced.
    void begin(std::span<const uint32_t> columns);

    size_t size() const { return columns_.size(); }
    uint32_t column(size_t c) const { return columns_[c]; }
    std::span<const uint64_t> matters(size_t c) const { return matters_[c]; }
    std::span<uint64_t> visible(size_t c) { return visible_.column(columns_[c]); }
    std::span<const uint64_t> traced(size_t c) const { return traced_.column(index(c)); }
    /// Rows whose truth is known apart, for the residual; not in `traced`.
    std::span<const uint64_t> residual(size_t c) const { return residual_.column(index(c)); }
    std::span<const uint64_t> residualBits(size_t c) const
    {
        return residualBits_.column(index(c));
    }

    /// Rows that matter in some column.
    void unionOfMatters(std::span<uint64_t> rows) const;

    /// Traces `rows` of every column, as far as they matter, and `residual` rows (others) apart.
    void fetchAll(std::span<const uint64_t> rows, std::span<const uint64_t> residual);

    /// Makes rows of one column known, as far as they matter and are not known. Returns how many
    /// rays that took.
    uint32_t fetch(size_t c, std::span<const uint64_t> rows);

    /// The same of one row that matters and is not known. Returns whether it is lit.
    bool fetchRow(size_t c, uint32_t row);

    /// The same for all that is left of several columns, in one call of the oracle.
    void fetchRest(std::span<const size_t> which);

private:
    static uint32_t index(size_t c) { return static_cast<uint32_t>(c); }
    uint32_t claim(size_t c, std::span<const uint64_t> rows, std::span<uint64_t> ask);
    uint32_t claimPlain(size_t c, const uint64_t* rows, std::span<uint64_t> ask);

    Tracer& tracer_;
    BitMatrix& visible_;
    std::vector<uint32_t> columns_;
    std::vector<std::span<const uint64_t>> matters_;
    BitMatrix traced_, residual_, residualBits_;
    bool apart_ = false;  // the residual has rows
    Words ask_;           // of a request
    Words askAll_;        // of several
    std::vector<TraceRequest> requests_;
};

}  // namespace core::many_lights
