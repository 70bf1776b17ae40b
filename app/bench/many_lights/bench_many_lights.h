// `rekindle bench manylights`: many lights, time against error, for every way to find visibility.
#pragma once

#include <ostream>

#include "app/args/args.h"

namespace app {

/// Measures scene after scene; writes index.html, manylights.json, pictures and references into the
/// folder, and a table to `out`. Returns the exit code. Throws core::Error.
int benchManyLights(const ManyLightsBenchOptions& options, std::ostream& out);

}  // namespace app
