// The page that `rekindle bench manylights` writes.
#pragma once

#include <filesystem>
#include <string>

#include "app/bench/many_lights/many_lights_results.h"

namespace app::many_lights {

/// One HTML file that stands alone; the pictures are read from `folder`.
std::string resultsPage(const Results& results, const std::filesystem::path& folder);

}  // namespace app::many_lights
