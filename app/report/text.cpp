// Words and numbers of pages. See text.h.
#include "app/report/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace app::report {

namespace {

std::string superscript(int exponent)
{
    static constexpr const char* kDigits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    std::string text = exponent < 0 ? "⁻" : "";
    for (const char digit : std::to_string(std::abs(exponent))) text += kDigits[digit - '0'];
    return text;
}

}  // namespace

std::string escapeMarkup(std::string_view text)
{
    std::string safe;
    for (const char c : text) {
        switch (c) {
        case '&':
            safe += "&amp;";
            break;
        case '<':
            safe += "&lt;";
            break;
        case '>':
            safe += "&gt;";
            break;
        case '"':
            safe += "&quot;";
            break;
        case '\'':
            safe += "&#39;";
            break;
        default:
            safe += c;
        }
    }
    return safe;
}

std::string fixedNumber(double value, int decimals)
{
    char text[400];
    const auto end =
        std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, decimals);
    std::string number(text, end.ptr);
    return number[0] == '-' ? "−" + number.substr(1) : number;
}

std::string roundNumber(double value)
{
    const double size = std::abs(value);
    if (size == 0 || (size > 9e-4 && size < 2e4)) {
        const int decimals =
            size == 0 || size >= 1 ? 0 : -static_cast<int>(std::floor(std::log10(size) + 1e-9));
        return fixedNumber(value, decimals);
    }
    const int exponent = static_cast<int>(std::floor(std::log10(size) + 1e-9));
    const double mantissa = std::round(value / std::pow(10.0, exponent));
    return (mantissa == 1 ? "" : fixedNumber(mantissa, 0) + "·") + "10" + superscript(exponent);
}

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
        return fixedNumber(value, std::max(0, digits - 1 - exponent));
    return fixedNumber(value / std::pow(10.0, exponent), digits - 1) + "·10" +
           superscript(exponent);
}

std::string percent(double fraction, int digits)
{
    const std::string text = shortNumber(100 * fraction, digits);
    return std::isnan(fraction) ? text : text + " %";
}

std::string measured(double value, double error)
{
    if (!std::isfinite(value) || !(error > 0) || !std::isfinite(error) || value == 0)
        return shortNumber(value);
    const auto exponent = [](double x) { return std::floor(std::log10(std::abs(x))); };
    const double digits = std::clamp(1 + exponent(value) - exponent(error), 1.0, 8.0);
    return shortNumber(value, static_cast<int>(digits)) + " ± " + shortNumber(error, 1);
}

std::string counted(size_t count, const std::string& noun)
{
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string outOf(size_t count, size_t all)
{
    return std::to_string(count) + " of " + std::to_string(all);
}

std::string padded(const std::string& text, size_t width)
{
    return text + std::string(text.size() < width ? width - text.size() : 1, ' ');
}

std::string printed(const char* pattern, double value)
{
    if (!std::isfinite(value)) return "-";
    char text[48];
    std::snprintf(text, sizeof text, pattern, value);
    return text;
}

}  // namespace app::report
