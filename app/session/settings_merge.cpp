// See settings_merge.h.
#include "app/session/settings_merge.h"

#include <algorithm>
#include <string>

#include <nlohmann/json.hpp>

namespace app {

namespace {

using Json = nlohmann::ordered_json;

Json merged(const Json& base, const Json& mine, const Json& theirs)
{
    if (mine == base) return theirs;
    if (!base.is_object() || !mine.is_object() || !theirs.is_object()) return mine;
    Json result = theirs;
    for (const auto& [name, value] : mine.items()) {
        if (!base.contains(name) || !theirs.contains(name)) {
            if (!base.contains(name) || base[name] != value) result[name] = value;
            continue;
        }
        result[name] = merged(base[name], value, theirs[name]);
    }
    for (const auto& [name, value] : base.items())
        if (!mine.contains(name)) result.erase(name);
    return result;
}

Json arrayOf(const Json& settings, const char* name)
{
    return settings.contains(name) && settings[name].is_array() ? settings[name] : Json::array();
}

std::string memberText(const Json& json, const char* name)
{
    return json.contains(name) ? json[name].dump() : "";
}

/// Presets by method and name, so that they can be merged one by one.
Json byName(const Json& presets)
{
    Json named = Json::object();
    for (const Json& preset : presets)
        if (preset.is_object())
            named[memberText(preset, "method") + memberText(preset, "name")] = preset;
    return named;
}

Json mergedPresets(const Json& base, const Json& mine, const Json& theirs)
{
    Json list = Json::array();
    const Json named = merged(byName(base), byName(mine), byName(theirs));
    for (const auto& [name, preset] : named.items()) list.push_back(preset);
    return list;
}

/// Theirs, with what is new in mine before them, and before all the one that mine begins with.
Json mergedRecent(const Json& base, const Json& mine, const Json& theirs)
{
    if (mine == base) return theirs;
    Json list = Json::array();
    const auto add = [&list](const Json& file) {
        if (std::ranges::count(list, file) == 0 && list.size() < kMostRecent) list.push_back(file);
    };
    for (const Json& file : mine)
        if (file == mine.front() || std::ranges::count(base, file) == 0) add(file);
    for (const Json& file : theirs) add(file);
    return list;
}

}  // namespace

Json mergedSettings(const Json& base, const Json& mine, const Json& theirs)
{
    Json result = merged(base, mine, theirs);
    const auto lists = [&](const char* name, auto&& merge) {
        result[name] = merge(arrayOf(base, name), arrayOf(mine, name), arrayOf(theirs, name));
    };
    lists("presets", mergedPresets);
    lists("recent", mergedRecent);
    return result;
}

}  // namespace app
