// Columns that a known column predicts nearly: which rows are traced to mend the prediction. Rows
// are taken to follow a space-filling curve, so that ranges of rows are places; 16 rows are a
// patch, whose rays make one packet. Columns that differ from every known one in more than a fifth
// of their sampled rows are traced in full, in recursion too; the thesis has no such limit.
#pragma once

#include "core/base/pcg32.h"
#include "core/completion/basis.h"
#include "core/completion/block.h"

namespace core::many_lights {

/// What both ways of repair write to, for columns of so many words, one after the other.
struct RepairMemory {
    explicit RepairMemory(size_t words)
        : common(words), bits(words), ask(words), asked(words), wrong(words), near(words)
    {}

    Words common;       // rows that matter and that the candidate knows
    Words bits;         // what it predicts there
    Words ask;          // rows to be traced next
    Words asked;        // patches that have been asked for
    Words wrong, near;  // patches around what was predicted wrongly
};

/// Writes a candidate's bits to every row of column c of the block that is known to it and has not
/// been traced.
void predict(Block& block, size_t c, const Basis& basis, Candidate candidate);

/// Recursive column sampling (S. Wang, "Efficient Sample Usage in Photo-Realistic Rendering", 2022,
/// section 5.6.4): ranges are halved down to patches; one without a traced row, or a patch with a
/// row that disagrees with the candidate, is traced, one whose traced rows all agree is predicted.
/// Completes the column.
void recurseColumn(Block& block, size_t c, const Basis& basis, Candidate candidate,
                   RepairMemory& memory);

/// How far a prediction is trusted.
struct RepairTrust {
    /// Share of the traced rows away from the borders of the candidate's shadows that may be wrong.
    double stray = 0;
    /// Probability that a row of a patch that repair has not led to is traced to see whether it
    /// should have; twice. 0: never, 1 or more: of every such patch.
    double probes = 0;
};

enum class RepairOutcome {
    agrees,    // everything traced is as the candidate has it
    differs,   // the column is complete, but not the candidate
    hopeless,  // too much has been traced, or it would be; the column is not complete
};

/// Traces the rows that the candidate does not know, the patches at the borders of the candidate's
/// shadows and around traced rows that disagree with it, then their neighbours as long as any
/// differs from the candidate. Then probes: what the first of them find wrong is repaired in the
/// same way. Completes the column unless that becomes most of it, more than `stray` of the traced
/// rows away from the borders are wrong, or the second probes find anything: then light and shadow
/// lie where no known border leads to them, as in hair, and what has not been traced is as wrong.
/// A candidate with borders nearly everywhere shows no shadows that could be mended: it is taken as
/// it is where every traced row agrees, and not at all where one does not.
RepairOutcome repairColumn(Block& block, size_t c, const Basis& basis, Candidate candidate,
                           RepairTrust trust, Pcg32& random, RepairMemory& memory);

}  // namespace core::many_lights
