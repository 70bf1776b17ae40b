// The scale of a view that shows numbers as colours, for the bar beside it.
#pragma once

#include <string>

namespace app {

struct Scale {
    bool shown = false;
    float low = 0, high = 1;
    bool logarithmic = false;
    bool isSigned = false;  // differences: blue below zero, red above
    std::string label;      // "relative error of luminance", "distance (m)"
    float unit = 1;         // what a value of 1 is in the label's unit
};

}  // namespace app
