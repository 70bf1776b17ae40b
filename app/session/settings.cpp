// Settings as JSON, from the descriptions of their parts. See settings.h. The folders are those of
// the XDG Base Directory Specification 0.8.
#include "app/session/settings.h"

#include <algorithm>
#include <optional>

#include "app/base/files.h"
#include "app/base/json_file.h"
#include "app/base/user_folders.h"
#include "app/files/params_json.h"
#include "app/session/settings_merge.h"
#include "core/base/check.h"
#include "core/base/output_file.h"

namespace app {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

constexpr int64_t kSettingsVersion = 1;
constexpr size_t kLongestPlaces = 1 << 16;
constexpr uint32_t kSmallestWindow = 64, kLargestWindow = 16384;

/// JSON is UTF-8; names of files need not be.
bool isUtf8(const std::string& text)
{
    try {
        Json(text).dump();
        return true;
    } catch (const Json::type_error&) {
        return false;
    }
}

/// The member, or null when `json` is no object or lacks it.
Json member(const Json& json, const char* name)
{
    return json.is_object() && json.contains(name) ? json[name] : Json();
}

/// A member that is an array; empty when it is something else.
Json listOf(const Json& json, const char* name)
{
    const Json list = member(json, name);
    return list.is_array() ? list : Json::array();
}

glm::uvec2 readWindow(const Json& json, glm::uvec2 fallback)
{
    glm::uvec2 size{};
    const core::Field field{"", "", {kSmallestWindow, kLargestWindow}};
    if (!json.is_array() || json.size() != 2 || !readMember(json[0], field, size.x).empty() ||
        !readMember(json[1], field, size.y).empty())
        return fallback;
    return size;
}

std::string textOf(const Json& json, const char* name, const char* otherwise)
{
    const Json text = member(json, name);
    return text.is_string() ? text.get<std::string>() : otherwise;
}

void readMethods(const Json& json, Settings& s)
{
    for (const core::MethodInfo& method : core::methods()) {
        const std::string id(method.id());
        Json kept = member(member(json, "methods"), id.c_str());
        if (kept.is_null()) kept = member(json, id.c_str());  // as older versions kept "path"
        if (!kept.is_object()) continue;
        core::AnyParams params = method.defaults;
        (void)readParams(kept, params, id);
        s.methods.emplace(id, params);
    }
}

/// How pictures are looked at is kept; what was looked at, and how bright it was, belongs to one
/// picture: the first thing that a new run shows is the picture itself.
ViewParams lasting(ViewParams view)
{
    const ViewParams fresh;
    view.show = fresh.show;
    view.methodMap = fresh.methodMap;
    view.exposure = fresh.exposure;
    view.compareAt = fresh.compareAt;
    return view;
}

/// What is over the picture is kept, but not that all of it was hidden: a start shows the panel.
PanelParams lasting(PanelParams panels)
{
    panels.panel = PanelParams().panel;
    return panels;
}

Settings settingsOf(const Json& json)
{
    Settings s;
    // What is wrong with single values is not worth a word: each has a default.
    (void)readParams(member(json, "view"), s.view, "view");
    s.view = lasting(s.view);
    (void)readParams(member(json, "panels"), s.panels, "panels");
    s.panels = lasting(s.panels);
    (void)readParams(member(json, "sections"), s.sections, "sections");
    readMethods(json, s);
    s.places = textOf(json, "places", "");
    if (s.places.size() > kLongestPlaces) s.places.clear();
    s.windowSize = readWindow(member(json, "window"), s.windowSize);
    for (const Json& file : listOf(json, "recent")) {
        const std::string name = file.is_string() ? file.get<std::string>() : "";
        if (fs::path(name).is_absolute() && s.recentFiles.size() < kMostRecent &&
            std::count(s.recentFiles.begin(), s.recentFiles.end(), name) == 0)
            s.recentFiles.push_back(name);
    }
    for (const Json& entry : listOf(json, "presets")) {
        const Json name = member(entry, "name");
        if (!name.is_string() || name.get<std::string>().empty()) continue;
        // Before there were several methods it was the path tracer's and called so.
        const core::MethodInfo* method = core::findMethod(textOf(entry, "method", "path"));
        if (method == nullptr) continue;  // of another version
        Preset preset{name.get<std::string>(), method->defaults};
        const char* const place = entry.contains("params") ? "params" : "path";
        (void)readParams(member(entry, place), preset.params, preset.name);
        s.presets.push_back(preset);
    }
    const Json cameras = member(json, "cameras");
    if (cameras.is_object())
        for (const auto& [hash, list] : cameras.items())
            if (list.is_array() && !list.empty()) s.cameras[hash] = jsonText(list);
    return s;
}

Json settingsJson(const Settings& s)
{
    Json recent = Json::array(), presets = Json::array(), cameras = Json::object();
    Json methods = Json::object();
    for (const auto& [id, params] : s.methods) methods[id] = paramsJson(params);
    for (const std::string& file : s.recentFiles)
        if (isUtf8(file)) recent.push_back(file);
    for (const Preset& preset : s.presets)
        if (isUtf8(preset.name))
            presets.push_back({{"name", preset.name},
                               {"method", std::string(preset.params.id())},
                               {"params", paramsJson(preset.params)}});
    for (const auto& [hash, text] : s.cameras) {
        const Json list = Json::parse(text, nullptr, false);  // our own text, unless a caller errs
        if (isUtf8(hash) && list.is_array() && !list.empty()) cameras[hash] = list;
    }
    return {{"version", kSettingsVersion},
            {"view", paramsJson(lasting(s.view))},
            {"panels", paramsJson(lasting(s.panels))},
            {"sections", paramsJson(s.sections)},
            {"methods", methods},
            {"places", isUtf8(s.places) ? s.places : std::string()},
            {"window", {s.windowSize.x, s.windowSize.y}},
            {"recent", recent},
            {"presets", presets},
            {"cameras", cameras}};
}

/// `file` with `ending` behind its name.
fs::path besideOf(fs::path file, const char* ending)
{
    file += ending;
    return file;
}

/// Keeps a file that cannot be understood; returns the end of the sentence about it.
std::string setAside(const fs::path& file)
{
    const fs::path bad = besideOf(file, ".bad");
    std::error_code error;
    fs::rename(file, bad, error);
    return error ? " — it could not be renamed (" + error.message() + "), the defaults are used"
                 : " — kept as " + bad.string() + ", the defaults are used";
}

/// The version of a settings file; nothing when there is none that makes sense.
std::optional<int64_t> versionOf(const Json& json)
{
    const Json version = member(json, "version");
    if (!version.is_number_integer() || version.get<int64_t>() < 1) return {};
    return version.get<int64_t>();
}

/// What another viewer may have written since; nothing where that is not of this version.
std::optional<Json> presentJson(const fs::path& file)
{
    try {
        Json json = parseJson(readText(file), file.string());
        if (versionOf(json) == kSettingsVersion) return json;
    } catch (const core::Error&) {
    }
    return {};
}

}  // namespace

