// Parameters set by name from JSON: for scripts and for equal-time runs. A visitor of the lists
// that also make the options.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/base/nearest.h"
#include "app/files/params_json.h"
#include "app/pictures/picture.h"
#include "core/base/check.h"
#include "core/base/params.h"
#include "core/methods/method.h"

namespace app {

template <class Params> std::vector<std::string> paramNames(const Params& params = {})
{
    std::vector<std::string> names;
    Params::visit(params, [&names](const core::Field& field, const auto&) {
        names.emplace_back(field.name);
    });
    return names;
}

/// Sets the member of that name; false when there is none. Throws core::Error for a value that does
/// not fit.
template <class Params>
bool setParam(Params& params, const std::string& name, const nlohmann::ordered_json& value)
{
    bool found = false;
    Params::visit(params, [&](const core::Field& field, auto& member) {
        if (name != field.name) return;
        found = true;
        const std::string expected = readMember(value, field, member);
        if (!expected.empty())
            throw core::Error(name + ": " + value.dump() + " is not " + expected,
                              core::ExitCode::commandLine);
    });
    return found;
}

/// The same for device, method and limits as well as the method's parameters. Another method begins
/// with its defaults.
inline bool setRenderParam(RenderParams& params, const std::string& name,
                           const nlohmann::ordered_json& value)
{
    if (name != "method")
        return setParam(params, name, value) || setParam(params.method, name, value);
    const std::string id = value.is_string() ? value.get<std::string>() : value.dump();
    if (id != params.method.id()) params.method = core::methodNamed(id).defaults;
    return true;
}

/// Several parameters at once, {"method": ..., "max-depth": ...}: the method first, wherever it
/// stands, since the others may be its own. Returns the first name that there is not, or nothing.
inline std::string setRenderParams(RenderParams& params, const nlohmann::ordered_json& values)
{
    if (values.contains("method")) setRenderParam(params, "method", values["method"]);
    for (const auto& [name, value] : values.items())
        if (!setRenderParam(params, name, value)) return name;
    return {};
}

inline std::vector<std::string> renderParamNames(const RenderParams& params)
{
    std::vector<std::string> names = paramNames(params);
    names.emplace_back("method");
    for (const std::string& name : paramNames(params.method)) names.push_back(name);
    return names;
}

inline core::Error unknownParam(const std::string& name, const std::vector<std::string>& names)
{
    return core::Error("there is no parameter \"" + name + "\"" + suggestion(name, names),
                       core::ExitCode::commandLine);
}

}  // namespace app
