// The program's operator new with counters per thread. See allocation_count.h.
#include "tests/support/process/allocation_count.h"

#include <algorithm>
#include <cstdlib>
#include <new>

#include <malloc.h>

#include "tests/support/process/sanitized.h"

namespace {

thread_local uint64_t allocationCount = 0;
thread_local int64_t heldBytes = 0, heldAtStart = 0, mostHeld = 0;

#ifndef REKINDLE_SANITIZED
int64_t sizeOf(void* memory)
{
    return static_cast<int64_t>(malloc_usable_size(memory));
}
#endif

}  // namespace

#ifndef REKINDLE_SANITIZED
void* operator new(std::size_t bytes)
{
    ++allocationCount;
    for (;;) {
        if (void* memory = std::malloc(bytes == 0 ? 1 : bytes)) {
            heldBytes += sizeOf(memory);
            mostHeld = std::max(mostHeld, heldBytes);
            return memory;
        }
        const std::new_handler handler = std::get_new_handler();
        if (!handler) throw std::bad_alloc();
        handler();
    }
}

void operator delete(void* memory) noexcept
{
    heldBytes -= sizeOf(memory);
    std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept
{
    operator delete(memory);
}
#endif

namespace tests {

uint64_t allocations()
{
    return allocationCount;
}

void watchPeak()
{
    heldAtStart = mostHeld = heldBytes;
}

uint64_t peakBytes()
{
    return static_cast<uint64_t>(mostHeld - heldAtStart);
}

bool allocationsAreCounted()
{
#ifdef REKINDLE_SANITIZED
    return false;
#else
    return true;
#endif
}

}  // namespace tests
