// Sums over tiles and their quotients. See picture_comparison.h.
#include "app/pictures/picture_comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "app/pictures/convergence.h"
#include "app/pictures/error_point.h"
#include "app/pictures/error_text.h"
#include "app/report/text.h"
#include "core/base/parallel.h"

namespace app {
namespace {

constexpr double kFloor = 0.01;  // of relMSE: core::kRelMseFormula
constexpr double kNormal = 1.959964;
constexpr size_t kFewestTiles = 8;
constexpr double kMostRelativeNoise = 0.05;  // relMSE of the reference itself

/// Student's t that 95 % of the draws stay within (Cornish and Fisher's expansion; from four
/// degrees of freedom on right to 2 %).
double student95(double freedom)
{
    const double z = kNormal, z3 = z * z * z, z5 = z3 * z * z;
    return z + (z3 + z) / (4 * freedom) + (5 * z5 + 16 * z3 + 3 * z) / (96 * freedom * freedom);
}

/// An error's sums over the pixels of a tile: of A and B, and what the reference's noise adds to
/// either.
struct TileError {
    std::array<double, 2> sides{};
    double noise = 0;
};

/// Squared errors and relative ones.
struct Tile {
    double pixels = 0;
    TileError squares, relative;
};

struct Images {
    std::array<const core::Image*, 2> mean, variance;
    const core::Image* reference = nullptr;
    const core::Image* noise = nullptr;  // of the reference: its variance

    bool fit(const core::Image* image) const
    {
        return image == nullptr || (image->width == mean[0]->width &&
                                    image->height == mean[0]->height && image->channels >= 3);
    }
    bool fit() const
    {
        return fit(mean[0]) && fit(mean[1]) && fit(reference) && fit(noise) &&
               (reference != nullptr || (fit(variance[0]) && fit(variance[1])));
    }
};

void addPixel(const Images& images, uint32_t x, uint32_t y, Tile& tile)
{
    TileError squares, relative;
    for (uint32_t c = 0; c < 3; ++c) {
        const auto value = [&](const core::Image* image) { return double(image->at(x, y)[c]); };
        const double a = value(images.mean[0]), b = value(images.mean[1]);
        const bool against = images.reference != nullptr;
        const double level = against ? value(images.reference) : 0;
        const double weight = 1 / (level * level + kFloor);
        const double noise = images.noise != nullptr ? value(images.noise) : 0;
        squares.noise += noise / 3;
        relative.noise += noise * weight / 3;
        for (size_t side = 0; side < 2; ++side) {
            const double d = (side == 0 ? a : b) - level;
            const double square = against ? d * d : value(images.variance[side]);
            squares.sides[side] += square / 3;
            relative.sides[side] += square * weight / 3;
        }
    }
    const double sum = squares.sides[0] + squares.sides[1] + squares.noise;
    if (!std::isfinite(sum + relative.sides[0] + relative.sides[1] + relative.noise)) return;
    for (const auto& [sums, more] :
         {std::pair(&tile.squares, &squares), {&tile.relative, &relative}}) {
        sums->noise += more->noise;
        for (size_t side = 0; side < 2; ++side) sums->sides[side] += more->sides[side];
    }
    tile.pixels += 1;
}

std::vector<Tile> sumTiles(const Images& images)
{
    const uint32_t width = images.mean[0]->width, height = images.mean[0]->height;
    const size_t columns = (width + kErrorTile - 1) / kErrorTile,
                 rows = (height + kErrorTile - 1) / kErrorTile;
    std::vector<Tile> tiles(columns * rows);
    core::parallelFor(tiles.size(), 64, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            // There and back again: each one's neighbour in the list is one in the picture.
            const size_t row = i / columns, along = i % columns;
            const size_t column = row % 2 == 0 ? along : columns - 1 - along;
            const auto x0 = static_cast<uint32_t>(column) * kErrorTile,
                       y0 = static_cast<uint32_t>(row) * kErrorTile;
            for (uint32_t y = y0; y < std::min(y0 + kErrorTile, height); ++y)
                for (uint32_t x = x0; x < std::min(x0 + kErrorTile, width); ++x)
                    addPixel(images, x, y, tiles[i]);
        }
    });
    std::erase_if(tiles, [](const Tile& tile) { return tile.pixels == 0; });
    return tiles;
}

/// Means over pixels of A's and B's quantity, and the (co)variances of these means.
struct Pair {
    std::array<double, 2> mean{};
    double varianceA = 0, varianceB = 0, covariance = 0;
    double t = kNormal;
};

