// What a person means who names a scene: a file, or a folder that holds one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace app {

/// The extensions of scenes, lower case, with their dots.
const std::vector<std::string>& sceneExtensions();

/// Whether `file` goes by the name of a scene, or is a folder, which may hold one.
bool mayBeScene(const std::filesystem::path& file);

/// `named`, or the only scene in it when it is a folder. Throws core::Error (badInput) when there
/// is no such file, with the nearest name that there is, and when a folder holds none or several,
/// with their names.
std::filesystem::path scenePath(const std::filesystem::path& named);

}  // namespace app
