// Quadrature for the theory of the laboratory: composite Gauss-Legendre on each piece between
// breaks, after a change of variable that crowds the nodes towards both ends of the piece.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "app/lab/theory.h"
#include "core/base/check.h"

namespace app::lab {

namespace {

constexpr size_t kNodes = 16;

struct Rule {
    std::array<double, kNodes> node, weight;  // on [0, 1]
};

/// The zeros of the Legendre polynomial of degree kNodes, by Newton's method from Tricomi's
/// approximation.
Rule gaussLegendre()
{
    Rule rule;
    for (size_t i = 0; i < kNodes; ++i) {
        double x = std::cos(std::numbers::pi * (static_cast<double>(i) + .75) / (kNodes + .5));
        double slope = 1;
        for (int step = 0; step < 10; ++step) {
            double before = 1, value = x;
            for (size_t k = 2; k <= kNodes; ++k) {
                const double j = static_cast<double>(k);
                const double next = ((2 * j - 1) * x * value - (j - 1) * before) / j;
                before = value;
                value = next;
            }
            slope = kNodes * (before - x * value) / (1 - x * x);
            x -= value / slope;
        }
        rule.node[i] = (1 - x) / 2;
        rule.weight[i] = 1 / ((1 - x * x) * slope * slope);
    }
    return rule;
}

/// The share of a piece that lies below t: the incomplete beta function I_t(4, 4). It leaves 0 as
/// t^4, which turns every x^(j/4) with j > -4 into a whole power of t.
double graded(double t)
{
    return t * t * t * t * (35 - t * (84 - t * (70 - t * 20)));
}

double gradedSlope(double t)
{
    const double u = t * (1 - t);
    return 140 * u * u * u;
}

}  // namespace

double integrate(const std::vector<double>& breaks, const std::function<double(double)>& h)
{
    static const Rule rule = gaussLegendre();
    CHECK(std::is_sorted(breaks.begin(), breaks.end()));
    double sum = 0;
    for (size_t piece = 1; piece < breaks.size(); ++piece) {
        const double low = breaks[piece - 1], high = breaks[piece], length = high - low;
        // Wide enough apart for poles at .05 from the axis, the narrowest lobe.
        const int panels = 8 + static_cast<int>(24 * length);
        for (int panel = 0; panel < panels; ++panel) {
            for (size_t i = 0; i < kNodes; ++i) {
                const double t = (panel + rule.node[i]) / panels;
                // From the nearer end, so that the distance to it keeps its digits.
                const double x = t < .5 ? low + length * graded(t) : high - length * graded(1 - t);
                sum += rule.weight[i] / panels * length * gradedSlope(t) * h(x);
            }
        }
    }
    return sum;
}

}  // namespace app::lab
