// `rekindle view` and `rekindle SCENE`: the window, or what is done where there is none.
#pragma once

#include "app/args/args.h"

namespace app {

/// Runs the window until it is closed and returns the exit code. Without a display: a fly-through
/// (see fly_through.h), unless a script or a picture to return to was asked for, which need one.
/// Throws core::Error.
int viewCommand(const ViewOptions& options);

}  // namespace app
