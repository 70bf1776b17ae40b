// What a few repetitions of one measurement say.
#pragma once

#include <algorithm>
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

/// How one measurement compares with another: of the means over the repetitions, and between which
/// values it lies where each is taken alone.
struct Ratio {
    double value = kUnknown, low = kUnknown, high = kUnknown;
};

/// Error times cost of `plain` over that of `other`; repetitions of one index belong together.
template <class Sample, class Error, class Cost>
Ratio ratioOf(const std::vector<Sample>& plain, const std::vector<Sample>& other, Error&& error,
              Cost&& cost)
{
    const auto product = [&](const std::vector<Sample>& samples) {
        double errors = 0, costs = 0;
        for (const Sample& s : samples) {
            errors += error(s);
            costs += cost(s);
        }
        const auto count = static_cast<double>(samples.size());
        return errors / count * costs / count;
    };
    std::vector<double> single;
    for (size_t i = 0; i < std::min(plain.size(), other.size()); ++i)
        single.push_back(error(plain[i]) * cost(plain[i]) / (error(other[i]) * cost(other[i])));
    const Spread spread = spreadOf(single);
    return {product(plain) / product(other), spread.low, spread.high};
}

/// "5.8 (5.2–6.1)".
std::string ratioText(const Ratio& ratio);

}  // namespace app
