// Trials in blocks on all threads, merged in their order: the same numbers on any number of
// threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/parallel.h"

namespace app::lab {

/// Calls `run(block, trials)` for the blocks of `blockSize` trials (the last may be smaller), from
/// any thread, and merges what they return with `merge(into, from)`. At least one trial. Nothing
/// when stopped.
template <class RunBlock, class Merge>
auto runBlocks(uint64_t trials, uint64_t blockSize, const RunBlock& run, const Merge& merge,
               std::stop_token stop) -> std::optional<decltype(run(uint64_t{}, uint64_t{}))>
{
    const uint64_t blocks = (trials + blockSize - 1) / blockSize;
    std::vector<decltype(run(uint64_t{}, uint64_t{}))> parts(blocks);
    const bool finished = core::parallelFor(
        blocks, 1,
        [&](size_t block, size_t) {
            parts[block] = run(block, std::min(trials - block * blockSize, blockSize));
        },
        stop);
    if (!finished) return {};
    for (uint64_t block = 1; block < blocks; ++block) merge(parts[0], parts[block]);
    return std::move(parts[0]);
}

}  // namespace app::lab
