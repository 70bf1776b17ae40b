// What every way of completing an octant has: its columns, the rate of sampled rows, draws of rows,
// and what is counted.
#pragma once

#include <algorithm>

#include "core/completion/block.h"
#include "core/completion/row_weights.h"

namespace core::many_lights {

class Octant {
protected:
    /// Everything is kept by reference. `columns` have a row that matters each; up to `together` of
    /// them are worked on at once.
    Octant(Tracer& tracer, std::span<const uint32_t> columns, const CompletionParams& params,
           uint64_t seed, size_t together, CompletedSlice& out);
    ~Octant() = default;

    /// Rows to sample of a column at the present rate.
    uint32_t sampleCount() const;
    /// Rows that verify a match; 0: none do.
    uint32_t checkCount() const;

    /// Rows on which two columns are to be compared at least; fewer prove nothing.
    uint32_t fewestRows() const { return std::min(8u, params_.rowMinimum); }
    /// Whether all rows of column c that matter have been traced.
    bool isTraced(size_t c) const;

    /// Draws rows by weight, with or without replacement.
    void drawSamples(uint32_t count, std::span<const uint64_t> eligible, std::span<uint64_t> drawn);

    /// Draws `count` rows to verify column c among those of `eligible` that are left, and traces
    /// them.
    void fetchChecks(size_t c, uint32_t count, std::span<const uint64_t> eligible, Words& checks);

    /// A verification has failed.
    void raiseRate();

    /// Traces all that is left of column c and learns where its shadows end.
    void fetchAll(size_t c);

    /// Writes what a column is predicted to be, 0 (dark) to 1 (lit), to its rows that matter and
    /// have not been traced: rounded to bits, and as the numbers that CompletionParams asks for.
    void writePrediction(size_t c, std::span<const float> lit);
    /// Writes the numbers of a column whose bits are complete and exact.
    void writeTraced(size_t c);

    /// Counts column c, which is complete.
    void noteFull(size_t c);
    void noteMatched(size_t c, uint32_t drawn);
    void noteRepaired(size_t c);

    /// Counts the columns of the basis at the end.
    void finish(uint32_t basis);

    uint32_t rows_;
    std::span<const uint32_t> columns_;
    const CompletionParams& params_;
    CompletedSlice& out_;
    CompletionStats& stats_;
    Tracer& tracer_;
    Block block_;
    RowWeights weights_;
    Pcg32 random_;
    double rate_;
    Words left_;                 // memory of fetchChecks
    uint64_t windowTraced_ = 0;  // rows of columns counted since it was set to zero
};

}  // namespace core::many_lights
