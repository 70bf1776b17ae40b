// Elapsed time.
#pragma once

#include <chrono>

namespace core {

using Clock = std::chrono::steady_clock;

/// Seconds from `start` until now.
inline double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace core
