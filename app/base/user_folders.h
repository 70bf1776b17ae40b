// Where the program may keep things of this user between runs, by the XDG base directory
// specification.
#pragma once

#include <filesystem>

namespace app {

/// $XDG_CACHE_HOME/rekindle, else ~/.cache/rekindle: what may be lost. Empty when neither is known.
std::filesystem::path userCacheFolder();

/// $XDG_CONFIG_HOME/rekindle, else ~/.config/rekindle. Empty when neither is known.
std::filesystem::path userSettingsFolder();

}  // namespace app
