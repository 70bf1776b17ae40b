// One text to one value, with its range checked: the command line and JSON files read through this.
#pragma once

#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <system_error>
#include <type_traits>
#include <vector>

#include "app/base/nearest.h"
#include "core/base/params.h"

namespace app {

/// "%.10g" of a number; of a fraction that a float holds, the shortest text that reads as that
/// float.
std::string numberText(double value);

/// "a whole number from 1 to 8", "a number", ...: what `range` and, for whole numbers, the type
/// allow.
std::string expectation(bool whole, core::Range range, double lowest, double highest);

template <class T> struct IsOptional : std::false_type {};
template <class T> struct IsOptional<std::optional<T>> : std::true_type {};

/// Reads all of `text` as a T inside `range` (and inside T). Returns what was expected instead, or
/// nothing on success.
template <class T> std::string readValue(const std::string& text, core::Range range, T& value)
{
    if constexpr (IsOptional<T>::value) {
        typename T::value_type inner{};
        std::string problem = readValue(text, range, inner);
        if (problem.empty()) value = inner;
        return problem;
    } else if constexpr (std::is_enum_v<T>) {
        const auto names = core::enumNames<T>();
        std::vector<std::string> known;
        for (size_t i = 0; i < names.size(); ++i) {
            if (text == names[i]) {
                value = static_cast<T>(i);
                return {};
            }
            known.emplace_back(names[i]);
        }
        std::string all;
        for (const std::string& name : known) all += (all.empty() ? "" : ", ") + name;
        return "one of " + all + suggestion(text, known);
    } else if constexpr (std::is_same_v<T, bool>) {
        if (text != "true" && text != "false") return "true or false";
        value = text == "true";
        return {};
    } else if constexpr (std::is_arithmetic_v<T>) {
        const bool bounded = range.low != range.high;
        const double lowest = static_cast<double>(std::numeric_limits<T>::lowest());
        const double highest = static_cast<double>(std::numeric_limits<T>::max());
        T number{};
        const char* end = text.data() + text.size();
        const auto result = std::from_chars(text.data(), end, number);
        bool inside = std::isfinite(static_cast<double>(number));
        if constexpr (std::is_floating_point_v<T>)  // bounds in T: 1e-4f is less than 1e-4
            inside = inside && (!bounded || (number >= static_cast<T>(range.low) &&
                                             number <= static_cast<T>(range.high)));
        else
            inside = inside && (!bounded || (static_cast<double>(number) >= range.low &&
                                             static_cast<double>(number) <= range.high));
        if (result.ec != std::errc() || result.ptr != end || !inside)
            return expectation(std::is_integral_v<T>, range, lowest, highest);
        value = number;
        return {};
    } else {
        if (text.empty()) return "a name";
        value = text;
        return {};
    }
}

}  // namespace app
