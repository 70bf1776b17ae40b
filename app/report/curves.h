// Several curves on logarithmic axes, as the pages of measurements compare methods.
#pragma once

#include <string>
#include <vector>

#include "app/report/svg.h"

namespace app::report {

struct Curve {
    std::string name, style;  // style: a colour class, with more classes if need be
    Shape shape = Shape::circle;
    std::vector<Point> points;
};

/// A figure with markers, lines and a legend; points that are not positive are left out. `one`:
/// with a line at y = 1. Empty without any point.
std::string curvesFigure(const std::string& title, const std::string& x, const std::string& y,
                         const std::vector<Curve>& curves, bool one, Point size = {490, 290});

}  // namespace app::report
