// The integrands of the one-dimensional laboratory. See functions.h.
//
// Chosen to disagree with the densities in different ways: constant, slopes, a bump, a box, a lobe
// that is proportional to one of the densities, two peaks, ripples faster than any lobe, and an
// end where the integrand is infinite but its square still integrable.
#include "app/lab/functions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/check.h"

namespace app::lab {

namespace {

using std::numbers::pi;

constexpr double kBoxLow = .3, kBoxHigh = .6;         // F4
constexpr double kLobeCentre = .55, kLobeWidth = .1;  // F5

struct Peak {  // of F6
    double height, centre, sigma;

    double at(double x) const
    {
        const double t = (x - centre) / sigma;
        return height * std::exp(-.5 * t * t);
    }
    double integral(double low, double high) const
    {
        const double unit = 1 / (sigma * std::numbers::sqrt2);
        const double area = height * sigma * std::sqrt(pi / 2);
        return area * (std::erf((high - centre) * unit) - std::erf((low - centre) * unit));
    }
};
constexpr Peak kFirstPeak{.6, .25, .05}, kSecondPeak{1, .7, .08};

/// sin 20t from sin t and cos t, by doubling: a third of the cost of another call of sin.
double sine20(double s1, double c1)
{
    const double s2 = 2 * s1 * c1, c2 = 1 - 2 * s1 * s1;
    const double s4 = 2 * s2 * c2, c4 = 1 - 2 * s2 * s2;
    const double s5 = s4 * c1 + c4 * s1, c5 = c4 * c1 - s4 * s1;
    const double s10 = 2 * s5 * c5, c10 = 1 - 2 * s5 * s5;
    return 2 * s10 * c10;
}

/// Antiderivatives of F8 and of F7.
double powerIntegral(double x)
{
    return std::sqrt(x * std::sqrt(x));
}

double rippleIntegral(double x)
{
    return x - .9 / (20 * pi) * std::cos(20 * pi * x);
}

}  // namespace

const std::array<TestFunction, kFunctions>& functions()
{
    static const std::array<TestFunction, kFunctions> table{{
        {"F1", "constant", "1"},
        {"F2", "slope", "2x"},
        {"F3", "arch", "(π/2) sin πx"},
        {"F4", "box", "1/0.3 for 0.3 ≤ x < 0.6, else 0"},
        {"F5", "lobe", "0.1² / (0.1² + (x − 0.55)²)"},
        {"F6", "peaks", "0.6 exp(−(x − 0.25)²/(2·0.05²)) + exp(−(x − 0.7)²/(2·0.08²))"},
        {"F7", "ripples", "1 + 0.9 sin 20πx"},
        {"F8", "spike", "(3/4) x^(−1/4)"},
    }};
    return table;
}

const TestFunction* findFunction(std::string_view id)
{
    const auto found = std::find_if(functions().begin(), functions().end(),
                                    [&](const TestFunction& f) { return f.id == id; });
    return found == functions().end() ? nullptr : &*found;
}

size_t functionIndex(std::string_view id)
{
    const TestFunction* found = findFunction(id);
    CHECK(found);
    return static_cast<size_t>(found - functions().data());
}

Values evaluateFunctions(double x)
{
    const double sine = std::sin(pi * x), cosine = std::cos(pi * x);
    const double d = (x - kLobeCentre) / kLobeWidth;
    Values f;
    f[0] = 1;
    f[1] = 2 * x;
    f[2] = pi / 2 * sine;
    f[3] = x >= kBoxLow && x < kBoxHigh ? 1 / (kBoxHigh - kBoxLow) : 0;
    f[4] = 1 / (1 + d * d);
    f[5] = kFirstPeak.at(x) + kSecondPeak.at(x);
    f[6] = 1 + .9 * sine20(sine, cosine);
    f[7] = .75 / std::sqrt(std::sqrt(x));
    return f;
}

Values integrateFunctions(double low, double high)
{
    const double inBox = std::min(high, kBoxHigh) - std::max(low, kBoxLow);
    const auto lobeAngle = [](double x) { return std::atan((x - kLobeCentre) / kLobeWidth); };
    Values f;
    f[0] = high - low;
    f[1] = (high - low) * (high + low);
    f[2] = (std::cos(pi * low) - std::cos(pi * high)) / 2;
    f[3] = std::max(inBox, 0.) / (kBoxHigh - kBoxLow);
    f[4] = kLobeWidth * (lobeAngle(high) - lobeAngle(low));
    f[5] = kFirstPeak.integral(low, high) + kSecondPeak.integral(low, high);
    f[6] = rippleIntegral(high) - rippleIntegral(low);
    f[7] = powerIntegral(high) - powerIntegral(low);
    return f;
}

}  // namespace app::lab