core::AnyParams Settings::paramsOf(std::string_view method) const
{
    const auto kept = methods.find(std::string(method));
    return kept != methods.end() ? kept->second : core::methodNamed(method).defaults;
}

void Settings::keepParams(const core::AnyParams& params)
{
    methods[std::string(params.id())] = params;
}

void Settings::addRecent(const fs::path& file)
{
    std::error_code error;
    fs::path absolute = fs::absolute(file, error);
    if (error) return;
    const std::string name = absolute.lexically_normal().string();
    std::erase(recentFiles, name);
    recentFiles.insert(recentFiles.begin(), name);
    if (recentFiles.size() > kMostRecent) recentFiles.resize(kMostRecent);
}

fs::path settingsFile()
{
    const fs::path folder = userSettingsFolder();
    return folder.empty() ? fs::path() : folder / "settings.json";
}

Settings readSettings(const fs::path& file, std::string& problem)
{
    problem.clear();
    if (file.empty()) {
        problem = "settings are not kept: neither XDG_CONFIG_HOME nor HOME names a folder";
        return {};
    }
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (status.type() == fs::file_type::not_found) return {};
    std::string text;
    try {
        text = readText(file);
    } catch (const core::Error& unreadable) {
        // A file that stayed would be replaced when the program ends.
        problem =
            unreadable.what() +
            (status.type() == fs::file_type::regular ? setAside(file) : " — the defaults are used");
        return {};
    }
    Json json;
    try {
        json = parseJson(text, file.string());
        if (!versionOf(json)) throw core::Error(file.string() + ": not settings of this program");
    } catch (const core::Error& damaged) {
        problem = damaged.what() + setAside(file);
        return {};
    }
    if (*versionOf(json) > kSettingsVersion) {
        const fs::path kept = besideOf(file, ".newer");
        fs::copy_file(file, kept, fs::copy_options::overwrite_existing, error);
        problem = file.string() + ": written by a newer version; read as far as it is understood" +
                  (error ? "" : " — kept as " + kept.string());
    }
    return settingsOf(json);
}

glm::uvec2 keptWindowSize(const fs::path& file)
{
    const glm::uvec2 fresh = Settings().windowSize;
    try {
        const Json json = parseJson(readText(file), file.string());
        return versionOf(json) ? readWindow(member(json, "window"), fresh) : fresh;
    } catch (const core::Error&) {
        return fresh;  // readSettings says why
    }
}

static void writeJson(const fs::path& file, const Json& json)
{
    if (file.empty()) throw core::Error("settings: there is no folder to keep them in");
    std::error_code error;
    // Behind a link, which people use to keep their settings elsewhere, the file itself is
    // replaced.
    fs::path target = fs::is_symlink(file, error) ? fs::weakly_canonical(file, error) : file;
    if (error) target = file;
    const fs::path folder = target.parent_path();
    if (!folder.empty()) fs::create_directories(folder, error);
    if (error)
        throw core::Error(target.string() + ": its folder cannot be made: " + error.message());
    core::writeFile(target, jsonText(json, 2) + '\n');
}

void writeSettings(const fs::path& file, const Settings& settings)
{
    writeJson(file, settingsJson(settings));
}

void writeChanges(const fs::path& file, Settings known, const Settings& now)
{
    // A method that has no parameters of its own has the defaults.
    for (const auto& [id, params] : now.methods) known.methods.emplace(id, known.paramsOf(id));
    const Json base = settingsJson(known);
    const std::optional<Json> theirs = presentJson(file);
    const Json merged = mergedSettings(base, settingsJson(now), theirs.value_or(base));
    if (!theirs || merged != *theirs) writeJson(file, merged);
}

}  // namespace app
