// See curves.h.
#include "app/report/curves.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace app::report {

namespace {

bool isPositive(const Point& p)
{
    return p.x > 0 && p.y > 0 && std::isfinite(p.x + p.y);
}

}  // namespace

std::string curvesFigure(const std::string& title, const std::string& x, const std::string& y,
                         const std::vector<Curve>& curves, bool one, Point size)
{
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    Point low{kInfinite, one ? 1 : kInfinite}, high{0, one ? 1.0 : 0.0};
    for (const Curve& curve : curves)
        for (const Point& p : curve.points) {
            if (!isPositive(p)) continue;
            low = {std::min(low.x, p.x), std::min(low.y, p.y)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y)};
        }
    if (!(high.x > 0)) return {};
    Plot plot(title, logAxis(x, low.x, high.x), logAxis(y, low.y, high.y), size.x, size.y);
    if (one) plot.horizontal(1, "", "soft dashed");
    for (const Curve& curve : curves) {
        std::vector<Point> points = curve.points;
        std::erase_if(points, [](const Point& p) { return !isPositive(p); });
        plot.curve(points, curve.style);
        plot.markers(points, curve.shape, curve.style);
        plot.legend({curve.name, curve.style, true, true, false, curve.shape});
    }
    return "<figure>" + plot.element() + "</figure>\n";
}

}  // namespace app::report
