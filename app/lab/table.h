// The laboratory's table: all methods on all functions under all changes of density; and what
// happens to R-A when c or k is not what it should be.
#pragma once

#include <functional>
#include <stop_token>
#include <vector>

#include "app/lab/results.h"
#include "app/lab/run_lab.h"
#include "app/lab/trials.h"

namespace app::lab {

inline constexpr uint32_t kOldSamples = 8;  // N

/// All methods as runs on `pair`, with n new samples; those that draw none only if `withOldOnly`.
std::vector<Run> methodRuns(const Pair& pair, uint32_t n, bool withOldOnly);

/// Cells of one pair, at n = N and n = N / 4. Empty when stopped.
std::vector<Cell> measurePair(const Pair& pair, const LabSettings& settings,
                              const std::function<void(double)>& step, std::stop_token stop);

/// R-A (k = 4) at multiples of the best c, and R-A at the best c with k from 1 to 32; n = N.
/// Appends to `results`; false when stopped.
bool measureSweeps(const Pair& pair, const LabSettings& settings, LabResults& results,
                   const std::function<void(double)>& step, std::stop_token stop);

/// The constants of a lobe of width .1 at .45 and one that moves away from it to .95. Exact.
std::vector<MajorisationPoint> majorisationSweep();

}  // namespace app::lab
