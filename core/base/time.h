// The one clock of measurements, and the seconds since a moment of it.
#pragma once

#include <chrono>

namespace core {

/// Steady: setting the system's clock changes no measurement.
using Clock = std::chrono::steady_clock;

inline double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace core
