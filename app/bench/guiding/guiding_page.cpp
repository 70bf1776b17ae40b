// See guiding_page.h.
#include "app/bench/guiding/guiding_page.h"

#include <algorithm>
#include <cmath>

#include "app/base/read_value.h"
#include "app/bench/guiding/guiding_cases.h"
#include "app/bench/guiding/guiding_goals.h"
#include "app/report/page.h"
#include "app/report/text.h"

namespace app::guiding {

namespace {

using namespace report;

/// The efficiency of `guided` in each scene at the largest of the usual numbers of samples.
std::string tiles(const Results& r)
{
    std::string html;
    for (const SceneResult& scene : r.scenes)
        for (const BenchDevice& device : r.devices) {
            const Row *plain = findRow(scene, "path", device.name, r.samples.back()),
                      *guided = findRow(scene, "guided", device.name, r.samples.back());
            if (plain == nullptr || guided == nullptr) continue;
            html += tile(shortNumber(efficiency(device, *plain, *guided).value) + "×",
                         "efficiency in " + scene.name + " on " + device.name + ", with " +
                             shortNumber(varianceRatio(*plain, *guided).value) + "× less variance");
        }
    return html.empty() ? html : "<div class=\"tiles\">\n" + html + "</div>\n";
}

bool isMeasured(const Results& r, const Variant& variant)
{
    for (const SceneResult& scene : r.scenes)
        if (std::ranges::find(scene.rows, variant.name, &Row::variant) != scene.rows.end())
            return true;
    return false;
}

std::string summarySection(const Results& r)
{
    std::string names;
    for (const Variant& variant : variantTable())
        if (isMeasured(r, variant))
            names += "<li><b>" + std::string(variant.name) + "</b>: " + escapeMarkup(variant.help) +
                     "</li>\n";
    return section(
        "summary", "Summary",
        paragraph("Path guiding learns from the paths of a picture where its light comes from, and "
                  "sends later paths there. That costs time for every path: it pays where "
                  "variance falls by more than time grows. The efficiency is that of path tracing "
                  "without a guide over its own, each error times seconds: how many times longer "
                  "path tracing takes to the same error. With " +
                  std::to_string(r.samples.back()) + " samples per pixel:") +
            tiles(r) + "<ul>\n" + names + "</ul>\n");
}

Judgement judgementOf(Verdict verdict)
{
    return verdict == Verdict::met      ? Judgement::good
           : verdict == Verdict::missed ? Judgement::bad
                                        : Judgement::open;
}

std::string goalsSection(const Results& r)
{
    std::string rows;
    for (const Goal& goal : goalsOf(r))
        rows += "<tr><td>" + escapeMarkup(goal.text) + "</td>" +
                numberCell("≥ " + shortNumber(goal.least)) + numberCell(ratioText(goal.measured)) +
                "<td>" + escapeMarkup(goal.where) + "</td><td>" +
                verdictSpan(verdictName(goal.verdict), judgementOf(goal.verdict)) + "</td></tr>\n";
    return section("goals", "Goals",
                   paragraph("What <b>guided</b> is to reach, in efficiency where nothing else is "
                             "said. Measured is the least "
                             "number that falls under the goal, in brackets what single seeds "
                             "span.") +
                       tableMarkup("<th>goal</th>" + numberHead("wanted") + numberHead("measured") +
                                       "<th>where</th><th>verdict</th>",
                                   rows));
}

std::string methodSection(const Results& r)
{
    return section(
        "method", "How this was measured",
        "<ul>\n<li>relMSE = mean(d²/(r²+0.01)) over pixels and channels, with d = picture − "
        "reference and r the mean of the reference over 3×3 pixels, so that fireflies which it may "
        "have left do not hide those of the pictures.</li>\n"
        "<li>The reference is guided path tracing, as it is by default whatever is measured, with "
        "many samples in two halves, of seeds that no picture has. What the noise of their mean "
        "adds to squared errors is taken off, as the "
        "difference of the halves tells it.</li>\n<li>" +
            counted(r.seeds, "picture") +
            " of each kind, each with a seed of its own, which plain and guided pictures share. "
            "Variants took turns within a seed, forwards and backwards by turns. Ratios are of the "
            "means over the seeds; in brackets what single seeds span; ± is a standard error from "
            "how much tiles of 8×8 pixels vary between seeds.</li>\n"
            "<li>Seconds hold everything from the first sample to the last, learning included. "
            "Efficiency counts them so — " +
            escapeMarkup(clockText(r.devices)) +
            ".</li>\n"
            "<li>Mean − path’s: how much brighter the pictures are than those of <b>path</b> with "
            "the same seeds, and z how many standard errors that is. Red is further than four, "
            "which chance hardly does: a bias.</li>\n"
            "<li>Guided: the share of the vertices that lay in a leaf of the guide that was used; "
            "MB and guide s are those of the guide alone, by the clock on the wall.</li>\n</ul>\n");
}

constexpr const char* kFoot =
    "<p>The numbers behind this page: <code>guiding.json</code> holds everything, "
    "<code>guiding.csv</code> the rows; <code>pictures/</code> holds the pictures, "
    "<code>references/</code> the references with their variance.</p>";

}  // namespace

std::string resultsPage(const Results& r, const std::filesystem::path& folder)
{
    Page page;
    page.title = "Path guiding: error against time";
    page.lead = "What it gains to learn where light comes from, and what it costs.";
    page.facts =
        runFacts(r, counted(r.seeds, "seed") + " · depth " + numberText(r.params.maxDepth));
    page.warning = warningText(r.interrupted,
                               r.quick ? "A quick run: few seeds, and a noisier reference." : "");
    page.sections = {{"summary", "Summary", summarySection(r)},
                     {"goals", "Goals", goalsSection(r)}};
    for (size_t i = 0; i < r.scenes.size(); ++i) {
        const std::string id = "scene-" + std::to_string(i + 1);
        page.sections.push_back(
            {id, escapeMarkup(r.scenes[i].name),
             section(id, r.scenes[i].name, sceneMarkup(r, r.scenes[i], folder))});
    }
    page.sections.push_back({"method", "Method", methodSection(r)});
    page.foot = kFoot;
    return pageHtml(page);
}

}  // namespace app::guiding
