// The scale of a view that shows numbers as colours, for the bar beside it.
#pragma once

#include <string>
#include <vector>

namespace app {

struct Scale {
    bool shown = false;
    float low = 0, high = 1;
    bool logarithmic = false;
    bool isSigned = false;  // differences: blue below zero, red above
    std::string label;      // "relative error of luminance", "distance (m)"
    bool whole = false;     // counts: nothing lies between whole numbers
    float unit = 1;         // what a value of 1 is in the label's unit
};

/// Where a number stands at a scale, as a fraction of it, and its text.
struct ScaleNumber {
    double at = 0;
    std::string text;
};

/// `count` of them from end to end, evenly as far as whole numbers allow, which come but once. All
/// numbers of a linear scale have as many decimals.
std::vector<ScaleNumber> scaleNumbers(const Scale& scale, int count);

/// Whether texts of these widths, each in the middle of its place but within [0, length], stay
/// `gap` apart.
bool stayApart(const std::vector<ScaleNumber>& numbers, const std::vector<float>& widths,
               float length, float gap);

}  // namespace app
