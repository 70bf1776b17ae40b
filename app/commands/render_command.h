// `rekindle render`: a scene to picture files, with statistics.
#pragma once

#include <functional>
#include <memory>

#include "app/args/args.h"
#include "app/files/camera_file.h"
#include "core/methods/renderer.h"

namespace app {

/// Makes the path of the camera once the world is known.
using PathMaker = std::function<CameraPath(const core::World& world)>;

/// Renders what the options say and returns the exit code. Throws core::Error.
int renderCommand(const RenderOptions& options);

/// The same with the frames of a path that is not in a file; `options.frames` is set.
int renderFrames(const RenderOptions& options, const PathMaker& makePath);

using RendererMaker = std::function<std::unique_ptr<core::Renderer>()>;

/// The same with any renderer; `makePath` may be empty.
int renderWith(const RenderOptions& options, const PathMaker& makePath,
               const RendererMaker& makeRenderer);

}  // namespace app
