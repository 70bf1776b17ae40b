// See many_lights_thesis.h.
#include "app/bench/many_lights/many_lights_thesis.h"

#include <algorithm>
#include <limits>

namespace app::many_lights {

namespace {

constexpr double kNever = std::numeric_limits<double>::infinity(),
                 kNone = std::numeric_limits<double>::quiet_NaN();

// Tables A.2 to A.4 of the thesis.
constexpr std::array kScenes{
    ThesisScene{"Cornell",
                "cornell-diffuse",
                {.16, .15, .15, .16},
                {.93, 1.00, 1.13, 1.00},
                5.5,
                4.8,
                kNever,
                kNever},
    ThesisScene{"Hairball",
                "hairball",
                {.51, .55, .61, .72},
                {1.03, 1.03, 1.06, 1.03},
                1.4,
                kNever,
                kNever,
                kNever},
    ThesisScene{
        "Sponza", "sponza", {.12, .12, .14, .17}, {.87, 1.00, .98, 1.12}, 7.5, 7.0, kNever, kNever},
    ThesisScene{"Staircase",
                "staircase",
                {.19, .19, .20, .23},
                {.99, .99, 1.01, .75},
                4.8,
                kNever,
                kNever,
                kNever},
    ThesisScene{"Modern Hall",
                "modern-hall",
                {.27, .21, .18, .19},
                {1.02, 1.03, .97, .98},
                6.1,
                3.5,
                kNone,
                kNone},
    ThesisScene{"Bathroom",
                "bathroom",
                {.26, .27, .31, .37},
                {1.02, 1.01, .99, 1.01},
                3.3,
                1.3,
                kNone,
                kNone},
    ThesisScene{
        "Kitchen", "kitchen", {.19, .19, .22, .25}, {.97, .99, 1.01, .99}, 4.5, 1.5, kNone, kNone},
};

// Table A.1.
constexpr std::array kRates{
    ThesisRates{"San Miguel", {1.35, 1.68, 2.37, 4.07, 6.14}, {2.42, 2.29, 2.15, 2.06, 1.99}},
    ThesisRates{"Classroom", {1.41, 1.89, 3.28, 6.31, 11.6}, {3.22, 3.00, 2.80, 2.67, 2.57}},
    ThesisRates{"Kitchen", {1.56, 2.05, 3.20, 5.49, 9.04}, {1.95, 1.79, 1.70, 1.63, 1.57}},
};

}  // namespace

std::span<const ThesisScene> thesisScenes()
{
    return kScenes;
}

const ThesisScene* thesisScene(std::string_view name)
{
    const auto found = std::ranges::find_if(
        kScenes, [&](const ThesisScene& scene) { return name.starts_with(scene.files); });
    return found == kScenes.end() ? nullptr : &*found;
}

std::span<const ThesisRates> thesisRates()
{
    return kRates;
}

}  // namespace app::many_lights
