// Results of many lights as JSON and as the table on standard output.
#pragma once

#include <string>

#include "app/bench/many_lights/many_lights_results.h"

namespace app::many_lights {

/// Schema 1: keys may be added, none renamed. Ends in a newline.
std::string resultsJson(const Results& results);

/// A few lines for each scene, and the claims.
std::string resultsTable(const Results& results);

}  // namespace app::many_lights
