// Options of the command line made from plain members: one text for reading, range check and help.
// Only args*.cpp include this.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include <CLI/CLI.hpp>

#include "app/args.h"
#include "app/nearest.h"
#include "core/params.h"

namespace app {

/// "%g" of a number.
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
        return "one of " + CLI::detail::join(known, ", ") + suggestion(text, known);
    } else if constexpr (std::is_arithmetic_v<T>) {
        const bool bounded = range.low != range.high;
        const double lowest = static_cast<double>(std::numeric_limits<T>::lowest());
        const double highest = static_cast<double>(std::numeric_limits<T>::max());
        T number{};
        const char* end = text.data() + text.size();
        const auto result = std::from_chars(text.data(), end, number);
        const double asDouble = static_cast<double>(number);
        if (result.ec != std::errc() || result.ptr != end || !std::isfinite(asDouble) ||
            (bounded && !(asDouble >= range.low && asDouble <= range.high)))
            return expectation(std::is_integral_v<T>, range, lowest, highest);
        value = number;
        return {};
    } else {
        if (text.empty()) return "a name";
        value = text;
        return {};
    }
}

template <class T> std::string typeName()
{
    if constexpr (IsOptional<T>::value)
        return typeName<typename T::value_type>();
    else if constexpr (std::is_enum_v<T>) {
        const auto names = core::enumNames<T>();
        std::vector<std::string> known(names.begin(), names.end());
        return CLI::detail::join(known, "|");
    } else if constexpr (std::is_integral_v<T>)
        return "N";
    else if constexpr (std::is_floating_point_v<T>)
        return "X";
    else if constexpr (std::is_same_v<T, std::filesystem::path>)
        return "FILE";
    else
        return "TEXT";
}

/// The current value as the help shows it; empty when there is nothing worth showing.
template <class T> std::string defaultText(const T& value)
{
    if constexpr (IsOptional<T>::value)
        return value ? defaultText(*value) : std::string();
    else if constexpr (std::is_enum_v<T>)
        return std::string(core::enumName(value));
    else if constexpr (std::is_arithmetic_v<T>)
        return numberText(static_cast<double>(value));
    else
        return {};
}

/// Adds an option with one value, read into `member` (which holds the default). `name` as CLI11
/// takes it:
/// "-o,--output", "--spp", or a bare word for a positional. The last of several wins.
template <class T>
CLI::Option* addValue(CLI::App& app, const std::string& group, const std::string& name, T& member,
                      std::string help, core::Range range = {})
{
    std::string facts;
    if (range.low != range.high) facts = numberText(range.low) + " to " + numberText(range.high);
    const std::string shown = defaultText(member);
    if (!shown.empty()) facts += (facts.empty() ? "default " : ", default ") + shown;
    if (!facts.empty()) help += " (" + facts + ")";
    const CLI::callback_t read = [&member, range, name](const CLI::results_t& results) {
        const std::string problem = readValue(results.back(), range, member);
        if (!problem.empty())
            throw CLI::ValidationError(name.substr(name.rfind(',') + 1),
                                       "'" + results.back() + "' is not " + problem);
        return true;
    };
    return app.add_option(name, read, help)
        ->group(group)
        ->expected(1)
        ->type_name(typeName<T>())
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
}

/// Every parameter of a method as an option: names, help, ranges and defaults come from
/// Params::visit.
template <class Params> void addParams(CLI::App& app, const std::string& group, Params& params)
{
    Params::visit(params, [&](const core::Field& field, auto& member) {
        std::string help = field.help;
        if (field.biased) help += " [biased]";
        addValue(app, group, std::string("--") + field.name, member, help, field.range);
    });
}

/// Help of a command in at most 100 columns: usage, what it does, options by group, and the
/// example.
std::string helpText(const CLI::App& app, const std::string& usage);

/// Long and short names of all options of a command, as typed.
std::vector<std::string> optionNames(const CLI::App& app);

}  // namespace app
