// What a value should have been. See read_value.h.
#include "app/base/read_value.h"

#include <cstdio>

namespace app {

std::string numberText(double value)
{
    char text[32];
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