/// Variances come from the differences of neighbours (von Neumann 1941), which know less of what
/// the picture shows than those from the mean: two thirds of the degrees of freedom are left.
/// `noise`: how much of the reference's is taken off.
Pair pairOf(const std::vector<Tile>& tiles, TileError Tile::*error, double noise)
{
    Pair pair;
    double pixels = 0;
    const auto sum = [&](const Tile& tile, size_t side) {
        return (tile.*error).sides[side] - noise * (tile.*error).noise;
    };
    for (const Tile& tile : tiles) {
        pixels += tile.pixels;
        for (size_t side = 0; side < 2; ++side) pair.mean[side] += sum(tile, side);
    }
    for (double& mean : pair.mean) mean /= pixels;
    const auto off = [&](const Tile& tile, size_t side) {
        return (sum(tile, side) - pair.mean[side] * tile.pixels) / pixels;
    };
    for (size_t i = 1; i < tiles.size(); ++i) {
        const double a = off(tiles[i], 0) - off(tiles[i - 1], 0);
        const double b = off(tiles[i], 1) - off(tiles[i - 1], 1);
        pair.varianceA += a * a;
        pair.varianceB += b * b;
        pair.covariance += a * b;
    }
    const auto count = double(tiles.size());
    const double scale = count / (2 * (count - 1));
    pair.varianceA *= scale;
    pair.varianceB *= scale;
    pair.covariance *= scale;
    pair.t = student95((count - 1) * 2 / 3);
    return pair;
}

Bounded meanOf(const Pair& pair, size_t side)
{
    const double half = pair.t * std::sqrt(side == 0 ? pair.varianceA : pair.varianceB);
    return {pair.mean[side], pair.mean[side] - half, pair.mean[side] + half};
}

/// An error is not negative, whatever is taken off for the reference's noise.
Bounded mapped(const Bounded& from, double (*to)(double))
{
    const auto at = [to](double x) { return to(std::max(x, 0.0)); };
    return {at(from.value), at(from.low), at(from.high)};
}

/// The quotient of the means, A over B, by Fieller's theorem: all r for which A - r B may be zero.
/// Where one error drowns in the reference's noise the other still bounds it from one side.
Bounded quotient(const Pair& p)
{
    const double a = p.mean[0], b = p.mean[1], t2 = p.t * p.t;
    Bounded r{b > 0 ? a / b : 0, 0, std::numeric_limits<double>::infinity()};
    const double bb = b * b - t2 * p.varianceB, ab = a * b - t2 * p.covariance,
                 aa = a * a - t2 * p.varianceA;
    const double root = std::sqrt(std::max(ab * ab - aa * bb, 0.0));
    if (b > 0 && bb > 0) {
        r.low = std::max((ab - root) / bb, 0.0);
        r.high = std::max((ab + root) / bb, 0.0);
    } else if (a > 0 && aa > 0 && ab + root > 0) {
        r.low = aa / (ab + root);
    }
    return r;
}

/// The first's value, and an interval that holds both.
Bounded hull(const Bounded& a, const Bounded& b)
{
    return {a.value, std::min(a.low, b.low), std::max(a.high, b.high)};
}

/// The errors of both sides by one measure, mapped to what is shown, and their quotient. How much
/// of the reference's noise is in them is known between nothing and what its variance says, which
/// is an upper bound with stratified samples: the intervals hold whatever lies between.
struct Measure {
    std::array<Bounded, 2> sides;
    Bounded ratio;
};

Measure measure(const std::vector<Tile>& tiles, TileError Tile::*error, double (*shown)(double))
{
    const Pair raw = pairOf(tiles, error, 0), without = pairOf(tiles, error, 1);
    Measure result;
    for (size_t side = 0; side < 2; ++side)
        result.sides[side] =
            hull(mapped(meanOf(raw, side), shown), mapped(meanOf(without, side), shown));
    result.ratio = hull(quotient(raw), quotient(without));
    return result;
}

Bounded scaled(const Bounded& from, double factor)
{
    return {from.value * factor, from.low * factor, from.high * factor};
}

std::string row(const std::string& name, const std::string& a, const std::string& b)
{
    return name + '\t' + a + '\t' + b + '\n';
}

}  // namespace

