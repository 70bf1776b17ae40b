// See many_lights_page.h.
#include "app/bench/many_lights/many_lights_page.h"

#include <cmath>

#include "app/base/read_value.h"
#include "app/bench/many_lights/many_lights_cases.h"
#include "app/bench/many_lights/many_lights_page_parts.h"
#include "app/report/page.h"
#include "app/report/text.h"

namespace app::many_lights {

namespace {

using namespace report;

/// Geometric mean over scenes of a ratio at the main number of clusters; NaN without any.
double meanRatio(const Results& r, const char* method, const char* over,
                 double (*number)(const Sample&))
{
    double sum = 0, count = 0;
    for (const SceneResult& scene : r.scenes) {
        const Row *row = findRow(scene, method, r.mainClusters),
                  *other = findRow(scene, over, r.mainClusters);
        if (row == nullptr || other == nullptr) continue;
        sum += std::log(ratioOf(*row, *other, number).median);
        ++count;
    }
    return count > 0 ? std::exp(sum / count) : kUnknown;
}

std::string tiles(const Results& r)
{
    struct Tile {
        const char *method, *over, *words;
        double (*number)(const Sample&);
    };
    constexpr Tile kTiles[] = {
        {"matching", "full", "of the time of full sampling in packets: this program's completion",
         secondsOf},
        {"matching", "full-single", "of the time of full sampling ray by ray", secondsOf},
        {"thesis-single", "thesis-full-single", "the thesis's method over its baseline, ray by ray",
         secondsOf},
        {"matching", "full", "of the error of full sampling at equal clusters", rmse8Of},
    };
    std::string html;
    for (const Tile& t : kTiles) {
        const double ratio = meanRatio(r, t.method, t.over, t.number);
        if (!std::isnan(ratio)) html += tile(shortNumber(ratio), t.words);
    }
    return html.empty() ? html : "<div class=\"tiles\">\n" + html + "</div>\n";
}

std::string summarySection(const Results& r)
{
    std::string names;
    for (const Method& method : methodTable())
        names +=
            "<li><b>" + std::string(method.name) + "</b>: " + escapeMarkup(method.help) + "</li>\n";
    return section(
        "summary", "Summary",
        paragraph("A picture is lit by many virtual lights: points that lie and face alike make a "
                  "slice, and for each slice some hundreds of clusters stand for all lights. Most "
                  "of the time goes into shadow rays between points and clusters. <b>full</b> "
                  "traces all of them; completion traces some and predicts the rest. Geometric "
                  "means over the scenes, " +
                  std::to_string(r.mainClusters) + " clusters:") +
            tiles(r) + "<ul>\n" + names + "</ul>\n");
}

std::string verdictMarkup(Verdict verdict)
{
    return verdictSpan(verdictName(verdict), verdict == Verdict::reproduced ? Judgement::good
                                             : verdict == Verdict::refuted  ? Judgement::bad
                                                                            : Judgement::open);
}

std::string rangeText(const Finding& f)
{
    if (std::isinf(f.high)) return "≥ " + shortNumber(f.low);
    return f.low == 0 ? "≤ " + shortNumber(f.high) : shortNumber(f.low) + "–" + shortNumber(f.high);
}

std::string findingsTable(const Claim& claim)
{
    std::string rows;
    for (const Finding& f : claim.findings)
        rows += "<tr><td>" + escapeMarkup(f.scene) + "</td><td>" + escapeMarkup(f.what) + "</td>" +
                numberCell(spreadText(f.value)) + numberCell(rangeText(f)) + "<td>" +
                verdictMarkup(verdictOf(f)) + "</td></tr>\n";
    return "<details><summary>" + counted(claim.findings.size(), "number") + "</summary>\n" +
           tableMarkup("<th>scene</th><th>number</th>" + numberHead("measured") +
                           numberHead("claimed") + "<th>verdict</th>",
                       rows) +
           "</details>\n";
}

std::string claimsSection(const Results& r)
{
    std::string html = paragraph(
        "Each number is the median of the repetitions with their least and greatest. It counts as "
        "reproduced when all of them lie where the claim says, as refuted when all lie on one side "
        "of that, and else as undecided. A claim is refuted by one number, or by half of the "
        "decided ones where it speaks of most scenes.");
    for (const Claim& claim : claimsOf(r)) {
        if (claim.findings.empty()) continue;
        size_t counts[3] = {};
        for (const Finding& f : claim.findings) ++counts[static_cast<size_t>(verdictOf(f))];
        html += "<h3>" + escapeMarkup(claim.name) + ": " + verdictMarkup(verdictOf(claim)) +
                "</h3>\n" + paragraph(escapeMarkup(claim.text) + ".") + "<p class=\"small\">" +
                outOf(counts[0], claim.findings.size()) + " reproduced, " +
                std::to_string(counts[1]) + " refuted, " + std::to_string(counts[2]) +
                " undecided.</p>\n" + findingsTable(claim);
    }
    return section("claims", "Claims", html);
}

std::string ratesText(const SceneResult& scene)
{
    const RayRates& rates = scene.rates;
    if (!(rates.raw > 0)) return {};
    const auto millions = [](double rate) { return shortNumber(1e-6 * rate); };
    return " A thread answers " + millions(rates.packets) +
           " million shadow rays per second in full sampling, " + millions(rates.single) +
           " ray by ray, and " + millions(rates.raw) +
           " with packets that lie ready (rtcOccluded16 alone): full sampling traces " +
           shortNumber(rates.ratio) + " of what the tracer can.";
}

std::string sceneSection(const Results& r, const SceneResult& scene, size_t index,
                         const std::filesystem::path& folder)
{
    const double share = double(scene.litReceivers) / double(scene.receivers);
    return section(
        "scene-" + std::to_string(index + 1), scene.name,
        paragraph(std::to_string(scene.size.x) + "×" + std::to_string(scene.size.y) + " with " +
                  std::to_string(scene.receivers) + " receivers in " +
                  std::to_string(scene.slices) + " slices, " + std::to_string(scene.triangles) +
                  " triangles, " + std::to_string(scene.lights) + " lights, clamped below " +
                  shortNumber(scene.clampDistance) +
                  " m. Lit: " + std::to_string(scene.litReceivers) + " receivers (" +
                  shortNumber(100 * share) + " %) in " + std::to_string(scene.pixels) +
                  " pixels. Apart from what is timed: lights " + shortNumber(scene.lightSeconds) +
                  " s, their tree " + shortNumber(scene.treeSeconds) + " s, receivers and slices " +
                  shortNumber(scene.receiverSeconds) + " s. " + shortNumber(100 * scene.clipped) +
                  " % of the reference's values are too bright for 8 bits." + ratesText(scene)) +
            scenePlots(r, scene) + sceneTable(r, scene) + ratesTable(scene) +
            shotsMarkup(scene, folder));
}

std::string methodSection(const Results& r)
{
    return section(
        "method", "How this was measured",
        "<ul>\n<li>All methods of a scene share virtual lights, receivers, slices and the clamp; "
        "mirrors and clear glass are followed from the camera, and light that virtual lights do "
        "not bring is left out, as in the thesis.</li>\n"
        "<li>Slices drawn at random stand for the frame. Seconds and rays are those of the lit "
        "slices over their share of the receivers, so they are what a whole frame would "
        "take.</li>\n"
        "<li>Timed is what lies between the light tree and the shaded slice: cut, order of the "
        "columns, rays, matching, shading. Lights, tree and receivers are told apart. Seconds are "
        "processor time of the program over the number of cores, which other processes hardly "
        "disturb; their parts divide as the threads' own clocks say. “µs / column”: what finding "
        "the visibility of a column takes of a thread beside its rays.</li>\n<li>" +
            counted(r.repetitions, "repetition") +
            ", each with a light tree (and so representatives) and random numbers of its own, "
            "methods forwards and backwards by turns. Ratios are taken within a repetition; shown "
            "is the median with the least and the greatest.</li>\n"
            "<li>The reference is the sum over all lights, every ray traced, for the same "
            "receivers.</li>\n"
            "<li>8-bit RMSE: the mean of a pixel's receivers as 8-bit sRGB (0 to 1), decoded, "
            "raised to 1/2.2, over pixels and channels; half a grey level is .002. HDR RMSE and "
            "relMSE, mean (a − b)²/(b² + .01), are of radiance. A pixel that belongs to the lit "
            "slices in part counts with the receivers that do. “same slices”: over full "
            "sampling in slices of the method's own size, which says what completion alone loses; "
            "“to full”: 8-bit RMSE against that picture.</li>\n</ul>\n");
}

std::string facts(const Results& r)
{
    std::string text = programText(r.version, r.commit) + " · " + r.machine + ", " +
                       counted(r.cores, "core") + " · " + counted(r.repetitions, "repetition") +
                       " · " + numberText(r.params.receivers) + " receivers per pixel · seed " +
                       numberText(r.params.seed);
    if (r.seconds > 0) text += " · " + shortNumber(r.seconds) + " s";
    return text;
}

constexpr const char* kFoot =
    "<p>The numbers behind this page: <code>manylights.json</code> holds everything; "
    "<code>pictures/</code> holds the pictures, <code>references/</code> the references. The "
    "thesis: S. Wang, “Efficient Sample Usage in Photo-Realistic Rendering” (2022).</p>";

}  // namespace

std::string resultsPage(const Results& r, const std::filesystem::path& folder)
{
    Page page;
    page.title = "Many lights: time against error";
    page.lead = "What it costs to light a picture by many virtual lights, and what is lost when "
                "most of the visibility is predicted.";
    page.facts = facts(r);
    page.warning = warningText(
        r.interrupted, r.quick ? "A quick run: a smaller picture, fewer lights and settings." : "");
    page.sections = {
        {"summary", "Summary", summarySection(r)},
        {"claims", "Claims", claimsSection(r)},
        {"thesis", "Beside the thesis", section("thesis", "Beside the thesis", thesisMarkup(r))}};
    for (size_t i = 0; i < r.scenes.size(); ++i)
        page.sections.push_back({"scene-" + std::to_string(i + 1), escapeMarkup(r.scenes[i].name),
                                 sceneSection(r, r.scenes[i], i, folder)});
    page.sections.push_back({"method", "Method", methodSection(r)});
    page.foot = kFoot;
    return pageHtml(page);
}

}  // namespace app::many_lights
