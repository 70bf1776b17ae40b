// `rekindle devices`: Vulkan devices and what each lacks.
#pragma once

#include <ostream>

#include "app/args/args.h"

namespace app {

/// Prints the list and returns the exit code: done when a device is suitable, noDevice otherwise.
/// Throws core::Error.
int devicesCommand(const DevicesOptions& options, std::ostream& out);

}  // namespace app
