// See spread.h.
#include "app/bench/spread.h"

#include <algorithm>
#include <cmath>

#include "app/report/text.h"

namespace app {

Spread spreadOf(std::vector<double> values)
{
    std::erase_if(values, [](double x) { return std::isnan(x); });
    if (values.empty()) return {};
    std::ranges::sort(values);
    const size_t n = values.size();
    return {(values[(n - 1) / 2] + values[n / 2]) / 2, values.front(), values.back(), n};
}

std::string spreadText(const Spread& s)
{
    using report::shortNumber;
    if (s.count == 0 || std::isnan(s.median)) return "–";
    if (std::isinf(s.median)) return "never";
    const std::string middle = shortNumber(s.median), low = shortNumber(s.low),
                      high = std::isinf(s.high) ? "never" : shortNumber(s.high);
    if (low == middle && high == middle) return middle;
    return middle + " (" + low + "–" + high + ")";
}

std::string ratioText(const Ratio& ratio)
{
    return spreadText({ratio.value, ratio.low, ratio.high, 1});
}

}  // namespace app
