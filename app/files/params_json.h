// Described parameters as JSON, both ways: visitors of the one list that also makes the options
// (core/base/params.h).
#pragma once

#include <algorithm>
#include <string>
#include <type_traits>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/base/read_value.h"
#include "core/base/params.h"

namespace app {

/// {"max-depth": 8, ...}: names as on the command line, enumerations by name.
template <class Params> nlohmann::ordered_json paramsJson(const Params& params)
{
    nlohmann::ordered_json json = nlohmann::ordered_json::object();
    Params::visit(params, [&json](const core::Field& field, const auto& member) {
        using Member = std::remove_cvref_t<decltype(member)>;
        if constexpr (std::is_enum_v<Member>)
            json[field.name] = std::string(core::enumName(member));
        else
            json[field.name] = member;
    });
    return json;
}

/// Reads one value as paramsJson writes it: enumerations by name, numbers inside the field's range.
/// Returns what was expected instead (and leaves `member` as it was), or nothing on success.
template <class T>
std::string readMember(const nlohmann::ordered_json& json, const core::Field& field, T& member)
{
    const bool kind = std::is_enum_v<T>         ? json.is_string()
                      : std::is_same_v<T, bool> ? json.is_boolean()
                      : std::is_integral_v<T>   ? json.is_number_integer()
                                                : json.is_number();
    // A value of another kind is read as an empty text, which no type accepts.
    const std::string text = !kind ? "" : json.is_string() ? json.get<std::string>() : json.dump();
    return readValue(text, field.range, member);
}

/// What is wrong with a described set of parameters in JSON.
struct ParamProblem {
    enum Kind { missing, unknown, wrong } kind;
    std::string name;
    std::string text;  // "params: max-depth: '99999' is not a whole number from 0 to 4096"
};

/// Reads what `json` has of the parameters; each that it lacks or that is wrong stays as it was.
/// `place` leads the texts.
template <class Params>
std::vector<ParamProblem> readParams(const nlohmann::ordered_json& json, Params& params,
                                     const std::string& place)
{
    using Kind = ParamProblem::Kind;
    if (!json.is_object()) return {{Kind::wrong, "", place + ": expected an object"}};
    std::vector<ParamProblem> problems;
    std::vector<std::string> known;
    Params::visit(params, [&](const core::Field& field, auto& member) {
        known.emplace_back(field.name);
        const auto found = json.find(field.name);
        if (found == json.end()) {
            problems.push_back(
                {Kind::missing, field.name, place + ": " + field.name + " is missing"});
            return;
        }
        const std::string expected = readMember(*found, field, member);
        if (!expected.empty())
            problems.push_back(
                {Kind::wrong, field.name,
                 place + ": " + field.name + ": " + found->dump() + " is not " + expected});
    });
    for (const auto& [name, value] : json.items())
        if (std::find(known.begin(), known.end(), name) == known.end())
            problems.push_back(
                {Kind::unknown, name, place + ": there is no " + name + suggestion(name, known)});
    return problems;
}

/// Names of the parameters that bias the image by what they are.
template <class Params> std::vector<std::string> biasedParams(const Params& params)
{
    const Params defaults = core::defaultsOf(params);
    std::vector<std::string> names;
    Params::visit(params, [&](const core::Field& field, const auto& value) {
        const auto* standard =
            core::findParam<std::remove_cvref_t<decltype(value)>>(defaults, field.name);
        if (core::biases(field, value, *standard)) names.emplace_back(field.name);
    });
    return names;
}

}  // namespace app
