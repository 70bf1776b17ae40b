// Parameters set by name from JSON: for scripts and for equal-time runs. A visitor of the lists
// that also make the options.
#pragma once

#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/nearest.h"
#include "app/view/picture.h"
#include "core/check.h"
#include "core/params.h"

namespace app {

template <class Params> std::vector<std::string> paramNames()
{
    std::vector<std::string> names;
    Params params;
    Params::visit(params,
                  [&names](const core::Field& field, auto&) { names.emplace_back(field.name); });
    return names;
}

[[noreturn]] inline void refuseValue(const std::string& name, const nlohmann::ordered_json& value,
                                     const std::string& expected)
{
    throw core::Error(name + ": " + value.dump() + " is not " + expected,
                      core::ExitCode::commandLine);
}

template <class E>
void setEnum(const std::string& name, const nlohmann::ordered_json& value, E& member)
{
    const auto names = core::enumNames<E>();
    std::string known;
    for (size_t i = 0; i < names.size(); ++i) {
        if (value.is_string() && value.get<std::string>() == names[i]) {
            member = static_cast<E>(i);
            return;
        }
        known += (i > 0 ? ", " : "one of ") + std::string(names[i]);
    }
    refuseValue(name, value, known);
}

template <class T>
void setNumber(const std::string& name, const nlohmann::ordered_json& value, core::Range range,
               T& member)
{
    double low = static_cast<double>(std::numeric_limits<T>::lowest());
    double high = static_cast<double>(std::numeric_limits<T>::max());
    if (range.low != range.high) {
        low = std::max(low, range.low);
        high = std::min(high, range.high);
    }
    const double number =
        value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
    const bool whole = !std::is_integral_v<T> || value.is_number_integer();
    if (!(number >= low && number <= high) || !whole) {
        refuseValue(name, value,
                    std::string(std::is_integral_v<T> ? "a whole number" : "a number") + " from " +
                        nlohmann::ordered_json(low).dump() + " to " +
                        nlohmann::ordered_json(high).dump());
    }
    member = static_cast<T>(number);
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
        using Member = std::remove_cvref_t<decltype(member)>;
        if constexpr (std::is_enum_v<Member>) {
            setEnum(name, value, member);
        } else if constexpr (std::is_same_v<Member, bool>) {
            if (!value.is_boolean()) refuseValue(name, value, "true or false");
            member = value.get<bool>();
        } else {
            setNumber(name, value, field.range, member);
        }
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
