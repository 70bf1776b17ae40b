// Results of ways to find light as one page that stands alone.
#pragma once

#include <string>

#include "app/bench/light/light_results.h"

namespace app::light {

std::string resultsPage(const Results& results);

}  // namespace app::light
