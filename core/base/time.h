// The one clock of measurements, the seconds since a moment of it, and ticks for shares of these.
#pragma once

#include <chrono>
#include <cstdint>

namespace core {

/// Steady: setting the system's clock changes no measurement.
using Clock = std::chrono::steady_clock;

inline double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A counter that runs evenly, in no unit: for shares of a time that Clock measures as a whole. On
/// x86-64 the processor's own, which takes less than half of what reading Clock does: that matters
/// where moments lie less than a microsecond apart.
inline uint64_t ticks()
{
#ifdef __x86_64__
    return __builtin_ia32_rdtsc();
#else
    return static_cast<uint64_t>(Clock::now().time_since_epoch().count());
#endif
}

}  // namespace core
