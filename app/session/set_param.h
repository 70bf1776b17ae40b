// Parameters set by name from JSON: for scripts and for equal-time runs. A visitor of the lists
// that also make the options.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/base/nearest.h"
#include "app/files/params_json.h"
#include "app/session/picture.h"
#include "core/base/check.h"
#include "core/base/params.h"

namespace app {

template <class Params> std::vector<std::string> paramNames()
{
    std::vector<std::string> names;
    Params params;
    Params::visit(params,
                  [&names](const core::Field& field, auto&) { names.emplace_back(field.name); });
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

/// The same for device, method and limits as well as the method's parameters.
inline bool setRenderParam(RenderParams& params, const std::string& name,
                           const nlohmann::ordered_json& value)
{
    return setParam(params, name, value) || setParam(params.path, name, value);
}

inline std::vector<std::string> renderParamNames()
{
    std::vector<std::string> names = paramNames<RenderParams>();
    for (const std::string& name : paramNames<core::PathParams>()) names.push_back(name);
    return names;
}

inline core::Error unknownParam(const std::string& name, const std::vector<std::string>& names)
{
    return core::Error("there is no parameter \"" + name + "\"" + suggestion(name, names),
                       core::ExitCode::commandLine);
}

}  // namespace app
