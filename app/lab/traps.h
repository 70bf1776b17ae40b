// Ways of reusing samples that look right and are not, each beside the right way: with the bias of
// each measured.
#pragma once

#include <functional>
#include <stop_token>
#include <vector>

#include "app/lab/results.h"

namespace app::lab {

/// Empty when stopped. `trials` as for the table; the traps with a small bias take more.
std::vector<Trap> measureTraps(uint64_t trials, uint64_t seed,
                               const std::function<void(double)>& step, std::stop_token stop);

}  // namespace app::lab
