// Completion by matching: a column that agrees with a known one, or with its complement, on a few
// rows is taken to be that column (S. Wang, N. Holzschuch, "Adaptive Matrix Completion for Fast
// Visibility Computations with Many Lights Rendering", 2020). What differs from the paper:
// - a block of columns shares its sampled rows, whose rays make full packets, and the rows that
//   verify a match are traced with them and take part in the match (`joint`);
// - rows are drawn without replacement; rows where visibility makes no difference take no part;
// - bright columns are sampled in more rows than dim ones (`rowsByLight`);
// - of several matches, rays on rows where they disagree leave one (`disambiguate`).
#pragma once

#include "core/completion/basis.h"
#include "core/completion/octant.h"
#include "core/completion/repair.h"
#include "core/completion/row_counts.h"

namespace core::many_lights {

/// Completes the columns of one octant. `columns` have a row that matters each.
class MatchingOctant : Octant {
public:
    MatchingOctant(Tracer& tracer, std::span<const uint32_t> columns,
                   const CompletionParams& params, uint64_t seed, CompletedSlice& out);

    void run();

private:
    void runBlock(std::span<const uint32_t> columns);
    void drawRows();
    double rowFactor() const;
    uint32_t byLight(uint32_t rows) const;
    double brightness(size_t c) const;
    RepairTrust trust(size_t c, bool matched) const;
    void traceRepresentatives();
    void completeColumn(size_t c);
    uint32_t checksLeft(size_t c, Candidate candidate) const;
    bool verify(size_t c, Candidate candidate);
    Candidate choose(size_t c);
    Candidate ask(size_t c);
    std::optional<uint32_t> dividingRow(size_t c);
    std::span<const uint64_t> keepDivided(Words& rows);
    std::optional<uint32_t> anyRow(std::span<const uint64_t> rows);
    void take(size_t c, Candidate candidate);
    void noteResidual(size_t c);
    void unmatched(size_t c);
    void completeRepaired(size_t c);
    void traceFully(size_t c);
    void append(size_t c);
    void learn(size_t c);
    bool bailsOut();

    size_t blockSize_;
    Basis basis_;
    Words samples_, checks_, apart_;  // rows: matched, verified, kept for the residual
    double apartProbability_ = 0;     // of a row to be among the last
    double rowFactor_ = 1;            // of the rows sampled of this block
    uint32_t drawn_ = 0;              // how many rows were drawn as samples
    uint32_t checked_ = 0;            // and how many to verify
    ColumnKey key_;
    bool keyed_ = false;  // the key is that of the column being completed
    std::vector<Candidate> candidates_;
    Words scratch_, rest_, eligible_;
    RowCounts counts_;  // of candidates that predict light
    RepairMemory memory_;
    // Since bailing out was considered last:
    uint64_t windowColumns_ = 0, windowActive_ = 0, windowSampled_ = 0;
};

}  // namespace core::many_lights
