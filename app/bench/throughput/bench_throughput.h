// `rekindle bench throughput`: rays and samples per second of the GPU kernels against Embree's.
#pragma once

#include <ostream>

#include "app/args/args.h"

namespace app {

/// Measures, prints JSON on `out` and returns the exit code. Throws core::Error.
int benchThroughput(const ThroughputOptions& options, std::ostream& out);

}  // namespace app
