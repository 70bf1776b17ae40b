// `rekindle render`: a scene to picture files, with statistics.
#pragma once

#include <functional>

#include "app/args.h"
#include "app/camera_file.h"

namespace app {

/// Makes the path of the camera once the world is known.
using PathMaker = std::function<CameraPath(const core::World& world)>;

/// Renders what the options say and returns the exit code. Throws core::Error.
int renderCommand(const RenderOptions& options);

/// The same with the frames of a path that is not in a file. `options.frames` is set.
int renderFrames(const RenderOptions& options, const PathMaker& makePath);

}  // namespace app
