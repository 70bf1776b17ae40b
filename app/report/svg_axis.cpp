// Ticks and axes. See svg.h.
#include <algorithm>
#include <cmath>

#include "app/report/svg.h"
#include "app/report/text.h"

namespace app::report {

namespace {

/// Makes any two numbers a finite range that is not empty.
void repairRange(double& low, double& high)
{
    constexpr double kLargest = 1e280, kSmallest = 1e-280;  // steps inside of double
    if (!std::isfinite(low)) low = std::isfinite(high) ? high : 0;
    if (!std::isfinite(high)) high = low;
    if (low > high) std::swap(low, high);
    low = std::clamp(low, -kLargest, kLargest);
    high = std::clamp(high, -kLargest, kLargest);
    // Less than this cannot be told apart in a plot, nor be labelled.
    const double least = std::max(1e-6 * std::max(std::abs(low), std::abs(high)), kSmallest);
    if (high - low > least) return;
    const double middle = (low + high) / 2;
    const double half = std::abs(middle) < kSmallest ? 0.5 : std::abs(middle) / 2;
    low = middle - half;
    high = middle + half;
}

}  // namespace

std::vector<Tick> linearTicks(double low, double high, int wanted)
{
    repairRange(low, high);
    const double rough = (high - low) / std::max(2, wanted);
    const double power = std::pow(10.0, std::floor(std::log10(rough)));
    double step = 10 * power;
    for (const double factor : {5.0, 2.0, 1.0})
        if (factor * power >= rough * (1 - 1e-9)) step = factor * power;
    const double slack = 1e-9;
    double first = std::floor(low / step + slack), last = std::ceil(high / step - slack);
    if (last - first < 2) last = first + 2;
    const int stepExponent = static_cast<int>(std::floor(std::log10(step) + 1e-9));
    const double largest = std::max(std::abs(first), std::abs(last)) * step;
    const int exponent = static_cast<int>(std::floor(std::log10(largest) + 1e-9));
    const bool plain = stepExponent >= -4 && exponent < 6;
    std::vector<Tick> ticks;
    for (double i = first; i <= last; ++i) {
        const double value = i * step;
        // Enough digits to tell neighbours apart.
        const int own =
            i == 0 ? 0 : static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-9));
        ticks.push_back({value, plain ? fixedNumber(value, std::max(0, -stepExponent))
                                      : shortNumber(value, 1 + std::max(0, own - stepExponent))});
    }
    return ticks;
}

std::vector<Tick> logTicks(double low, double high)
{
    if (!(high > 0) || !std::isfinite(high)) high = std::isfinite(low) && low > 0 ? low : 1;
    if (!(low > 0) || !std::isfinite(low)) low = high / 10;
    if (low > high) std::swap(low, high);
    low = std::clamp(low, 1e-280, 1e280);
    high = std::clamp(high, low, 1e280);
    if (high / low < 3) return linearTicks(low, std::max(high, 1.2 * low), 6);
    std::vector<Tick> ticks;
    const double slack = 1e-9;
    if (high / low <= 100) {
        const auto exponent = static_cast<int>(std::floor(std::log10(low)));
        for (int e = exponent - 1; e <= exponent + 4; ++e)
            for (const double factor : {1.0, 2.0, 5.0}) {
                const double value = factor * std::pow(10.0, e);
                ticks.push_back({value, roundNumber(value)});
            }
        const auto first = std::find_if(ticks.begin(), ticks.end(),
                                        [&](const Tick& t) { return t.value > low * (1 + slack); });
        const auto last = std::find_if(ticks.begin(), ticks.end(), [&](const Tick& t) {
            return t.value >= high * (1 - slack);
        });
        return {first - 1, last + 1};
    }
    const double from = std::floor(std::log10(low) + slack),
                 to = std::ceil(std::log10(high) - slack);
    const double step = std::ceil((to - from) / 6);
    for (double e = std::floor(from / step) * step; e < to + step; e += step)
        ticks.push_back({std::pow(10.0, e), roundNumber(std::pow(10.0, e))});
    return ticks;
}

double Axis::at(double value) const
{
    return log ? (std::log(value) - std::log(low)) / (std::log(high) - std::log(low))
               : (value - low) / (high - low);
}

Axis linearAxis(std::string label, double low, double high, int wanted)
{
    Axis axis{std::move(label), linearTicks(low, high, wanted)};
    axis.low = axis.ticks.front().value;
    axis.high = axis.ticks.back().value;
    return axis;
}

Axis logAxis(std::string label, double low, double high)
{
    Axis axis{std::move(label), logTicks(low, high)};
    axis.low = axis.ticks.front().value;
    axis.high = axis.ticks.back().value;
    axis.log = true;
    return axis;
}

Axis logAxisAt(std::string label, const std::vector<Tick>& ticks)
{
    if (ticks.size() < 2) return logAxis(std::move(label), 0.1, 10);
    Axis axis{std::move(label), ticks};
    const double margin = std::pow(ticks.back().value / ticks.front().value, 0.05);
    axis.low = ticks.front().value / margin;
    axis.high = ticks.back().value * margin;
    axis.log = true;
    return axis;
}

}  // namespace app::report
