// From a file's name to what renderers read, and a loader's warnings as text.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "app/args/args.h"
#include "core/base/progress.h"
#include "core/scene/world.h"

namespace app {

struct LoadedWorld {
    std::filesystem::path file;  // that was meant: see scenePath
    std::shared_ptr<const core::World> world;
    double seconds = 0;
    std::string note;  // what was done to it unasked, or empty
};

/// Loads and flattens the scene of a file, or of a folder that holds one. `forcedFeatures`: see
/// core::makeWorld. Throws core::Error, also for a warning when the options are strict, and
/// (interrupted) when `stop` is requested.
LoadedWorld loadWorld(const SceneOptions& options, uint32_t forcedFeatures,
                      const core::Progress& progress, std::stop_token stop = {});

/// Throws core::Error for the first warning where the options are strict; `when` goes before it.
void refuseWarnings(const core::Warnings& warnings, const SceneOptions& options,
                    const std::filesystem::path& file, const std::string& when = {});

/// The scene to show when none is named, assets/cornell-diffuse.gltf: of the installed program in
/// ../share/rekindle, of the one that the repository builds beside its folder, else below the
/// current folder.
std::filesystem::path defaultScene();

/// One line per listed warning and one per code for those that are only counted.
std::vector<std::string> warningLines(const core::Warnings& warnings);

}  // namespace app
