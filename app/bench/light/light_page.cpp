// See light_page.h.
#include "app/bench/light/light_page.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/base/read_value.h"
#include "app/bench/light/light_cases.h"
#include "app/report/curves.h"
#include "app/report/page.h"
#include "app/report/text.h"

namespace app::light {

namespace {

using namespace report;
using report::Curve;  // not the viewer's

constexpr double kBiasScore = 4;  // standard errors that are no chance

bool isMeasured(const Results& r, const Strategy& strategy)
{
    return std::ranges::any_of(r.scenes, [&](const SceneResult& scene) {
        return std::ranges::find(scene.rows, strategy.name, &Row::strategy) != scene.rows.end();
    });
}

/// The efficiency of the tree in each scene that has one, at the largest number of samples.
std::string tiles(const Results& r)
{
    std::string html;
    for (const SceneResult& scene : r.scenes)
        for (const BenchDevice& device : r.devices) {
            const Row* row = findRow(scene, "tree", device.name, r.samples.back());
            if (row == nullptr) continue;
            const Row& plain = *plainOf(scene, *row);
            html +=
                tile(shortNumber(efficiency(device, plain, *row, &Sample::relMse).value) + "×",
                     "efficiency of the tree in " + scene.name + " on " + device.name + ", with " +
                         shortNumber(errorRatio(plain, *row, &Sample::relMse).value) +
                         "× less error in " + shortNumber(timeRatio(device, plain, *row).value) +
                         "× the time");
        }
    return html.empty() ? html : "<div class=\"tiles\">\n" + html + "</div>\n";
}

std::string summarySection(const Results& r)
{
    std::string names;
    for (const Strategy& strategy : strategyTable())
        if (isMeasured(r, strategy))
            names += "<li><b>" + std::string(strategy.name) +
                     "</b>: " + escapeMarkup(strategy.help) + "</li>\n";
    return section(
        "summary", "Summary",
        paragraph("A path is connected to one emitter at each of its vertices. Which one "
                  "is a matter of chance, and of how well the chances follow what each "
                  "can bring: that costs time. The efficiency is error times seconds of "
                  "<b>power</b> over those of a strategy: how many times longer "
                  "<b>power</b> takes to the same error.") +
            tiles(r) + "<ul>\n" + names + "</ul>\n");
}

/// A colour for each device, a shape for each strategy.
std::vector<Curve> curvesOf(const Results& r, const SceneResult& scene, double Sample::*error)
{
    constexpr std::array kColours{"c-blue", "c-orange"};
    constexpr std::array kShapes{Shape::circle, Shape::diamond, Shape::square, Shape::triangle};
    std::vector<Curve> curves;
    for (size_t d = 0; d < r.devices.size(); ++d) {
        size_t shape = 0;
        for (const Strategy& strategy : strategyTable()) {
            Curve curve{std::string(strategy.name) + ", " + r.devices[d].name,
                        std::string(kColours[d % kColours.size()]) +
                            (strategy.choice == Strategy::Choice::power ? " dashed" : ""),
                        kShapes[shape++ % kShapes.size()],
                        {}};
            for (const Row& row : scene.rows)
                if (row.strategy == strategy.name && row.device == r.devices[d].name)
                    curve.points.push_back({meanSeconds(r.devices[d], row), meanOf(row, error)});
            if (!curve.points.empty()) curves.push_back(std::move(curve));
        }
    }
    return curves;
}

std::string tableRow(const Results& r, const SceneResult& scene, const Row& row)
{
    const Row& plain = *plainOf(scene, row);
    const BenchDevice& device = deviceNamed(r, row.device);
    const bool isPlain = &plain == &row;
    const auto ratioCell = [&](const Ratio& ratio) {
        return numberCell(isPlain ? "1" : ratioText(ratio));
    };
    const double score = biasScore(row);
    return "<tr><td>" + row.device + "</td>" + numberCell(std::to_string(row.spp)) +
           "<td class=\"name\">" + escapeMarkup(row.strategy) + "</td>" +
           numberCell(shortNumber(meanOf(row, &Sample::cpuSeconds))) +
           numberCell(shortNumber(meanOf(row, &Sample::renderSeconds))) +
           ratioCell(timeRatio(device, plain, row)) +
           numberCell(shortNumber(meanOf(row, &Sample::rays) / meanOf(plain, &Sample::rays))) +
           numberCell(shortNumber(meanOf(row, &Sample::relMse))) +
           numberCell(shortNumber(meanOf(row, &Sample::trimmed))) +
           ratioCell(efficiency(device, plain, row, &Sample::relMse)) +
           ratioCell(efficiency(device, plain, row, &Sample::trimmed)) +
           numberCell(std::isfinite(relativeBias(row))
                          ? fixedNumber(100 * relativeBias(row), 2) + " %"
                          : "–") +
           numberCell(std::isfinite(score) ? fixedNumber(score, 1) : "–",
                      std::abs(score) > kBiasScore) +
           "</tr>\n";
}

std::string sceneMarkup(const Results& r, const SceneResult& scene)
{
    std::string rows;
    for (const BenchDevice& device : r.devices)
        for (const Row& row : scene.rows)
            if (row.device == device.name) rows += tableRow(r, scene, row);
    const std::string tree = scene.choosesByTree ? "chosen by the tree unless told otherwise"
                             : scene.hasTree ? "chosen by power unless told otherwise: the tree "
                                               "does not promise enough here"
                                             : "chosen by power: too few lamps for a tree";
    return paragraph(std::to_string(scene.size.x) + "×" + std::to_string(scene.size.y) + ", " +
                     std::to_string(scene.triangles) + " triangles, " +
                     counted(scene.emitters, "emitter") + ", " + tree + ". Loaded in " +
                     shortNumber(scene.loadSeconds) + " s, which no time below holds.") +
           "<div class=\"pairoffigures\">\n" +
           curvesFigure("Error against time", "seconds", "relMSE",
                        curvesOf(r, scene, &Sample::relMse), false) +
           curvesFigure("Without the brightest hundredth of errors", "seconds", "relMSE, trimmed",
                        curvesOf(r, scene, &Sample::trimmed), false) +
           "</div>\n" +
           tableMarkup("<th>device</th>" + numberHead("spp") + "<th>strategy</th>" +
                           numberHead("CPU s") + numberHead("render s") +
                           numberHead("time / power") + numberHead("rays / power") +
                           numberHead("relMSE") + numberHead("trimmed") + numberHead("efficiency") +
                           numberHead("efficiency,<br>trimmed") + numberHead("mean −<br>power’s") +
                           numberHead("z"),
                       rows);
}

std::string methodSection(const Results& r)
{
    return section(
        "method", "How this was measured",
        "<ul>\n<li>Pictures come in pairs of independent seeds, " + counted(r.pairs, "pair") +
            " of each kind; all strategies share the seeds. relMSE is that of one picture: "
            "mean(d²/2/(r²+0.01)) over pixels and channels, with d the difference of the two and "
            "r the mean of the scene’s pictures of other pairs, by all strategies, so that no "
            "bright "
            "pixel hides its own error. No reference is needed, and none could be trusted where "
            "all "
            "strategies are noisy; a bias does not show in such errors, but in the last "
            "columns.</li>\n<li>Trimmed: without the hundredth of the pixels in which the error is "
            "largest, which tells what fireflies add.</li>\n<li>Ratios are of the means over the "
            "pairs; in brackets what single pairs span. Strategies took turns within a pair, "
            "forwards and backwards by turns.</li>\n<li>Seconds are those of one picture, from its "
            "first sample to its last; loading, building and compiling are not in them. Efficiency "
            "counts them so — " +
            escapeMarkup(clockText(r.devices)) +
            ".</li>\n<li>Mean − power’s: how much brighter the pictures are than those of "
            "<b>power</b> with the same seeds, and z how many standard errors that is. Red is "
            "further than four, which chance hardly does: a bias.</li>\n</ul>\n");
}

constexpr const char* kFoot =
    "<p>The numbers behind this page: <code>light.json</code> holds everything, "
    "<code>light.csv</code> the rows.</p>";

}  // namespace

std::string resultsPage(const Results& r)
{
    Page page;
    page.title = "Finding light: error against time";
    page.lead = "What each way to choose an emitter gains, and what it costs.";
    page.facts =
        runFacts(r, counted(r.pairs, "pair") + " · depth " + numberText(r.params.maxDepth));
    page.warning =
        warningText(r.interrupted, r.quick ? "A quick run: few and noisy pictures." : "");
    page.sections = {{"summary", "Summary", summarySection(r)}};
    for (size_t i = 0; i < r.scenes.size(); ++i) {
        const std::string id = "scene-" + std::to_string(i + 1);
        page.sections.push_back({id, escapeMarkup(r.scenes[i].name),
                                 section(id, r.scenes[i].name, sceneMarkup(r, r.scenes[i]))});
    }
    page.sections.push_back({"method", "Method", methodSection(r)});
    page.foot = kFoot;
    return pageHtml(page);
}

}  // namespace app::light
