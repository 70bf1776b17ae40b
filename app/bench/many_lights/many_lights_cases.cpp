// See many_lights_cases.h.
#include "app/bench/many_lights/many_lights_cases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "app/base/nearest.h"
#include "core/base/check.h"

namespace app::many_lights {

namespace {

using core::ManyLightsParams, core::many_lights::CompletionMethod,
    core::many_lights::CompletionParams, core::many_lights::OnMismatch,
    core::many_lights::Technique;

constexpr double kOwnRate = std::numeric_limits<double>::quiet_NaN();
constexpr double kCap = 0.4;              // of the adaptive rate, in the thesis and here
constexpr uint32_t kMostClusters = 8000;  // of a cut that ends at an error

/// Slices that completion of our own likes best (docs/many-lights.md).
constexpr uint32_t kLargeSlice = 2000;

void full(ManyLightsParams& p)
{
    p.completion = {.method = CompletionMethod::full};
}

void fullLargeSlices(ManyLightsParams& p)
{
    full(p);
    p.sliceSize = kLargeSlice;
}

void matching(ManyLightsParams& p)
{
    p.completion = {};
    p.sliceSize = kLargeSlice;
}

void matchingSmallSlices(ManyLightsParams& p)
{
    p.completion = {};
}

void matchingWhole(ManyLightsParams& p)
{
    matching(p);
    p.completion.onMismatch = OnMismatch::full;
}

void thesis(ManyLightsParams& p)
{
    p.completion = CompletionParams::authorPreset();
}

/// The thesis's table A.1: a fixed rate, and matches are not verified.
void fixedRate(ManyLightsParams& p, CompletionMethod method, bool adaptiveRows = true)
{
    thesis(p);
    p.completion.method = method;
    p.completion.rowIncrement = p.completion.verificationRate = 0;
    p.completion.rowCap = 1;
    p.completion.adaptiveRows = adaptiveRows;
}

template <Technique technique> void rival(ManyLightsParams& p)
{
    full(p);
    p.technique = technique;
}

constexpr std::array kMethods{
    Method{"full", "all visibility traced, in packets of sixteen rays", full},
    Method{"full-single", "all visibility traced, ray by ray", full, Sweep::clusters, false},
    Method{"matching",
           "this program's completion (the preset 'completed frame': slices of 2000 points)",
           matching},
    Method{"full-2000", "all visibility traced, in packets, in slices of 2000 points",
           fullLargeSlices},
    Method{"matching-1000", "as matching, in slices of the common size", matchingSmallSlices},
    Method{"matching-whole",
           "as matching, but a column without a match is traced in full, and no borders of shadows",
           matchingWhole},
    Method{"thesis", "BAMC as its author's tables were made", thesis},
    Method{"thesis-single", "the same, ray by ray", thesis, Sweep::clusters, false},
    Method{"thesis-full-single",
           "what the author's tables compare with: all pairs traced ray by ray, also those that "
           "face away from each other",
           [](ManyLightsParams& p) {
               full(p);
               p.completion.dontCare = false;
           },
           Sweep::clusters, false},
    Method{
        "lightslice",
        "LightSlice: lights clustered for each slice by what points of it and its neighbours see",
        [](ManyLightsParams& p) {
            rival<Technique::lightslice>(p);
            p.sliceSize = kLargeSlice;
        }},
    Method{"row-column", "row-column sampling: the same clusters of lights for the whole picture",
           rival<Technique::rowColumn>},
    Method{"lightcuts", "a cut through the light tree for every point", rival<Technique::lightcuts>,
           Sweep::errors},
    Method{"illumination-cut",
           "IlluminationCut: cuts for groups of points, visibility from samples",
           rival<Technique::illuminationCut>, Sweep::errors},
    Method{"matsep", "matrix separation: visibility predicted, the shaded matrix made of low rank",
           rival<Technique::matSep>, Sweep::named},
    Method{"fixed-matching", "BAMC at a fixed rate of rows, matches not verified",
           [](ManyLightsParams& p) { fixedRate(p, CompletionMethod::matching); }, Sweep::rates},
    Method{"fixed-amc", "AMC (linear combinations, pseudo-inverse) at a fixed rate of rows",
           [](ManyLightsParams& p) { fixedRate(p, CompletionMethod::amc); }, Sweep::rates},
    Method{"fixed-gauss-jordan", "BAMC (GE), sums over GF(2), at a fixed rate of rows",
           [](ManyLightsParams& p) { fixedRate(p, CompletionMethod::gaussJordan); }, Sweep::rates},
    Method{"uniform-matching", "fixed-matching with rows drawn uniformly",
           [](ManyLightsParams& p) { fixedRate(p, CompletionMethod::matching, false); },
           Sweep::uniform},
    Method{"uniform-amc", "fixed-amc with rows drawn uniformly",
           [](ManyLightsParams& p) { fixedRate(p, CompletionMethod::amc, false); }, Sweep::uniform},
    Method{"high-matching", "fixed-matching at the rate where the adaptive one ends",
           [](ManyLightsParams& p) { fixedRate(p, CompletionMethod::matching); }, Sweep::highRate},
};

/// The common parameters as a method changes them.
Case caseOf(const ManyLightsBenchOptions& options, const Method& method, uint32_t clusters,
            double rate)
{
    Case c{&method, clusters, rate, options.params};
    c.params.clusters = clusters;
    method.change(c.params);
    if (!std::isnan(rate)) c.params.completion.rowRate = static_cast<float>(rate);
    return c;
}

/// Numbers of clusters over which the fixed rate is measured: the main one, and more in steps that
/// the thesis has (1000 to 3000), or in a quick run the least of the sweep.
std::vector<uint32_t> fixedRateClusters(const ManyLightsBenchOptions& options)
{
    const uint32_t main = options.mainClusters;
    if (!options.quick) return {main, 2 * main, 3 * main};
    return options.clusters.front() < main ? std::vector{options.clusters.front(), main}
                                           : std::vector{main};
}

void addCases(const ManyLightsBenchOptions& options, const Method& method, std::vector<Case>& out)
{
    const std::vector<double> rates = fixedRates(options.quick);
    const auto add = [&](uint32_t clusters, double rate) {
        out.push_back(caseOf(options, method, clusters, rate));
    };
    switch (method.sweep) {
    case Sweep::clusters:
        for (const uint32_t clusters : options.clusters) add(clusters, kOwnRate);
        break;
    case Sweep::errors:
        for (const float error : options.errors) {
            add(error == options.mainError ? options.mainClusters : 0, kOwnRate);
            out.back().params.clusters = kMostClusters;
            out.back().params.error = error;
        }
        break;
    case Sweep::named:
        add(options.mainClusters, kOwnRate);
        break;
    case Sweep::rates:
        for (const double rate : rates) add(options.mainClusters, rate);
        for (const uint32_t clusters : fixedRateClusters(options))
            if (clusters != options.mainClusters) add(clusters, rates.front());
        break;
    case Sweep::uniform:
        add(options.mainClusters, rates.front());
        break;
    case Sweep::highRate:
        add(options.mainClusters, kCap);
        break;
    }
}

}  // namespace

std::span<const Method> methodTable()
{
    return kMethods;
}

std::vector<double> fixedRates(bool quick)
{
    return quick ? std::vector{0.1, 0.2} : std::vector{0.1, 0.125, 0.15, 0.175, 0.2};
}

std::vector<Case> casesOf(const ManyLightsBenchOptions& options)
{
    std::vector<Case> cases;
    for (const Method& method : kMethods) {
        const bool named = options.methods.empty() ||
                           std::ranges::find(options.methods, method.name) != options.methods.end();
        const bool wanted = method.sweep == Sweep::named
                                ? named && !options.methods.empty()
                                : named && (options.sweeps || isCurve(method));
        if (wanted || &method == kMethods.data()) addCases(options, method, cases);
    }
    return cases;
}

void requireMethods(const std::vector<std::string>& names)
{
    std::vector<std::string> known;
    for (const Method& method : kMethods) known.emplace_back(method.name);
    for (const std::string& name : names) {
        if (std::ranges::find(known, name) != known.end()) continue;
        std::string text;
        for (const std::string& k : known) text += (text.empty() ? "" : ", ") + k;
        throw core::Error("--methods: '" + name + "' is not one of " + text +
                              suggestion(name, known),
                          core::ExitCode::commandLine);
    }
}

}  // namespace app::many_lights
