// The files that a scene is made of.
#pragma once

#include <filesystem>
#include <vector>

namespace app {

/// Files that the document `scene` (.gltf or .glb) names by a "uri": buffers, images, a panorama.
/// Only names of files that are there; no more is looked at. Empty where it cannot be read: who
/// loads the scene says why.
std::vector<std::filesystem::path> filesNamedBy(const std::filesystem::path& scene);

}  // namespace app
