// Columns that a known column predicts nearly: which rows are traced to mend the prediction. Rows
// are taken to follow a space-filling curve, so that ranges of rows are places; 16 rows are a
// patch, whose rays make one packet. Columns that differ from every known one in more than a fifth
// of their sampled rows are traced in full, in recursion too; the thesis has no such limit.
#pragma once

#include "core/completion/basis.h"
#include "core/completion/block.h"

namespace core::many_lights {

/// Writes a candidate's bits to every row of column c of the block that is known to it and has not
/// been traced.
void predict(Block& block, size_t c, const Basis& basis, Candidate candidate);

/// Recursive column sampling (S. Wang, "Efficient Sample Usage in Photo-Realistic Rendering", 2022,
/// section 5.6.4): ranges are halved down to patches; one without a traced row, or a patch with a
/// row that disagrees with the candidate, is traced, one whose traced rows all agree is predicted.
/// Completes the column.
void recurseColumn(Block& block, size_t c, const Basis& basis, Candidate candidate);

enum class RepairOutcome {
    agrees,    // everything traced is as the candidate has it
    differs,   // the column is complete, but not the candidate
    hopeless,  // too much has been traced, or it would be; the column is not complete
};

/// Traces the rows that the candidate does not know, the patches at the borders of the candidate's
/// shadows and around traced rows that disagree with it, then their neighbours as long as any
/// differs from the candidate. Completes the column unless that becomes most of it, or more than
/// the share `stray` of the traced rows away from those borders disagree: then light and shadow lie
/// where no known border leads to them, as in hair, and what has not been traced is as wrong.
RepairOutcome repairColumn(Block& block, size_t c, const Basis& basis, Candidate candidate,
                           double stray);

}  // namespace core::many_lights
