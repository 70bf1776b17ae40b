// `rekindle lab`: runs the laboratory of sample reuse and writes its report.
#pragma once

#include <ostream>

#include "app/args/args.h"

namespace app {

/// Measures, writes the folder, prints one line of JSON that names the page, and returns the exit
/// code; after Ctrl-C `interrupted`, with nothing written. Throws core::Error where the folder
/// cannot be written, before the work begins.
int labCommand(const LabOptions& options, std::ostream& out);

}  // namespace app
