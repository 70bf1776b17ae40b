// Pictures within the page on flights. See flight_page_parts.h.
#include "app/bench/flythrough/flight_page_parts.h"
#include "app/report/page.h"
#include "app/report/pixels.h"
#include "app/report/text.h"

namespace app::flight {

namespace {

using namespace report;

std::string caption(const Results& r, const Shot& shot)
{
    std::string text = "<b>" + escapeMarkup(shot.name) + "</b>";
    if (shot.name == "reference") return text;
    if (shot.samples > 1)
        text += ", " + printed("%g", r.pathsOf(shot.samples)) + " paths per pixel";
    return text + "<br>" + shortNumber(1e3 * shot.seconds) + " ms, relMSE " +
           shortNumber(shot.relMse);
}

}  // namespace

std::string shotsMarkup(const Results& results, const SceneResult& scene,
                        const std::filesystem::path& folder)
{
    std::string html = paragraph(
        "The last frame of one flight each, all as bright as each other, and below each the part "
        "of it that is hardest for discard. discard with more paths per pixel is what discard can "
        "do in about the time of the slowest of the others.");
    html += "<div class=\"shots\">\n";
    for (const Shot& shot : scene.shots)
        html += "<figure>" + embeddedPng(folder / shot.file, scene.name + ": " + shot.name) +
                embeddedPng(folder / shot.part, "part of it") + "<figcaption>" +
                caption(results, shot) + "</figcaption></figure>\n";
    return html + "</div>\n";
}

}  // namespace app::flight
