// The visibility of one slice: receivers (rows) against clusters of lights (columns), of which only
// a part is traced and the rest is predicted. S. Wang, N. Holzschuch, "Adaptive Matrix Completion
// for Fast Visibility Computations with Many Lights Rendering" (2020), and S. Wang, "Efficient
// Sample Usage in Photo-Realistic Rendering" (2022), chapter 5. Knows no geometry: an oracle
// traces.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/completion/bit_matrix.h"
#include "core/completion/completion_params.h"

namespace core::many_lights {

/// Columns begin <= j < end.
struct ColumnRange {
    uint32_t begin = 0, end = 0;
};

/// Some rows of one column: bit i of `rows` asks for row i, bit i of `visible` receives the answer.
/// Bits of `visible` that are asked for are zero beforehand, the others stay as they are. Both are
/// arrays of wordsFor(rows of the slice) words.
struct TraceRequest {
    uint32_t column = 0;
    const uint64_t* rows = nullptr;
    uint64_t* visible = nullptr;
};

/// Answers for one slice and its clusters. One thread at a time calls it; different slices have
/// different oracles.
class VisibilityOracle {
public:
    virtual ~VisibilityOracle() = default;

    /// Traces all requests; the answers do not depend on which rows are asked for together. Rows of
    /// one request, then requests of neighbouring columns, are what belongs into one packet: a call
    /// asks for a few rows of each of some columns, or for all that is left of one.
    virtual void trace(std::span<const TraceRequest> requests) = 0;

    /// Bit i is 1 where visibility makes a difference at all: receiver and light face each other.
    /// Null: everywhere. Stays valid while the slice is completed.
    virtual const uint64_t* matters(uint32_t column) const = 0;

    /// Light that a column brings where all rows see it, over the mean of the columns. Nothing
    /// where that is not known of any column.
    virtual std::optional<float> brightness(uint32_t /*column*/) const { return std::nullopt; }
};

/// What completing one slice took, or the sum over slices.
struct CompletionStats {
    uint64_t entries = 0;  // rows x columns
    uint64_t active = 0;   // of these, where visibility makes a difference
    uint64_t rays = 0;     // shadow rays, each counted once, those of verification included
    /// As the thesis counts: the sampled rows of matched columns, with repetitions and without
    /// those of verification, and all rows of the others.
    uint64_t authorRays = 0;
    uint64_t columns = 0;
    uint64_t inactive = 0;   // columns without a row that matters: nothing to do
    uint64_t full = 0;       // columns traced in every row that matters
    uint64_t bailedOut = 0;  // of these, without having been sampled first
    uint64_t matched = 0;    // columns that agree with a known one
    uint64_t repaired = 0;   // columns traced in part that agree with none
    uint64_t basis = 0;      // known columns of all octants that others are compared with
    uint64_t ambiguous = 0;  // columns with several matches
    uint64_t verificationFailures = 0;
    uint64_t rated = 0;  // columns of octants that have a row rate: not of slices traced in full
    double rates = 0;    // the final row rate of each of these columns' octants, summed
    double traceSeconds = 0, seconds = 0;  // in the oracle; altogether

    CompletionStats& operator+=(const CompletionStats& other);

    /// Share of all entries that was traced.
    double visibility() const { return entries > 0 ? double(rays) / double(entries) : 0; }
    double authorVisibility() const
    {
        return entries > 0 ? double(authorRays) / double(entries) : 0;
    }
    double meanRate() const { return rated > 0 ? rates / double(rated) : 0; }
};

/// A sampled error of the prediction: shade(row, column) times `weight`, added to the picture of
/// what was predicted, makes its mean that of the true bits. `weight` is the true bit minus the
/// predicted one (or its coefficient) over the probability that the row was sampled.
struct ResidualEntry {
    uint32_t row = 0, column = 0;
    float weight = 0;
};

/// A completed slice; its memory may be used again for the next one.
struct CompletedSlice {
    BitMatrix visible;  // rows that do not matter are 0 or 1
    /// Numbers in place of bits, column by column: of methods that predict numbers (givesNumbers),
    /// unless these are rounded to bits. Else empty.
    std::vector<float> coefficients;
    /// Not of `svt`.
    std::vector<ResidualEntry> residual;  // with CompletionParams::residualRate > 0
    CompletionStats stats;
};

/// The seed of the random numbers that complete one octant of a slice.
uint64_t octantSeed(uint64_t seed, size_t octant);

/// Completes `rows` x (end of the last octant) bits. `octants` are adjacent ranges of columns,
/// beginning at 0, that share nothing; within each, brighter columns come first. Rows are best in
/// the order of a space-filling curve. The result is a function of the oracle's answers, `params`
/// and `seed` (of the slice) alone. Once `stop` is requested it means nothing.
void complete(VisibilityOracle& oracle, uint32_t rows, std::span<const ColumnRange> octants,
              const CompletionParams& params, uint64_t seed, CompletedSlice& out,
              const std::stop_token& stop = {});

}  // namespace core::many_lights
