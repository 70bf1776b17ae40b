// What the window showed at the end of flights in its own loop, as a part of a scene's section.
#include <cmath>

#include "app/bench/flythrough/flight_page_parts.h"
#include "app/report/page.h"
#include "app/report/text.h"

namespace app::flight {

using namespace report;

namespace {

std::string crewCell(const WindowRow& row)
{
    const std::string paths = row.paths == 1 ? "" : ", " + shortNumber(row.paths) + " paths";
    return "<td class=\"name\"><span class=\"swatch " + lookOf(row.strategy).style + "\"></span>" +
           escapeMarkup(row.strategy) + paths + "</td>";
}

std::string windowTable(const SceneResult& scene, double target)
{
    std::string rows;
    for (const WindowRow& row : scene.window) {
        if (row.target != target) continue;
        const Measured& bias = row.errors.signedError;
        rows += "<tr>" + crewCell(row) + numberCell(shortNumber(1e3 * row.pictureSeconds)) +
                numberCell(shortNumber(row.scale, 2)) + numberCell(shortNumber(row.fineScale, 2)) +
                numberCell(shortNumber(row.errors.relMse.value)) +
                numberCell(measured(row.ratio.value, row.ratio.error)) +
                numberCell(shortNumber(row.trimmedRatio.value)) +
                numberCell(measured(row.shownRatio.value, row.shownRatio.error)) +
                numberCell(measured(row.underWayRatio.value, row.underWayRatio.error)) +
                numberCell(shortNumber(row.bySizeRatio.value)) +
                numberCell(percent(bias.value / scene.windowRadiance) + " ± " +
                           percent(bias.error / scene.windowRadiance)) +
                "</tr>\n";
    }
    return tableMarkup(
        "<th>strategy</th>" + numberHead("ms per picture") + numberHead("sides, light") +
            numberHead("surfaces") + numberHead("relMSE") + numberHead("over discard") +
            numberHead("without fireflies") + numberHead("as shown") + numberHead("under way") +
            numberHead("by size") + numberHead("signed error"),
        rows);
}

}  // namespace

std::string windowMarkup(const Results& r, const SceneResult& scene)
{
    if (scene.window.empty()) return {};
    std::string html =
        "<h3>In the window's own loop</h3>\n" +
        paragraph(
            "A window of " + std::to_string(r.windowSize.x) + "×" + std::to_string(r.windowSize.y) +
            " in which the camera moves by the clock, " + shortNumber(scene.windowSpeed) + ' ' +
            escapeMarkup(scene.unit) + " per second for " + shortNumber(scene.windowSeconds) +
            " s: pictures are as small as the wanted rate demands, and stretched over the window. "
            "What is on show in the last view is compared with what the window shows there at "
            "rest, so that edges count, too; as radiance, and <i>as shown</i>: the mean square "
            "error of the colours on the screen (smooth within surfaces while the camera moves) "
            "over Discard's. <i>Under way</i>: the same of what is on show at the moment "
            "in which the camera arrives, which was made for a place before it. <i>By size</i>: "
            "that of pictures whose light has as few pixels but no "
            "noise, on the same surfaces. <i>Sides</i> are of light and of surfaces (first hits) "
            "over the window's; <i>paths</i> are new ones per pixel and picture.");
    double last = 0, share = 0;
    for (const WindowRow& row : scene.window) {
        share += row.share / static_cast<double>(scene.window.size());
        if (row.target == last) continue;
        last = row.target;
        html += "<h4>" + shortNumber(1e3 * row.target) + " ms from picture to picture</h4>\n" +
                windowTable(scene, row.target);
    }
    return html + "<p class=\"small\">The process ran in " + percent(share) +
           " of the time in which it wanted to; the clock of the flights was slowed by as much, "
           "and "
           "times are told by it.</p>\n";
}

}  // namespace app::flight
