// What a value should have been. See read_value.h.
#include "app/base/read_value.h"

#include <cstdio>
#include <iterator>

namespace app {

std::string numberText(double value)
{
    char text[32];
    const auto single = static_cast<float>(value);
    if (double(single) == value && value != std::floor(value)) {
        const auto end = std::to_chars(text, std::end(text), single, std::chars_format::general);
        return {text, end.ptr};
    }
    std::snprintf(text, sizeof text, "%.10g", value);
    return text;
}

std::string expectation(bool whole, core::Range range, double lowest, double highest)
{
    const std::string kind = whole ? "a whole number" : "a number";
    const bool bounded = range.low != range.high;
    if (!whole && !bounded) return kind;
    return kind + " from " + numberText(bounded ? range.low : lowest) + " to " +
           numberText(bounded ? range.high : highest);
}

}  // namespace app
