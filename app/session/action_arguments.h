// Arguments of an action, read from its JSON and checked: a wrong one is refused with its name.
// Only the files of actions include this.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/files/path_completion.h"
#include "app/session/actions.h"
#include "core/base/check.h"

namespace app {

[[noreturn]] inline void refuse(const char* name, const char* expected)
{
    throw core::Error(std::string(name) + ": expected " + expected, core::ExitCode::commandLine);
}

inline double number(const ActionContext& c, const char* name, std::optional<double> otherwise = {})
{
    const auto found = c.arguments.find(name);
    if (found == c.arguments.end()) {
        if (otherwise) return *otherwise;
        refuse(name, "a number");
    }
    if (!found->is_number()) refuse(name, "a number");
    return found->get<double>();
}

/// A whole number from 0 to 2^31.
inline uint32_t count(const ActionContext& c, const char* name,
                      std::optional<double> otherwise = {})
{
    const double value = number(c, name, otherwise);
    if (!(value >= 0 && value <= 2147483648.0 && value == std::floor(value)))
        refuse(name, "a whole number from 0");
    return static_cast<uint32_t>(value);
}

inline bool truth(const ActionContext& c, const char* name, bool otherwise)
{
    const auto found = c.arguments.find(name);
    if (found == c.arguments.end()) return otherwise;
    if (!found->is_boolean()) refuse(name, "true or false");
    return found->get<bool>();
}

inline std::string text(const ActionContext& c, const char* name,
                        std::optional<std::string> otherwise = {})
{
    const auto found = c.arguments.find(name);
    if (found == c.arguments.end()) {
        if (otherwise) return *otherwise;
        refuse(name, "a text");
    }
    if (!found->is_string()) refuse(name, "a text");
    return found->get<std::string>();
}

/// The name of a file as a user types it: `~` is the home folder.
inline std::string fileName(const ActionContext& c, const char* name,
                            std::optional<std::string> otherwise = {})
{
    return expandHome(text(c, name, std::move(otherwise)));
}

}  // namespace app
