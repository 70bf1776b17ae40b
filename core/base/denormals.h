// Denormal numbers as zero, as on GPUs and as Embree asks for: without that single paths can be a
// hundred times slower.
#pragma once

#if defined(__SSE2__)
#include <pmmintrin.h>
#include <xmmintrin.h>
#endif

namespace core {

/// Denormals of this thread count as zero while it lives. On processors without such a switch (or
/// none that is known here) it does nothing.
class FlushDenormals {
public:
#if defined(__SSE2__)
    FlushDenormals() : before_(_mm_getcsr())
    {
        _mm_setcsr(before_ | _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON);
    }
    ~FlushDenormals()
    {
        _mm_setcsr(before_);
    }
#elif defined(__aarch64__)
    FlushDenormals()
    {
        __asm__ volatile("mrs %0, fpcr" : "=r"(before_));
        __asm__ volatile("msr fpcr, %0" ::"r"(before_ | (1ull << 24)));  // FZ
    }
    ~FlushDenormals()
    {
        __asm__ volatile("msr fpcr, %0" ::"r"(before_));
    }
#else
    FlushDenormals() {}
    ~FlushDenormals() {}
#endif
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;

private:
#if defined(__SSE2__)
    unsigned before_;
#elif defined(__aarch64__)
    unsigned long long before_;
#endif
};

}  // namespace core
