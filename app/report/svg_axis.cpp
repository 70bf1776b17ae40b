// Ticks and axes. See svg.h.
#include <algorithm>
#include <charconv>
#include <cmath>

#include "app/report/svg.h"

namespace app::lab {

namespace {

std::string superscript(int exponent)
{
    static constexpr const char* kDigits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    std::string text = exponent < 0 ? "⁻" : "";
    for (const char digit : std::to_string(std::abs(exponent))) text += kDigits[digit - '0'];
    return text;
}

std::string fixed(double value, int decimals)
{
    char text[400];
    const auto end =
        std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, decimals);
    std::string number(text, end.ptr);
    return number[0] == '-' ? "−" + number.substr(1) : number;
}

/// "10⁻⁵", "1", "5000": a round number as a tick shows it.
std::string roundNumber(double value)
{
    const double size = std::abs(value);
    if (size == 0 || (size > 9e-4 && size < 2e4)) {
        const int decimals =
            size == 0 || size >= 1 ? 0 : -static_cast<int>(std::floor(std::log10(size) + 1e-9));
        return fixed(value, decimals);
    }
    const int exponent = static_cast<int>(std::floor(std::log10(size) + 1e-9));
    const double mantissa = std::round(value / std::pow(10.0, exponent));
    return (mantissa == 1 ? "" : fixed(mantissa, 0) + "·") + "10" + superscript(exponent);
}

/// A finite, non-empty range from whatever was given.
void putRight(double& low, double& high)
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

std::string shortNumber(double value, int digits)
{
    if (std::isnan(value)) return "–";
    if (std::isinf(value)) return value > 0 ? "∞" : "−∞";
    if (value == 0) return "0";
    int exponent = static_cast<int>(std::floor(std::log10(std::abs(value))));
    // 9.996 with three digits is 10.0.
    if (std::abs(value) / std::pow(10.0, exponent) >= 10 - 0.5 * std::pow(10.0, 1 - digits))
        ++exponent;
    // Few digits far behind the point are still easy to read.
    const int smallest = digits > 2 ? -3 : -5;
    if (exponent >= smallest && exponent < 5)
        return fixed(value, std::max(0, digits - 1 - exponent));
    return fixed(value / std::pow(10.0, exponent), digits - 1) + "·10" + superscript(exponent);
}

std::vector<Tick> linearTicks(double low, double high, int wanted)
{
    putRight(low, high);
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
        ticks.push_back({value, plain ? fixed(value, std::max(0, -stepExponent))
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

}  // namespace app::lab
