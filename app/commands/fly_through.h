// What the program does without a display: a short flight through a scene, as numbered pictures.
#pragma once

#include <filesystem>

#include "app/args/args.h"

namespace app {

/// Renders the frames into ./rekindle-frames, or into rekindle-frames-2, -3, ... where there is
/// one, and prints where they are; where there is no frame, no folder stays. Returns the exit code.
/// Throws core::Error.
int flyThrough(const FlyThroughOptions& options);

}  // namespace app
