// Results of flights as JSON, as CSV and as a short table for the terminal.
#pragma once

#include <string>

#include "app/bench/flythrough/flight_results.h"

namespace app::flight {

/// Schema 1: keys may be added, none renamed. Ends in a newline. What is not known is null.
std::string resultsJson(const Results& results);

/// The rows, with the names of columns first.
std::string rowsCsv(const Results& results);

/// Per scene: each strategy after the longest flight, for the step that the pictures show.
std::string resultsTable(const Results& results);

}  // namespace app::flight
