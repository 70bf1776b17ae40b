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

/// Once, when a program begins: what is freed in large blocks (pictures, films, buffers of software
/// devices) goes back to the system at once. glibc would learn from the first of them to keep as
/// much as 32 MiB in each thread's arena, where blocks of other sizes do not fit in.
inline void keepLittleFreeMemory()
{
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, 4 << 20);
    mallopt(M_TRIM_THRESHOLD, 8 << 20);
#endif
}

}  // namespace core
