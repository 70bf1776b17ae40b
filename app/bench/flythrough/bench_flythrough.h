// `rekindle bench flythrough`: what sample reuse gains and loses when a camera flies.
#pragma once

#include <ostream>

#include "app/args/args.h"

namespace app {

/// Measures, writes the page and its numbers into the folder, prints a table on `out` and returns
/// the exit code. Throws core::Error.
int benchFlythrough(const FlightBenchOptions& options, std::ostream& out);

}  // namespace app
