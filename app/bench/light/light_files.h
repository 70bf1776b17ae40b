// Results of ways to find light as JSON, as CSV and as a short table for the terminal.
#pragma once

#include <string>

#include "app/bench/light/light_results.h"

namespace app::light {

/// Schema 1: keys may be added, none renamed. Ends in a newline. What is not known is null.
std::string resultsJson(const Results& results);

/// The rows, with the names of columns first.
std::string rowsCsv(const Results& results);

/// Per scene all rows.
std::string resultsTable(const Results& results);

}  // namespace app::light
