// Counts what the calling thread takes from the heap, for tests of code that must not, or little.
#pragma once

#include <cstdint>

namespace tests {

/// How often this thread has called operator new (the aligned one apart) since it began.
uint64_t allocations();

/// The most bytes that this thread has held at once since then; what others free for it goes on
/// counting.
void watchPeak();
uint64_t peakBytes();

/// Whether anything is counted: sanitizers bring an operator new of their own.
bool allocationsAreCounted();

}  // namespace tests
