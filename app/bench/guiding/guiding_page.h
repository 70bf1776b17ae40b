// The page on path guiding: what it is about, goals and what became of them, each scene with plots,
// numbers and pictures, and how all of it was measured.
#pragma once

#include <filesystem>
#include <string>

#include "app/bench/guiding/guiding_results.h"

namespace app::guiding {

/// One HTML file that stands alone; pictures are read from `folder`.
std::string resultsPage(const Results& results, const std::filesystem::path& folder);

/// Plots, the table of all rows and the pictures of one scene; a part of that page.
std::string sceneMarkup(const Results& results, const SceneResult& scene,
                        const std::filesystem::path& folder);

}  // namespace app::guiding