PictureComparison comparePictures(const TimedPicture& a, const TimedPicture& b,
                                  const Reference* reference)
{
    PictureComparison result;
    Images images{{&a.mean, &b.mean}, {a.variance, b.variance}, nullptr, nullptr};
    if (reference != nullptr) {
        images.reference = &reference->mean;
        if (!reference->variance.pixels.empty()) images.noise = &reference->variance;
    }
    for (const core::Image*& variance : images.variance)
        if (variance != nullptr && variance->pixels.empty()) variance = nullptr;
    result.sides = {SideErrors{a.samples, a.seconds, {}, {}},
                    SideErrors{b.samples, b.seconds, {}, {}}};
    const auto without = [&](const char* why) {
        result.whyNot = why;
        return result;
    };
    if (reference == nullptr && (images.variance[0] == nullptr || images.variance[1] == nullptr))
        return without("there is no reference, and a picture without its variance");
    if (reference == nullptr && (a.samples < 2 || b.samples < 2))
        return without("there is no reference, and one sample says nothing about its spread");
    if (!images.fit()) return without("the pictures differ in size");
    const std::vector<Tile> tiles = sumTiles(images);
    if (tiles.size() < kFewestTiles) return without("the pictures are too small");

    using Source = PictureComparison::Source;
    result.source = reference != nullptr ? Source::reference : Source::variance;
    result.referenceNoise = reference != nullptr ? referenceNoise(*reference) : 0;
    Measure squares = measure(tiles, &Tile::squares, [](double x) { return std::sqrt(x); });
    Measure relative = measure(tiles, &Tile::relative, [](double x) { return x; });
    // What is relative to a radiance that may be far off is not told at all: bright dots in the
    // pictures themselves would hide their own errors.
    double noise = 0, pixels = 0;
    for (const Tile& tile : tiles) {
        noise += tile.relative.noise;
        pixels += tile.pixels;
    }
    if (reference == nullptr || noise > kMostRelativeNoise * pixels) {
        const Bounded unknown{0, 0, std::numeric_limits<double>::infinity()};
        relative = {{unknown, unknown}, unknown};
    }
    for (size_t side = 0; side < 2; ++side) {
        result.sides[side].rmse = squares.sides[side];
        result.sides[side].relMse = relative.sides[side];
    }
    const double time = b.seconds > 0 ? a.seconds / b.seconds : 0;
    result.byRmse = scaled(squares.ratio, time);
    result.byRelMse = scaled(relative.ratio, time);
    return result;
}

BoundedDigits boundedDigits(const Bounded& bounded)
{
    // Half of the interval of 95 % is that many standard errors of a normal distribution.
    const double error = (bounded.high - bounded.low) / (2 * 1.96);
    return {digitsByError(bounded.value, error), digitsByError(bounded.low, error),
            digitsByError(bounded.high, error)};
}

std::string boundedText(const Bounded& bounded)
{
    if (!std::isfinite(bounded.high)) return "unknown";
    if (!(bounded.value > 0)) return "≤ " + report::shortNumber(bounded.high);
    const BoundedDigits text = boundedDigits(bounded);
    return text.value + " (" + text.low + " to " + text.high + ")";
}

std::string verdict(const Bounded& ratio, const char* of)
{
    const std::string tail = std::string(" for an equal ") + of;
    const auto needsLess = [&](const char* side, const std::string& times) {
        return std::string(side) + " needs " + times + " times less time" + tail;
    };
    if (ratio.high < 1 && !(ratio.low > 0))
        return needsLess("A", "at least " + report::shortNumber(1 / ratio.high));
    if (ratio.low > 1 && !std::isfinite(ratio.high))
        return needsLess("B", "at least " + report::shortNumber(ratio.low));
    if (!std::isfinite(ratio.high) || !(ratio.value > 0))
        return "it cannot be told which takes less time" + tail;
    if (ratio.low <= 1 && ratio.high >= 1)
        return "no difference is seen in the time" + tail + ": A over B " + boundedText(ratio);
    if (ratio.value > 1) return needsLess("B", boundedText(ratio));
    return needsLess("A", boundedText({1 / ratio.value, 1 / ratio.high, 1 / ratio.low}));
}

std::vector<std::string> comparisonNotes(const PictureComparison& comparison)
{
    using Source = PictureComparison::Source;
    std::vector<std::string> notes;
    if (comparison.source == Source::none) return {comparison.whyNot};
    if (comparison.source == Source::variance) {
        notes.emplace_back("without a reference: estimated from the spread of each picture's own "
                           "samples; a bias does not show, and the sampler sobol has smaller "
                           "errors than that; relative errors need a reference");
    } else if (comparison.referenceNoise > 0) {
        notes.push_back("the reference's own noise, RMSE " +
                        report::shortNumber(comparison.referenceNoise) +
                        " at most, is part of the values; the intervals hold them without it, too");
    } else {
        notes.emplace_back("the reference's own noise is unknown and counts as the pictures'");
    }
    notes.emplace_back("intervals of 95 %, from tiles of 8 x 8 pixels; rare bright samples that "
                       "have not come yet are not in them");
    return notes;
}

std::string comparisonText(const PictureComparison& comparison,
                           const std::array<std::string, 2>& labels)
{
    const SideErrors &a = comparison.sides[0], &b = comparison.sides[1];
    const auto seconds = [](double s) { return report::printed("%.3f", s); };
    std::string text =
        row("", "A", "B") + row("made with", labels[0], labels[1]) +
        row("samples per pixel", std::to_string(a.samples), std::to_string(b.samples)) +
        row("seconds", seconds(a.seconds), seconds(b.seconds));
    if (comparison.source != PictureComparison::Source::none) {
        text += row("RMSE", boundedText(a.rmse), boundedText(b.rmse)) +
                row("relMSE", boundedText(a.relMse), boundedText(b.relMse)) +
                row("efficiency by RMSE, B over A", "1", boundedText(comparison.byRmse)) +
                row("efficiency by relMSE, B over A", "1", boundedText(comparison.byRelMse));
    }
    for (const std::string& note : comparisonNotes(comparison)) text += note + '\n';
    return text;
}

}  // namespace app
