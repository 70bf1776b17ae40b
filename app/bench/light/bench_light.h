// `rekindle bench light`: what each way to find light gains in error and costs in time.
#pragma once

#include <ostream>

#include "app/args/args.h"

namespace app {

/// Measures scene after scene; writes light.html, light.json and light.csv into the folder, and a
/// table to `out`. Returns the exit code. Throws core::Error.
int benchLight(const LightBenchOptions& options, std::ostream& out);

}  // namespace app
