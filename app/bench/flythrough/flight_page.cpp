// See flight_page.h.
#include "app/bench/flythrough/flight_page.h"

#include <algorithm>
#include <cmath>

#include "app/base/read_value.h"
#include "app/bench/flythrough/flight_page_parts.h"
#include "app/report/page.h"
#include "app/report/text.h"

namespace app::flight {

namespace {

using namespace report;

const std::string kFull(core::enumName(core::ReuseStrategy::full));

const Row* shownRow(const Results& r, const SceneResult& scene, const std::string& strategy)
{
    return rowOf(scene, strategy, scene.shownStep, r.longest());
}

std::string nameCell(const std::string& strategy)
{
    return "<td class=\"name\"><span class=\"swatch " + lookOf(strategy).style + "\"></span>" +
           escapeMarkup(strategy) + "</td>";
}

std::string signedText(const SceneResult& scene, const Measured& e)
{
    const double value = 100 * e.value / scene.radiance, error = 100 * e.error / scene.radiance;
    if (!std::isfinite(value) || !std::isfinite(error)) return "–";
    return fixedNumber(value, 2) + " ± " + fixedNumber(error, 2) + " %";
}

/// New paths of a pixel in a frame.
std::string pathsText(const Results& r)
{
    if (r.rays == 1) return "one new path per pixel";
    if (r.rays > 1) return printed("%g", r.rays) + " new paths per pixel";
    return "one new path per pixel, or " + printed("%g", r.rays) + " where the history is good";
}

/// How many rays the others may have where they are compared with discard.
std::string raysText(const Results& r)
{
    return r.rays >= 1 ? "at equal rays" : "which traces a path for every pixel";
}

/// More than four standard errors away from nothing.
bool isBiased(const Measured& e)
{
    return std::abs(e.value) > 4 * e.error;
}

// --- summary

using Number = double (*)(const Row&);

double equalRays(const Row& row)
{
    return row.ratio.value;
}
double equalRaysTrimmed(const Row& row)
{
    return row.trimmedRatio.value;
}
double equalTimeTrimmed(const Row& row)
{
    return row.trimmedTimeRatio;
}

std::string summaryTable(const Results& r, Number number)
{
    std::string head = "<th>scene</th>", rows;
    for (const std::string& strategy : r.strategies) head += numberHead(escapeMarkup(strategy));
    for (const SceneResult& scene : r.scenes) {
        rows += "<tr><td>" + escapeMarkup(scene.name) + "</td>";
        for (const std::string& strategy : r.strategies) {
            const Row* row = shownRow(r, scene, strategy);
            rows += numberCell(row == nullptr ? "–" : shortNumber(number(*row)));
        }
        rows += "</tr>\n";
    }
    return tableMarkup(head, rows);
}

/// The largest gains of a strategy that is not known to be wrong, and the largest signed error.
std::string tiles(const Results& r)
{
    const Row *best = nullptr, *quickest = nullptr, *worst = nullptr;
    const SceneResult *bestScene = nullptr, *quickestScene = nullptr, *worstScene = nullptr;
    for (const SceneResult& scene : r.scenes)
        for (const std::string& strategy : r.strategies) {
            const Row* row = shownRow(r, scene, strategy);
            if (row == nullptr) continue;
            const auto share = [](const Row& x, const SceneResult& s) {
                return std::abs(x.errors.signedError.value / s.radiance);
            };
            if (isBiased(row->errors.signedError) && std::isfinite(share(*row, scene)) &&
                (worst == nullptr || share(*row, scene) > share(*worst, *worstScene))) {
                worst = row;
                worstScene = &scene;
            }
            if (strategy == r.strategies.front() || isBiased(row->errors.signedError)) continue;
            if (strategy != kFull && row->trimmedRatio.value > 0 &&
                (best == nullptr || row->trimmedRatio.value < best->trimmedRatio.value)) {
                best = row;
                bestScene = &scene;
            }
            if (row->trimmedTimeRatio > 0 &&
                (quickest == nullptr || row->trimmedTimeRatio < quickest->trimmedTimeRatio)) {
                quickest = row;
                quickestScene = &scene;
            }
        }
    std::string html;
    if (best != nullptr)
        html += tile(shortNumber(1 / best->trimmedRatio.value, 2) + "×",
                     "less error than discard " + raysText(r) + ", fireflies left out: " +
                         best->strategy + " in " + bestScene->name + ", no bias seen");
    if (quickest != nullptr)
        html += tile(shortNumber(1 / quickest->trimmedTimeRatio, 2) + "×",
                     "less error at equal time, fireflies left out: " + quickest->strategy +
                         " in " + quickestScene->name + ", no bias seen");
    if (worst != nullptr)
        html += tile(fixedNumber(100 * worst->errors.signedError.value / worstScene->radiance, 2) +
                         " %",
                     "largest signed error that is no chance: " + worst->strategy + " in " +
                         worstScene->name);
    return html.empty() ? html : "<div class=\"tiles\">\n" + html + "</div>\n";
}

/// What the strategies do, as the command line says it.
std::string strategiesHelp()
{
    std::string help;
    const core::ReuseParams params;
    core::ReuseParams::visit(params, [&](const core::Field& field, const auto& member) {
        if constexpr (std::is_same_v<std::remove_cvref_t<decltype(member)>, core::ReuseStrategy>)
            help = field.help;
    });
    const size_t colon = help.find(": ");
    return colon == std::string::npos ? help : help.substr(colon + 2);
}

std::string summarySection(const Results& r)
{
    const std::string after = "after " + std::to_string(r.longest()) + " frames";
    std::string html = paragraph(
        "A camera flies through a scene, and each frame may trace " + pathsText(r) +
        ". <b>discard</b> throws everything else away; the others go on with samples of the frames "
        "before, each with its own idea of what they are still worth. All flights end in the same "
        "view, which is then compared with a reference. Numbers below 1 are better than discard.");
    html += paragraph("What becomes of old samples: " + escapeMarkup(strategiesHelp()) + '.');
    if (std::ranges::find(r.strategies, kFull) != r.strategies.end())
        html += paragraph("<b>full</b> is no rival but the ceiling: in every frame it traces anew "
                          "as many paths as the history would stand for, and the new ones.");
    html += tiles(r);
    html += "<h3>Error (relMSE) over that of discard " + raysText(r) + ", " + after + "</h3>\n" +
            summaryTable(r, equalRays);
    html += "<h3>The same without fireflies</h3>\n" + summaryTable(r, equalRaysTrimmed);
    html += "<h3>Without fireflies, at equal time</h3>\n" +
            paragraph("Keeping samples costs time in which discard could trace more paths: here it "
                      "may trace as many as fit.") +
            summaryTable(r, equalTimeTrimmed);
    for (const auto& [name, why] : r.leftOut)
        html += paragraph("Left out: <b>" + escapeMarkup(name) + "</b>, " + escapeMarkup(why));
    return section("summary", "Summary", html);
}

// --- scenes

std::string sceneTable(const Results& r, const SceneResult& scene)
{
    std::string rows;
    for (const std::string& strategy : r.strategies) {
        const Row* row = shownRow(r, scene, strategy);
        const Row* discard = shownRow(r, scene, r.strategies.front());
        if (row == nullptr || discard == nullptr) continue;
        const PictureErrors& e = row->errors;
        const double slowness = row->seconds / discard->seconds;
        rows += "<tr>" + nameCell(strategy) + numberCell(shortNumber(e.relMse.value)) +
                numberCell(measured(row->ratio.value, row->ratio.error)) +
                numberCell(shortNumber(row->trimmedRatio.value)) +
                numberCell(shortNumber(row->trimmedTimeRatio)) +
                numberCell(signedText(scene, e.signedError), isBiased(e.signedError)) +
                numberCell(shortNumber(row->mseRatio)) +
                numberCell(shortNumber(e.variance / discard->errors.variance)) +
                numberCell(shortNumber(row->rays / (double(scene.size.x) * scene.size.y))) +
                numberCell(shortNumber(1e3 * row->seconds)) + numberCell(shortNumber(slowness, 2)) +
                "</tr>\n";
    }
    return tableMarkup("<th>strategy</th>" + numberHead("relMSE") + numberHead("over discard") +
                           numberHead("without fireflies") + numberHead("… at equal time") +
                           numberHead("signed error") + numberHead("MSE ratio") +
                           numberHead("variance ratio") + numberHead("rays per pixel") +
                           numberHead("ms per frame") + numberHead("time / discard"),
                       rows);
}

/// Discard with more paths, which is what equal time is read from.
std::string atRestText(const Results& r, const SceneResult& scene)
{
    std::string text;
    for (const Row& row : scene.atRest)
        text += (text.empty() ? "" : ", ") + printed("%g", r.pathsOf(row.samples)) + ": relMSE " +
                shortNumber(row.errors.relMse.value) + " in " + shortNumber(1e3 * row.seconds) +
                " ms";
    return "<p class=\"small\">discard by paths per pixel and frame — " + text +
           ". The reference's own noise is relMSE " + shortNumber(scene.referenceRelMse) +
           ", which is taken off.</p>\n";
}

std::string sceneSection(const Results& r, const SceneResult& scene, size_t index,
                         const std::filesystem::path& folder)
{
    const Row* row = shownRow(r, scene, r.strategies.front());
    const std::string metres = row != nullptr ? " (" + shortNumber(row->distance) + " m)" : "";
    std::string html =
        paragraph(std::to_string(scene.size.x) + "×" + std::to_string(scene.size.y) + ", " +
                  std::to_string(scene.triangles) + " triangles. The camera flies " +
                  escapeMarkup(scene.way) + ". Table and pictures: the last of " +
                  std::to_string(r.longest()) + " frames with steps of " +
                  stepText(scene, scene.shownStep) + metres + ".") +
        scenePlots(r, scene) + morePlots(r, scene) + sceneTable(r, scene) + atRestText(r, scene);
    html += windowMarkup(r, scene);
    if (!scene.shots.empty()) html += shotsMarkup(r, scene, folder);
    return section("scene-" + std::to_string(index + 1), scene.name, html);
}

// --- parameters and method

std::string sweepsSection(const Results& r)
{
    if (r.sweeps.empty()) return {};
    return section(
        "parameters", "Parameters",
        paragraph("One parameter of <b>" + escapeMarkup(r.sweptStrategy) +
                  "</b> at a time, all others as usual, in " + escapeMarkup(r.sweptScene) +
                  " after " + std::to_string(r.longest()) +
                  " frames; error without fireflies, relative to discard. <i>records</i> and "
                  "<i>lights</i> are how "
                  "many samples a pixel keeps (K), <i>candidates</i> among how many directions a "
                  "new one is chosen (k), <i>history</i> how many old samples they may stand for "
                  "(N<sub>c</sub>), and <i>protection</i> how much bright ones are preferred when "
                  "the store is cut down (η). The share c of the old ones follows from the "
                  "history, c = N/(N+n): its bound is that of N. A history longer than the flight "
                  "cannot show what it is worth.") +
            sweepPlots(r));
}

std::string equalRaysText(const Results& r)
{
    if (r.rays >= 1) return "Equal rays: " + pathsText(r) + " and frame for everyone.";
    return "Rays are not equal: discard traces one new path per pixel and frame, the others as few "
           "as " +
           printed("%g", r.rays) + " where the history is good.";
}

std::string methodSection(const Results& r)
{
    return section(
        "method", "How this was measured",
        "<ul>\n<li>Errors are means over all pixels and channels: relMSE = mean(d²/(r²+0.01)), "
        "MSE = mean(d²), signed error = mean(d) in per cent of the reference's mean, with d = "
        "picture − reference. A few very bright pixels (fireflies) can decide such a mean: trimmed "
        "relMSE leaves out the thousandth of the pixels in which it is largest.</li>\n"
        "<li>The reference is a picture of " +
            std::to_string(r.referenceSpp) +
            " independent paths per pixel by plain path tracing through the same points of the "
            "pixels as the flights look through. What its own noise adds to squared errors is "
            "taken off, with its measured variance.</li>\n<li>" +
            std::to_string(r.seeds) +
            " flights of each kind with seeds of their own. Bars and ± are standard errors, from "
            "how "
            "much the parts of tiles of 8×8 pixels vary between flights (in the window's loop of "
            "up to 64×64 pixels, as its errors reach further), and for the signed error "
            "from the reference's noise, too. Red is further than four of them away from zero. "
            "Variance is that between the flights, mean over pixels.</li>\n"
            "<li>All flights end in the same view, whatever their length and step. Discard depends "
            "on neither and was measured once for each of them, so that it is the best known "
            "number of all.</li>\n"
            "<li>" +
            equalRaysText(r) +
            " Equal time: Discard's error after as much time, from what it "
            "reaches with " +
            printed("%g", r.pathsOf(1)) + ", " + printed("%g", r.pathsOf(2)) + " and " +
            printed("%g", r.pathsOf(4)) +
            " paths per pixel, "
            "between and beyond as a power of the time.</li>\n"
            "<li>Times are those of the last frame, in " +
            escapeMarkup(r.clock) +
            ", the median of the flights; strategies took turns.</li>\n</ul>\n");
}

std::string facts(const Results& r)
{
    std::string text = programText(r.version, r.commit) + " · " + r.device + " · " +
                       counted(r.seeds, "flight") + " of each kind · " +
                       std::to_string(r.referenceSpp) + " spp references";
    if (r.seconds > 0) text += " · " + shortNumber(r.seconds) + " s";
    return text;
}

constexpr const char* kFoot =
    "<p>The numbers behind this page: <code>flythrough.json</code> holds everything, "
    "<code>flythrough.csv</code> the rows; <code>pictures/</code> holds the pictures, "
    "<code>references/</code> the references with their variance.</p>";

}  // namespace

std::string resultsPage(const Results& r, const std::filesystem::path& folder)
{
    Page page;
    page.title = "Samples that stay: flights";
    page.lead = "What is gained, and what is lost, when a path tracer keeps its samples while the "
                "camera moves.";
    page.facts = facts(r);
    page.warning = warningText(
        r.interrupted, r.quick ? "A quick run: small pictures, short flights, few seeds." : "");
    page.sections = {{"summary", "Summary", summarySection(r)}};
    for (size_t i = 0; i < r.scenes.size(); ++i)
        page.sections.push_back({"scene-" + std::to_string(i + 1), escapeMarkup(r.scenes[i].name),
                                 sceneSection(r, r.scenes[i], i, folder)});
    page.sections.push_back({"parameters", "Parameters", sweepsSection(r)});
    page.sections.push_back({"method", "Method", methodSection(r)});
    page.foot = kFoot;
    return pageHtml(page);
}

}  // namespace app::flight
