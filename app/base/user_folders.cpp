// See user_folders.h.
#include "app/base/user_folders.h"

#include <cstdlib>

namespace app {

namespace fs = std::filesystem;

/// The folder that a variable names. Others than absolute ones are to be ignored, says the
/// specification.
static fs::path folderIn(const char* variable)
{
    const char* value = std::getenv(variable);
    return value != nullptr && value[0] == '/' ? fs::path(value) : fs::path();
}

static fs::path userFolder(const char* variable, const char* inHome)
{
    if (const fs::path folder = folderIn(variable); !folder.empty()) return folder / "rekindle";
    if (const fs::path home = folderIn("HOME"); !home.empty()) return home / inHome / "rekindle";
    return {};
}

fs::path userCacheFolder()
{
    return userFolder("XDG_CACHE_HOME", ".cache");
}

fs::path userSettingsFolder()
{
    return userFolder("XDG_CONFIG_HOME", ".config");
}

}  // namespace app
