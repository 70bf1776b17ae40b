// See scene_path.h.
#include "app/files/scene_path.h"

#include <algorithm>

#include "app/args/args.h"
#include "app/base/nearest.h"
#include "app/files/folder_list.h"
#include "core/base/check.h"

namespace app {

namespace fs = std::filesystem;

namespace {

constexpr size_t kMostNamed = 8;

std::string listed(const std::vector<std::string>& names)
{
    std::string text;
    for (size_t i = 0; i < names.size() && i < kMostNamed; ++i)
        text += (i > 0 ? ", " : "") + names[i];
    return names.size() > kMostNamed ? text + ", ..." : text;
}

fs::path onlySceneIn(const fs::path& folder)
{
    std::vector<std::string> scenes;
    for (const FolderEntry& entry : listFolder(folder, sceneExtensions()))
        if (!entry.folder) scenes.push_back(entry.name);
    if (scenes.size() == 1) return folder / scenes.front();
    if (scenes.empty())
        throw core::Error(folder.string() +
                          ": is a folder without a scene in it — give a .gltf or .glb file");
    throw core::Error(folder.string() + ": is a folder with " + std::to_string(scenes.size()) +
                      " scenes — give one of them: " + listed(scenes));
}

/// "; did you mean X?" of what lies beside it.
std::string nearestScene(const fs::path& missing)
{
    const fs::path folder = missing.parent_path();
    std::vector<std::string> names;
    for (const FolderEntry& entry : listFolder(folder.empty() ? "." : folder, sceneExtensions()))
        names.push_back(entry.name);
    const std::string nearest = nearestName(missing.filename().string(), names);
    return nearest.empty() ? "" : "; did you mean " + (folder / nearest).string() + "?";
}

}  // namespace

const std::vector<std::string>& sceneExtensions()
{
    static const std::vector<std::string> extensions{".gltf", ".glb"};
    return extensions;
}

bool mayBeScene(const fs::path& file)
{
    std::error_code unknown;
    return fs::is_directory(file, unknown) ||
           std::ranges::any_of(sceneExtensions(),
                               [&](const std::string& e) { return hasExtension(file, e); });
}

fs::path scenePath(const fs::path& named)
{
    std::error_code unknown;
    const fs::file_status status = fs::status(named, unknown);
    if (fs::is_directory(status)) return onlySceneIn(named);
    if (status.type() == fs::file_type::not_found)
        throw core::Error(named.string() + ": no such file" + nearestScene(named));
    return named;
}

}  // namespace app
