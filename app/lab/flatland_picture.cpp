// See flatland_picture.h.
#include "app/lab/flatland_picture.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "app/lab/flatland_scene.h"
#include "app/lab/power_sums.h"

namespace app::lab {

namespace {

// Both glints, the one that was and the one that is, with their surroundings.
constexpr double kLow = -0.7, kHigh = 0.6;  // on the new image line
constexpr uint32_t kPixels = 130, kRows = 14;

FlatlandSettings pixelOf(FlatlandSettings settings, uint32_t pixel)
{
    settings.pixelWidth = (kHigh - kLow) / kPixels;
    settings.pixelLow = kLow + pixel * settings.pixelWidth;
    return settings;
}

/// The value of one pixel, by one of the ways.
using PixelWay = double (*)(const FlatlandSettings&,
                            const std::vector<FlatlandChange::Point>& landed,
                            core::Pcg32& candidates, core::Pcg32& selection);

double reused(const FlatlandSettings& s, const std::vector<FlatlandChange::Point>& landed,
              core::Pcg32& candidates, core::Pcg32& selection)
{
    return corrected(reuseInFlatland(s, landed, candidates, selection), s);
}

/// As a viewer accumulates: old values and new ones count alike.
double averaged(const FlatlandSettings& s, const std::vector<FlatlandChange::Point>& landed,
                core::Pcg32& candidates, core::Pcg32&)
{
    double sum = 0;
    for (const FlatlandChange::Point& x : landed) sum += incident(x.g, x.t);
    for (uint32_t i = 0; i < s.n; ++i) {
        const FlatlandChange::Point y = FlatlandChange{&s}.sampleP(candidates);
        sum += incident(y.g, y.t);
    }
    return sum / static_cast<double>(landed.size() + s.n);
}

struct StripCase {
    const char *name, *meaning;
    bool unbiased;
    FlatlandSettings settings;
    PixelWay way;
};

std::vector<StripCase> stripCases()
{
    FlatlandSettings none, history, blind;
    none.c = 0;
    history.N = 32;
    history.c = 4;
    history.beta = Beta::ideal;
    blind.projection.visibility = false;
    return {{"discard", "Throws the old samples away: right on average, and grainy.", true, none,
             reused},
            {"old values",
             "The old values averaged with the new ones: smooth, and wrong; the "
             "glint stays where it was.",
             false, history, averaged},
            {"no visibility",
             "Reweighting-Augmentation that forgets that a part of the ground was "
             "hidden: a stripe that is too dark.",
             false, blind, reused},
            {"exact, 32 old, corrected",
             "Reweighting-Augmentation: old samples count where the "
             "new camera wants them, new ones fill in the rest.",
             true, history, reused}};
}

/// Noise and bias from the rows, in units of `unit`.
void judge(FlatlandStrip& strip, const std::vector<double>& truth, double unit)
{
    double variance = 0, offset = 0;
    for (uint32_t x = 0; x < kPixels; ++x) {
        PowerSums sums;
        for (uint32_t y = 0; y < kRows; ++y)
            sums.add(strip.values[static_cast<size_t>(y) * kPixels + x] - truth[x]);
        variance += sums.variance() / kPixels;
        offset += sums.mean() * sums.mean() / kPixels;
    }
    // The mean of the rows has an offset by chance, too: its square is known, and so is the spread
    // of that where the noise is normal.
    const double chance = variance / kRows, spread = chance * std::sqrt(2.0 / kPixels);
    strip.noise = std::sqrt(variance) / unit;
    strip.bias = std::sqrt(std::max(0.0, offset - chance)) / unit;
    strip.biasSeen = offset - chance > 4.5 * spread;
}

FlatlandStrip render(const StripCase& c, size_t index, uint64_t seed,
                     const std::vector<double>& truth, double unit)
{
    FlatlandStrip strip{c.name, c.meaning, false, c.unbiased, {}, 0, 0, false};
    strip.values.resize(static_cast<size_t>(kPixels) * kRows);
    std::vector<FlatlandChange::Point> landed;
    for (uint32_t x = 0; x < kPixels; ++x) {
        FlatlandSettings settings = pixelOf(c.settings, x);
        settings.betaValue = truth[x > 0 ? x - 1 : 1];  // of a neighbour
        // The same old samples for every strip: only what is done with them differs.
        core::Pcg32 old(seed, 4 * x), candidates(seed, 4 * (x + kPixels * (index + 1)) + 1),
            selection(seed, 4 * (x + kPixels * (index + 1)) + 2);
        for (uint32_t y = 0; y < kRows; ++y) {
            drawOld(settings, old, landed);
            strip.values[static_cast<size_t>(y) * kPixels + x] =
                c.way(settings, landed, candidates, selection);
        }
    }
    judge(strip, truth, unit);
    return strip;
}

/// One trial of R-A in the pixel that flatland() measures.
std::vector<FlatlandSample> oneTrial(uint64_t seed)
{
    using namespace core::reuse;
    const FlatlandSettings s;
    const FlatlandChange change{&s};
    const MinimumFraction<double> fraction{s.c};
    core::Pcg32 old(seed, 0), candidates(seed, 1), selection(seed, 2);
    std::vector<FlatlandChange::Point> landed;
    drawOld(s, old, landed);
    std::vector<FlatlandSample> samples;
    for (const FlatlandChange::Point& x : landed) {
        const double q = change.q(x), p = change.p(x);
        samples.push_back({x.g, x.t, false, fraction.alphaOverQ(q, p) * p / s.c});
    }
    FlatlandEstimate estimate;
    for (uint32_t j = 0; j < s.n; ++j) {
        const auto draw = drawResidual(estimate, change, s.n, s.k, fraction, candidates, selection);
        if (draw.u > 0) samples.push_back({draw.y.g, draw.y.t, true, 1});
    }
    return samples;
}

}  // namespace

FlatlandPicture flatlandPicture(uint64_t seed)
{
    FlatlandPicture picture;
    picture.low = kNewCamera.ground(kLow);
    picture.width = kNewCamera.ground(kHigh) - picture.low;
    picture.pixels = kPixels;
    picture.rows = kRows;
    std::vector<double> before;
    for (uint32_t x = 0; x < kPixels; ++x) {
        const FlatlandSettings settings = pixelOf({}, x);
        const double middle = kNewCamera.ground(settings.pixelLow + settings.pixelWidth / 2);
        before.push_back(visibleFromOld(middle) ? flatlandTruth(settings, kOldCamera) : 0);
        picture.truth.push_back(flatlandTruth(settings));
    }
    const double unit = std::accumulate(picture.truth.begin(), picture.truth.end(), 0.0) / kPixels;
    picture.strips.push_back({"before",
                              "The ground as the old camera saw it, exactly; black: the "
                              "thin thing that hid a part of it.",
                              true, true, before, 0, 0, false});
    picture.strips.push_back({"after",
                              "The same ground from where the camera is now, exactly: the "
                              "glint has moved.",
                              true, true, picture.truth, 0, 0, false});
    const std::vector<StripCase> cases = stripCases();
    for (size_t i = 0; i < cases.size(); ++i)
        picture.strips.push_back(render(cases[i], i, seed, picture.truth, unit));
    picture.samples = oneTrial(seed);
    return picture;
}

}  // namespace app::lab
