// The parts of the page on flights and the words they share. Only flight_page*.cpp include this.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/bench/flythrough/flight_results.h"
#include "app/report/svg.h"

namespace app::flight {

/// relMSE, with and without fireflies, over that of Discard, and the signed error: each over
/// frames and over steps.
std::string scenePlots(const Results& results, const SceneResult& scene);

/// The same over frames for every step, for who wants to know more.
std::string morePlots(const Results& results, const SceneResult& scene);

/// One plot per parameter.
std::string sweepPlots(const Results& results);

/// The pictures side by side, and under each the part of it that is shown larger.
std::string shotsMarkup(const Results& results, const SceneResult& scene,
                        const std::filesystem::path& folder);

/// What the window's own loop showed; nothing where that was not measured.
std::string windowMarkup(const Results& results, const SceneResult& scene);

/// How the curve of a strategy looks: the same on the whole page.
struct Look {
    std::string style;  // colour class, dashed beyond the colours that there are
    report::Shape shape = report::Shape::circle;
};
Look lookOf(const std::string& strategy);

/// "4 degrees".
std::string stepText(const SceneResult& scene, double step);

}  // namespace app::flight
