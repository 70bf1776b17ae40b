// What measurements over several scenes have in common: scenes, and names of what belongs to them.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "app/bench/bench_run.h"
#include "core/scene/world.h"

namespace app {

/// Looks at every file before work begins. Throws core::Error naming the first that is not there.
void requireFiles(std::span<const SceneOptions> scenes);

/// The file's name without its ending, with a number behind it where `taken` has it already.
std::string sceneName(const std::filesystem::path& file, const std::vector<std::string>& taken);

/// A scene from its file, with its warnings said.
std::shared_ptr<const core::World> loadBenchScene(const SceneOptions& options,
                                                  const BenchTools& tools);

/// The size at which a scene is measured unless it is given: as many pixels as 192x108, or 256x256
/// where the picture is about square.
glm::uvec2 usualSize(const core::Camera& camera);

/// "references/room-640x360-REST.exr" in the folder of results.
std::filesystem::path referenceFile(const std::filesystem::path& folder, const std::string& scene,
                                    glm::uvec2 size, const std::string& rest);

/// "640x360".
std::string sizeText(glm::uvec2 size);

}  // namespace app
