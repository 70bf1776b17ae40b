// `rekindle bench guiding`: what path guiding gains in error and costs in time.
#pragma once

#include <ostream>

#include "app/args/args.h"

namespace app {

/// Measures scene after scene; writes guiding.html, guiding.json, guiding.csv, pictures and
/// references into the folder, and a table to `out`. Returns the exit code. Throws core::Error.
int benchGuiding(const GuidingBenchOptions& options, std::ostream& out);

}  // namespace app
