// What a few repetitions of one measurement say.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace app {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Middle and extremes of some repetitions.
struct Spread {
    double median = kUnknown, low = kUnknown, high = kUnknown;
    size_t count = 0;
};

/// Without those that are not numbers; the median of an even number is the mean of the two in the
/// middle.
Spread spreadOf(std::vector<double> values);

/// "0.24 (0.22–0.27)": the median with what the repetitions span, where they differ in what is
/// shown; "–" without any, "never" where it is infinite.
std::string spreadText(const Spread& spread);

}  // namespace app
