// Ratios from the tables of S. Wang, "Efficient Sample Usage in Photo-Realistic Rendering" (2022),
// part I, corrected from the author's raw results where a cell is wrong there; for scenes that we
// have, too.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

namespace app::many_lights {

inline constexpr std::array<uint32_t, 4> kThesisClusters{500, 1000, 2000, 4000};

/// BAMC over full sampling of as many clusters (kThesisClusters), and how many times the time of
/// BAMC with 2000 clusters others need for its error (infinite: never; NaN: not measured).
struct ThesisScene {
    const char* name;
    const char* files;  // names of our files begin so
    std::array<double, 4> time, rmse;
    double full, lightSlice, matSep, illuminationCut;
};

std::span<const ThesisScene> thesisScenes();

/// The scene that a file of that name shows; null when the thesis does not have it.
const ThesisScene* thesisScene(std::string_view name);

/// Fixed rates of rows at 1000 clusters: time over that of BAMC.
struct ThesisRates {
    const char* scene;
    std::array<double, 5> amc, gaussJordan;  // at kThesisRates
};
inline constexpr std::array<double, 5> kThesisRates{0.1, 0.125, 0.15, 0.175, 0.2};
std::span<const ThesisRates> thesisRates();

}  // namespace app::many_lights
