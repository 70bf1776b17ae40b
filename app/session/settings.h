// What is kept between runs: $XDG_CONFIG_HOME/rekindle/settings.json (or ~/.config). Versioned,
// written to a temporary name and renamed; a file that cannot be read is kept as settings.json.bad
// and the defaults are used.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "app/pictures/view_params.h"
#include "core/methods/method.h"

namespace app {

/// A named set of a method's parameters, the user's own; those that come with a method are in its
/// MethodInfo.
struct Preset {
    std::string name;
    core::AnyParams params;

    friend bool operator==(const Preset&, const Preset&) = default;
};

struct SavedCamera {
    std::string name;
    core::Camera camera;  // world space of the scene
};

struct Settings {
    ViewParams view;
    PanelParams panels;
    SectionParams sections;
    std::map<std::string, core::AnyParams>
        methods;                       // parameters last used, by id; else the defaults
    std::string places;                // of the windows over the picture, as the panel writes them
    glm::uvec2 windowSize{1280, 720};  // each side from 64 to 16384
    std::vector<std::string> recentFiles;  // newest first, absolute, at most 12
    std::vector<Preset> presets;           // the user's own
    // Scene::fileHash -> JSON array of cameras in the file's space
    std::map<std::string, std::string> cameras;

    /// Parameters of a method as they were last.
    core::AnyParams paramsOf(std::string_view method) const;
    void keepParams(const core::AnyParams& params);

    /// Puts the file first; one that is there already is moved.
    void addRecent(const std::filesystem::path& file);

    friend bool operator==(const Settings&, const Settings&) = default;
};

/// Where the settings of this user are kept; empty when neither XDG_CONFIG_HOME nor HOME is an
/// absolute path.
std::filesystem::path settingsFile();

/// Never throws for bad contents: unknown members are ignored, values outside their range fall back
/// to the default, and `problem` says what was wrong with the file as a whole (empty: nothing; a
/// file that does not exist is nothing, an empty name is a problem). A file of a newer version is
/// read as far as it is understood and kept as settings.json.newer.
Settings readSettings(const std::filesystem::path& file, std::string& problem);

/// The size of the window alone, before readSettings: nothing is renamed or told, and what cannot
/// be read has the default.
glm::uvec2 keptWindowSize(const std::filesystem::path& file);

/// Makes the folders that lack. Throws core::Error when the file cannot be written.
void writeSettings(const std::filesystem::path& file, const Settings& settings);

/// The same for what differs between `known` and `now`; the rest of the file stays as another
/// viewer may have written it meanwhile. Of each value, of each scene's cameras and of each preset
/// the last who changed it wins; recent files are those of both.
void writeChanges(const std::filesystem::path& file, Settings known, const Settings& now);

}  // namespace app
