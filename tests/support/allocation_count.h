// Counts what the calling thread takes from the heap, for tests of code that must not.
#pragma once

#include <cstdint>

namespace tests {

/// How often this thread has called operator new (the aligned one apart) since it began.
uint64_t allocations();

/// Whether anything is counted: sanitizers bring an operator new of their own.
bool allocationsAreCounted();

}  // namespace tests
