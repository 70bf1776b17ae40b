// Results of path guiding as JSON, as CSV and as a short table for the terminal.
#pragma once

#include <string>

#include "app/bench/guiding/guiding_results.h"

namespace app::guiding {

/// Schema 1: keys may be added, none renamed. Ends in a newline. What is not known is null.
std::string resultsJson(const Results& results);

/// The rows, with the names of columns first.
std::string rowsCsv(const Results& results);

/// Per scene all rows, and the goals of which something was measured.
std::string resultsTable(const Results& results);

}  // namespace app::guiding
