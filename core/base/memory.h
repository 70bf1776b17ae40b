// Freed memory, given back to the system.
#pragma once

#include <cstdlib>  // says whether this is glibc

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace core {

/// After a large structure of many small allocations is gone: glibc keeps its pages otherwise, and
/// what is allocated next in large blocks comes on top of them.
inline void giveBackMemory()
{
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

}  // namespace core
