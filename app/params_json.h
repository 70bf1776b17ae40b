// Parameters of a method as JSON: a visitor of the one list that also makes the options
// (core/params.h).
#pragma once

#include <string>
#include <type_traits>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/params.h"

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

/// Names of the parameters that bias the image: marked so, and not at their default, which never
/// biases.
template <class Params> std::vector<std::string> biasedParams(const Params& params)
{
    const nlohmann::ordered_json defaults = paramsJson(Params{}), now = paramsJson(params);
    std::vector<std::string> names;
    Params::visit(params, [&](const core::Field& field, const auto&) {
        if (field.biased && now[field.name] != defaults[field.name]) names.emplace_back(field.name);
    });
    return names;
}

}  // namespace app
