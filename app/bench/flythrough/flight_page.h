// The page on flights: what it is about, a summary, each scene with plots, numbers and pictures,
// the parameters, and how all of it was measured.
#pragma once

#include <filesystem>
#include <string>

#include "app/bench/flythrough/flight_results.h"

namespace app::flight {

/// One HTML file that stands alone; pictures are read from `folder`.
std::string resultsPage(const Results& results, const std::filesystem::path& folder);

}  // namespace app::flight
