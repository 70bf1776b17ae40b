// Curves: sweeps over c and k, majorisation constants, the moving lobe. See report_parts.h.
#include <algorithm>
#include <cmath>
#include <map>

#include "app/base/read_value.h"
#include "app/lab/pairs.h"
#include "app/lab/report_parts.h"
#include "app/lab/table.h"
#include "app/lab/theory.h"

namespace app::lab {

namespace {

struct Series {
    const char* function;
    const char* style;
    Shape shape;
};
/// The functions that the sweeps show: constant, slope, box, two peaks.
constexpr Series kShown[] = {{"F1", "c-blue", Shape::circle},
                             {"F2", "c-orange", Shape::square},
                             {"F4", "c-green", Shape::diamond},
                             {"F6", "c-pink", Shape::triangle}};

std::vector<std::string> pairNames(const std::vector<SweepPoint>& points)
{
    std::vector<std::string> names;
    for (const SweepPoint& p : points)
        if (std::find(names.begin(), names.end(), p.pair) == names.end()) names.push_back(p.pair);
    return names;
}

struct SweepCurve {
    std::vector<Point> expected, measured;
    std::vector<double> errors;
    double unit = 0;
    uint32_t candidates = 0;  // of the first point
};

/// Values relative to the expected one at `reference`: functions of different size in one plot.
template <class Position>
SweepCurve sweepCurve(const std::vector<SweepPoint>& points, const std::string& pair,
                      const std::string& function, Position position, double reference)
{
    double unit = 0;
    for (const SweepPoint& p : points)
        if (p.pair == pair && p.function == function && position(p) == reference)
            unit = p.expectedVariance;
    SweepCurve curve;
    // Relative to nothing, everything is infinite.
    if (!(unit > 1e-9) || !std::isfinite(unit)) return curve;
    curve.unit = unit;
    for (const SweepPoint& p : points) {
        if (p.pair != pair || p.function != function) continue;
        if (curve.expected.empty()) curve.candidates = p.candidates;
        curve.expected.push_back({position(p), p.expectedVariance / unit});
        curve.measured.push_back({position(p), p.variance / unit});
        curve.errors.push_back(p.varianceError / unit);
    }
    return curve;
}

/// The prediction between the multiples of c* that were measured: where the curve bends between
/// them, a polygon would lie.
std::vector<Point> predictedOverC(const std::vector<Point>& measured, const std::string& id,
                                  const std::string& function, uint32_t candidates, double unit)
{
    constexpr int kPerDoubling = 4;
    const auto pair = std::find_if(pairs().begin(), pairs().end(),
                                   [&](const Pair& known) { return id == known.id; });
    if (pair == pairs().end() || measured.empty()) return {};
    Cell cell;
    cell.pair = id;
    cell.function = function;
    cell.method = "ra";
    cell.oldSamples = cell.newSamples = kOldSamples;
    cell.candidates = candidates;
    const double best = pair->bestC(1, 1), low = measured.front().x, high = measured.back().x;
    const int steps =
        std::max(1, static_cast<int>(std::lround(kPerDoubling * std::log2(high / low))));
    std::vector<Point> points;
    for (int i = 0; i <= steps; ++i) {
        const double factor = low * std::pow(high / low, static_cast<double>(i) / steps);
        cell.c = factor * best;
        points.push_back({factor, expectation(cell).variance / unit});
    }
    return points;
}

struct SweepLook {
    std::string label, yLabel;
    std::vector<Tick> ticks;
    double reference = 1;
    bool overC = false;
};

template <class Position>
std::string sweepPlots(const std::vector<SweepPoint>& points, const SweepLook& look,
                       Position position)
{
    std::string html = "<div class=\"three\">\n";
    for (const std::string& pair : pairNames(points)) {
        std::vector<SweepCurve> curves;
        double low = 0.8, high = 1.25;  // less of a change is not worth a plot
        for (const Series& series : kShown) {
            curves.push_back(sweepCurve(points, pair, series.function, position, look.reference));
            for (const auto& list : {curves.back().expected, curves.back().measured})
                for (const Point& p : list)
                    if (std::isfinite(p.y) && p.y > 0) {
                        low = std::min(low, p.y);
                        high = std::max(high, p.y);
                    }
        }
        Plot plot(pairLabel(pair), logAxisAt(look.label, look.ticks),
                  logAxis(look.yLabel, low, high), 320, 220);
        if (look.overC) plot.vertical(look.reference, "c*", "soft dashed");
        for (size_t i = 0; i < curves.size(); ++i) {
            const Series& series = kShown[i];
            if (curves[i].expected.empty()) continue;
            const std::vector<Point> smooth =
                look.overC ? predictedOverC(curves[i].expected, pair, series.function,
                                            curves[i].candidates, curves[i].unit)
                           : curves[i].expected;
            plot.curve(smooth, series.style);
            plot.errorBars(curves[i].measured, curves[i].errors, series.style);
            plot.markers(curves[i].measured, series.shape, series.style);
            plot.legend(
                {functionLabel(series.function), series.style, true, true, false, series.shape});
        }
        html += "<figure>" + plot.element() + "</figure>\n";
    }
    return html + "</div>\n";
}

std::string sweepData(const std::string& over, const std::string& position)
{
    return dataLine("sweeps.csv", {"pair", "f", position, "n_var", "n_var_se", "expected_n_var"},
                    "rows with sweep = " + over);
}

/// Where over all cells of the sweep measurement and formula are farthest apart.
std::string agreement(const std::vector<SweepPoint>& points)
{
    size_t judged = 0, off = 0;
    for (const SweepPoint& p : points) {
        if (!std::isfinite(p.expectedVariance) || !(p.varianceError > 0)) continue;
        const double difference = std::abs(p.variance - p.expectedVariance);
        ++judged;
        // See varianceDeviation: what has no variance is right to rounding.
        if (difference > 1e-9 && difference > kVarianceBound * p.varianceError) ++off;
    }
    return "Of " + counted(judged, "point") + " with a prediction (all functions), " +
           std::to_string(judged - off) + " lie within " + numberText(kVarianceBound) +
           " standard errors of it.";
}

std::string percentAxisLabel(const std::string& what)
{
    return what + ", %";
}

std::string lobeStyle(size_t index, const LobeSequence& sequence)
{
    constexpr const char* kRight[] = {"c-blue", "c-sky", "c-green"};
    constexpr const char* kWrong[] = {"c-red", "c-orange", "c-pink", "c-yellow"};
    return sequence.unbiased ? kRight[index % std::size(kRight)]
                             : kWrong[index % std::size(kWrong)];
}

std::string lobeLabel(const LobeSequence& sequence)
{
    std::string label = sequence.method;
    const std::string k = "k = " + std::to_string(sequence.candidates);
    if (sequence.candidates && label.find(k) == std::string::npos) label += ", " + k;
    return label;
}

/// Band of chance around zero of the first unbiased sequence: 4.5 standard errors, which are its
/// bias over its z.
void addChance(Plot& plot, const std::vector<const LobeSequence*>& group)
{
    for (const LobeSequence* sequence : group) {
        if (!sequence->unbiased) continue;
        std::vector<Point> lower, upper;
        for (size_t i = 0; i < sequence->frames.size(); ++i) {
            const LobeFrame& frame = sequence->frames[i];
            if (!std::isfinite(frame.z) || frame.z == 0) continue;
            const double reach = 100 * kMeanBound * std::abs(frame.bias / frame.z);
            lower.push_back({static_cast<double>(i), -reach});
            upper.push_back({static_cast<double>(i), reach});
        }
        plot.band(lower, upper, "c-grey");
        plot.legend({"±4.5 standard errors", "c-grey", false, false, true});
        return;
    }
}

struct LobeValues {
    std::vector<std::vector<Point>> bias, ratio;
    double lowBias = -0.5, highBias = 0.5, highRatio = 1, frames = 1;
};

LobeValues lobeValues(const std::vector<const LobeSequence*>& group)
{
    LobeValues values;
    for (const LobeSequence* sequence : group) {
        std::vector<Point> bias, ratio;
        for (size_t i = 0; i < sequence->frames.size(); ++i) {
            const LobeFrame& frame = sequence->frames[i];
            bias.push_back({static_cast<double>(i), 100 * frame.bias});
            ratio.push_back({static_cast<double>(i), frame.varianceRatio});
            if (std::isfinite(frame.bias)) {
                values.lowBias = std::min(values.lowBias, bias.back().y);
                values.highBias = std::max(values.highBias, bias.back().y);
            }
            if (std::isfinite(frame.varianceRatio))
                values.highRatio = std::max(values.highRatio, frame.varianceRatio);
            values.frames = std::max(values.frames, static_cast<double>(i));
        }
        values.bias.push_back(std::move(bias));
        values.ratio.push_back(std::move(ratio));
    }
    return values;
}

std::string lobePlots(double step, const std::vector<const LobeSequence*>& group)
{
    const LobeValues values = lobeValues(group);
    const std::string motion = "δ = " + numberText(step) + " per frame";
    Plot bias("Bias, " + motion, linearAxis("frame", 0, values.frames),
              linearAxis(percentAxisLabel("bias"), values.lowBias, values.highBias), 490, 270);
    Plot ratio("Variance relative to Discard, " + motion, linearAxis("frame", 0, values.frames),
               linearAxis("variance / that of Discard", 0, values.highRatio), 490, 270);
    addChance(bias, group);
    size_t right = 0, wrong = 0;
    for (size_t i = 0; i < group.size(); ++i) {
        const LobeSequence& sequence = *group[i];
        const std::string style = lobeStyle(sequence.unbiased ? right++ : wrong++, sequence);
        const std::string line = style + (sequence.unbiased ? "" : " dashed");
        bias.curve(values.bias[i], line);
        bias.legend({lobeLabel(sequence), line});
        if (!sequence.unbiased) continue;  // the variance of a wrong answer is of no interest
        ratio.curve(values.ratio[i], line);
        ratio.legend({lobeLabel(sequence), line});
    }
    return "<figure>" + bias.element() + "</figure>\n<figure>" + ratio.element() + "</figure>\n";
}

std::string lobeTable(const std::vector<LobeSequence>& sequences)
{
    std::string rows;
    for (const LobeSequence& s : sequences) {
        double largest = 0;
        for (const LobeFrame& frame : s.frames)
            if (std::isfinite(frame.z)) largest = std::max(largest, std::abs(frame.z));
        rows += "<tr>" + numberCell(numberText(s.step)) + "<td>" + escapeMarkup(lobeLabel(s)) +
                "</td><td>" + (s.unbiased ? "unbiased" : "biased") + "</td>" +
                numberCell(percent(s.largestBias)) + numberCell(shortNumber(largest, 2)) +
                numberCell(shortNumber(s.lateVarianceRatio)) +
                numberCell(shortNumber(s.expectedRatio)) + "</tr>\n";
    }
    return tableMarkup(numberHead("δ") + "<th>method</th><th></th>" + numberHead("largest bias") +
                           numberHead("largest |z|") + numberHead("late variance / Discard") +
                           numberHead("expected"),
                       rows);
}

}  // namespace

std::string sweepsSection(const LabResults& results)
{
    std::string html;
    if (!results.overC.empty()) {
        html += "<h3>The scale c</h3>\n" +
                paragraph(
                    "c says how far the old samples are trusted: more is fewer new samples where "
                    "the old ones are. The best value for a flat f with noise, c*, solves c·n = "
                    "N·R(c). Points: measured, with bars of one standard error; lines: predicted; "
                    "both relative to the prediction at c*; R-A with k = 4 and n = N. " +
                    agreement(results.overC));
        SweepLook look{"c / c*",
                       "N·Var / that at c*",
                       {{0.25, "¼"}, {0.5, "½"}, {1, "1"}, {2, "2"}, {4, "4"}},
                       1,
                       true};
        html += sweepPlots(results.overC, look, [](const SweepPoint& p) { return p.cFactor; }) +
                sweepData("c", "c_factor");
    }
    if (!results.overK.empty()) {
        std::vector<Tick> ticks;
        for (const SweepPoint& p : results.overK)
            if (std::none_of(ticks.begin(), ticks.end(),
                             [&](const Tick& t) { return t.value == p.candidates; }))
                ticks.push_back({static_cast<double>(p.candidates), std::to_string(p.candidates)});
        std::sort(ticks.begin(), ticks.end(),
                  [](const Tick& a, const Tick& b) { return a.value < b.value; });
        html += "<h3>The number of candidates k</h3>\n" +
                paragraph("Each new sample is chosen among k candidates, each of which costs two "
                          "evaluations of a density but no ray. Relative to the prediction at the "
                          "largest k; at c*, n = N. " +
                          agreement(results.overK));
        const SweepLook look{"k", "N·Var / that at k = " + ticks.back().label, ticks,
                             ticks.back().value, false};
        html += sweepPlots(results.overK, look,
                           [](const SweepPoint& p) { return static_cast<double>(p.candidates); }) +
                sweepData("k", "k");
    }
    return html.empty() ? html : section("sweeps", "How c and k matter", html);
}

std::string majorisationSection(const LabResults& results)
{
    if (results.majorisation.empty()) return {};
    struct Curve {
        const char* label;
        const char* style;
        double MajorisationPoint::*value;
        bool dashed;
    };
    constexpr Curve kCurves[] = {
        {"b, of Rejection", "c-pink", &MajorisationPoint::rejection, false},
        {"a, of Augmentation", "c-yellow", &MajorisationPoint::augmentation, true},
        {"M*/N, of R-A", "c-blue", &MajorisationPoint::growth, false},
        {"c*", "c-sky", &MajorisationPoint::c, true},
        {"TV", "c-grey", &MajorisationPoint::totalVariation, false},
        {"ESS/N of Reweighting", "c-orange", &MajorisationPoint::reweightingEss, false}};
    double low = kInfinite, high = 0, left = kInfinite, right = -kInfinite;
    for (const MajorisationPoint& p : results.majorisation) {
        left = std::min(left, p.position);
        right = std::max(right, p.position);
        for (const Curve& curve : kCurves)
            if (std::isfinite(p.*curve.value) && p.*curve.value > 1e-3) {
                low = std::min(low, p.*curve.value);
                high = std::max(high, p.*curve.value);
            }
    }
    Plot plot("Constants as the new lobe moves away from the old one at .45",
              linearAxis("centre of the new lobe", left, right, 6),
              logAxis("constant, or share", low, high), 760, 340);
    for (const Curve& curve : kCurves) {
        std::vector<Point> points;
        for (const MajorisationPoint& p : results.majorisation)
            points.push_back({p.position, p.*curve.value > 0 ? p.*curve.value : kUnknown});
        const std::string style = std::string(curve.style) + (curve.dashed ? " dashed" : "");
        plot.curve(points, style);
        plot.legend({curve.label, style});
    }
    const MajorisationPoint& last = results.majorisation.back();
    std::string html = paragraph(
        "Rejection keeps one old sample in b; Augmentation adds a − 1 new ones per old one. Both "
        "constants are the worst ratio of the two densities anywhere, and they grow quickly: here "
        "to b = " +
        shortNumber(last.rejection) + " and a = " + shortNumber(last.augmentation) +
        ". R-A needs neither: its set of M* samples stays between n and N + n, here at M*/N = " +
        shortNumber(last.growth) + ".");
    html += "<figure>" + plot.element() + "</figure>\n" +
            dataLine("majorisation.csv", {"position", "rejection", "augmentation", "c", "growth",
                                          "total_variation", "reweighting_ess"});
    return section("majorisation", "The constants that R-A does not need", html);
}

std::string lobesSection(const LabResults& results)
{
    if (results.lobes.empty()) return {};
    std::map<double, std::vector<const LobeSequence*>> byStep;
    for (const LobeSequence& sequence : results.lobes) byStep[sequence.step].push_back(&sequence);
    std::string html = paragraph(
        "A lobe that moves on in every frame, as a glint does under a moving camera: each frame "
        "reuses the set that the last one left. With absolute weights the mean stays right, frame "
        "after frame. The obvious shortcut, to take the stored set for exact samples of the last "
        "density, does not: samples resampled among k candidates do not have the density that they "
        "seem to have, and the error feeds on itself. And \"accumulation\", the average of old "
        "pixel values that a simple viewer shows, paints the glint where it was.");
    html += "<div class=\"pairoffigures\">\n";
    for (const auto& [step, group] : byStep) html += lobePlots(step, group);
    html +=
        "</div>\n" +
        dataLine("lobes.csv", {"step", "method", "k", "frame", "bias", "z", "variance_ratio"}) +
        lobeTable(results.lobes) +
        "<p class=\"small\">Late: the mean of the frames 30 to 39. Expected: what an independent "
        "computation gave, where there is one.</p>\n" +
        dataLine("lab.json",
                 {"lobes.largest_bias", "lobes.late_variance_ratio", "lobes.expected_ratio"}) +
        storesPart(results);
    return section("lobes", "A lobe that moves from frame to frame", html);
}

}  // namespace app::lab
