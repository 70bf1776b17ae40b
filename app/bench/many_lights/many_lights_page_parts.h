// The parts of the page on many lights. Only many_lights_page*.cpp include this.
#pragma once

#include <filesystem>
#include <string>

#include "app/bench/many_lights/many_lights_claims.h"
#include "app/report/svg.h"

namespace app::many_lights {

/// Time against error, time over full against clusters, and how the time divides.
std::string scenePlots(const Results& results, const SceneResult& scene);

/// Every method at the main number of clusters.
std::string sceneTable(const Results& results, const SceneResult& scene);

/// Fixed rates of rows: time of AMC and elimination over BAMC, and their errors.
std::string ratesTable(const SceneResult& scene);

/// The pictures side by side, each above its difference.
std::string shotsMarkup(const SceneResult& scene, const std::filesystem::path& folder);

/// The thesis's ratios beside ours.
std::string thesisMarkup(const Results& results);

/// How the curve of a method looks: the same on the whole page.
struct Look {
    std::string style;  // colour class, dashed where rays are traced one by one
    report::Shape shape = report::Shape::circle;
};
Look lookOf(const std::string& method);

}  // namespace app::many_lights
