// `rekindle info`: what a scene holds, needs and gets wrong.
#pragma once

#include <ostream>

#include "app/args/args.h"

namespace app {

/// Loads the scene, prints text or JSON and returns the exit code. Throws core::Error.
int infoCommand(const InfoOptions& options, std::ostream& out);

}  // namespace app
