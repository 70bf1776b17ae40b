// Results of the laboratory that nobody measured, for tests of what is made of them.
#pragma once

#include <string>

#include "app/lab/results.h"

namespace tests {

/// A cell at n = N = 8 with that expected N Var, and measured as expected.
app::lab::Cell cellOf(const std::string& pair, const std::string& function,
                      const std::string& method, double expected);

/// All pairs and functions with a few methods, their variances drawn at random; a little of all
/// else.
app::lab::LabResults someResults();

/// Every value that a measurement can have, and text that looks like markup.
app::lab::LabResults hostileResults();

}  // namespace tests
