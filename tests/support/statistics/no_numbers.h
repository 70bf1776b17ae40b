// What is no number, or no finite one.
#pragma once

#include <limits>

namespace tests {

inline constexpr float kFloatNan = std::numeric_limits<float>::quiet_NaN();
inline constexpr float kFloatInf = std::numeric_limits<float>::infinity();
inline constexpr double kDoubleNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace tests
