// What the program does without a display: a short flight through a scene, as numbered pictures.
#pragma once

#include <filesystem>

#include "app/args.h"

namespace app {

/// What is shown when no scene is named: in assets/ beside the folder of the program, which is
/// where the repository builds it, or below the current folder.
std::filesystem::path defaultScene();

/// Renders the frames into ./rekindle-frames and prints where they are. Returns the exit code.
/// Throws core::Error.
int flyThrough(const FlyThroughOptions& options);

}  // namespace app
