// The program's operator new with a counter per thread. See allocation_count.h.
#include "tests/support/allocation_count.h"

#include <cstdlib>
#include <new>

#include "tests/support/sanitized.h"

namespace {

thread_local uint64_t count = 0;

}  // namespace

#ifndef REKINDLE_SANITIZED
void* operator new(std::size_t bytes)
{
    ++count;
    for (;;) {
        if (void* memory = std::malloc(bytes == 0 ? 1 : bytes)) return memory;
        const std::new_handler handler = std::get_new_handler();
        if (!handler) throw std::bad_alloc();
        handler();
    }
}

void operator delete(void* memory) noexcept
{
    std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept
{
    std::free(memory);
}
#endif

namespace tests {

uint64_t allocations()
{
    return count;
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
