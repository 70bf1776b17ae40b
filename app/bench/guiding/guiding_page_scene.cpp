// Plots, table and pictures of one scene. See guiding_page.h.
#include <algorithm>
#include <array>
#include <cmath>

#include "app/bench/guiding/guiding_cases.h"
#include "app/bench/guiding/guiding_claims.h"
#include "app/bench/guiding/guiding_page.h"
#include "app/report/curves.h"
#include "app/report/page.h"
#include "app/report/pixels.h"
#include "app/report/text.h"

namespace app::guiding {

namespace {

using namespace report;
using report::Curve;  // not the viewer's

constexpr double kBiasScore = 4;  // standard errors that are no chance

double meanSeconds(const BenchDevice& device, const Row& row)
{
    return meanOf(row, [&](const Sample& s) { return secondsOf(device, s); });
}

/// A colour for each device, a shape for each of the main variants.
std::vector<Curve> curvesOf(const Results& r, const SceneResult& scene, bool ratios)
{
    constexpr std::array kColours{"c-blue", "c-orange"};
    constexpr std::array kShapes{Shape::circle, Shape::diamond, Shape::square, Shape::triangle};
    std::vector<Curve> curves;
    for (size_t d = 0; d < r.devices.size(); ++d) {
        size_t shape = 0;
        for (const Variant& variant : variantTable()) {
            if (!variant.isMain) continue;
            const bool isPlain = variant.change == nullptr;
            Curve curve{std::string(variant.name) + ", " + r.devices[d].name,
                        std::string(kColours[d % kColours.size()]) + (isPlain ? " dashed" : ""),
                        kShapes[shape++ % kShapes.size()],
                        {}};
            for (const Row& row : scene.rows) {
                if (row.variant != variant.name || row.device != r.devices[d].name) continue;
                const Row* plain = plainOf(scene, row);
                curve.points.push_back(
                    ratios ? Point{double(row.spp), efficiency(r.devices[d], *plain, row).value}
                           : Point{meanSeconds(r.devices[d], row), row.relMse.value});
            }
            if (!curve.points.empty() && !(ratios && isPlain)) curves.push_back(std::move(curve));
        }
    }
    return curves;
}

std::string measuredText(const Measured& m)
{
    return std::isfinite(m.error) ? measured(m.value, m.error) : shortNumber(m.value);
}

std::string tableRow(const Results& r, const SceneResult& scene, const Row& row)
{
    const Row* plain = plainOf(scene, row);
    const BenchDevice& device = deviceNamed(r, row.device);
    const bool isPlain = plain == &row;
    const auto of = [&row](double Sample::*member) {
        return meanOf(row, [member](const Sample& s) { return s.*member; });
    };
    const auto ratioCell = [&](const Ratio& ratio) {
        return numberCell(isPlain ? "1" : ratioText(ratio));
    };
    const double score = biasScore(row);
    return "<tr><td>" + row.device + "</td>" + numberCell(std::to_string(row.spp)) +
           "<td class=\"name\">" + escapeMarkup(row.variant) + "</td>" +
           numberCell(shortNumber(of(&Sample::cpuSeconds))) +
           numberCell(shortNumber(of(&Sample::renderSeconds))) +
           numberCell(shortNumber(meanSeconds(device, row) / meanSeconds(device, *plain))) +
           numberCell(shortNumber(of(&Sample::rays) /
                                  meanOf(*plain, [](const Sample& s) { return s.rays; }))) +
           numberCell(measuredText(row.relMse)) + ratioCell(varianceRatio(*plain, row)) +
           ratioCell(efficiency(device, *plain, row)) +
           numberCell(isPlain ? "–" : fixedNumber(100 * relativeBias(row), 2) + " %") +
           numberCell(std::isfinite(score) ? fixedNumber(score, 1) : "–",
                      std::abs(score) > kBiasScore) +
           numberCell(isPlain ? "–" : shortNumber(100 * of(&Sample::guidedShare), 2) + " %") +
           numberCell(isPlain ? "–" : shortNumber(of(&Sample::leaves))) +
           numberCell(isPlain ? "–" : shortNumber(1e-6 * of(&Sample::bytes), 2)) +
           numberCell(isPlain ? "–" : shortNumber(of(&Sample::guideSeconds), 2)) + "</tr>\n";
}

std::string rowsTable(const Results& r, const SceneResult& scene)
{
    std::string rows;
    for (const BenchDevice& device : r.devices)
        for (const Row& row : scene.rows)
            if (row.device == device.name) rows += tableRow(r, scene, row);
    return tableMarkup(
        "<th>device</th>" + numberHead("spp") + "<th>variant</th>" + numberHead("CPU s") +
            numberHead("render s") + numberHead("time / path") + numberHead("rays / path") +
            numberHead("relMSE") + numberHead("variance<br>ratio") + numberHead("efficiency") +
            numberHead("mean −<br>path’s") + numberHead("z") + numberHead("guided") +
            numberHead("leaves") + numberHead("MB") + numberHead("guide s"),
        rows);
}

std::string headOf(Family family)
{
    switch (family) {
    case Family::papers:
        return "Practical path guiding and its parts";
    case Family::training:
        return "Training with old records";
    case Family::combinations:
        return "Combinations of the iterations";
    case Family::depths:
        return "Trees of fixed depth";
    case Family::switches:
        break;
    }
    return {};
}

/// One table for each family of variants, and what follows from it.
std::string claimsMarkup(const Results& r, const SceneResult& scene)
{
    std::string html;
    for (const Claim& claim : claimsOf(r, scene)) {
        std::string rows;
        for (const Row* row : claim.rows) {
            const Row* plain = plainOf(scene, *row);
            rows += "<tr><td class=\"name\">" + escapeMarkup(row->variant) + "</td><td>" +
                    escapeMarkup(variantNamed(row->variant).help) + "</td>" +
                    numberCell(ratioText(varianceRatio(*plain, *row))) +
                    numberCell(ratioText(efficiency(deviceNamed(r, row->device), *plain, *row))) +
                    "</tr>\n";
        }
        html += "<h3>" + headOf(claim.family) + ", " + claim.device + ", " +
                std::to_string(claim.spp) + " spp</h3>\n" +
                tableMarkup("<th>variant</th><th>what it is</th>" +
                                numberHead("variance<br>ratio") + numberHead("efficiency"),
                            rows);
        if (!claim.sentence.empty()) html += paragraph(escapeMarkup(claim.sentence));
    }
    return html;
}

std::string arrivalsMarkup(const SceneResult& scene)
{
    std::string text;
    for (const Arrival& arrival : scene.arrivals)
        text += (text.empty() ? "While the camera moves every sample is the first of its view. " +
                                    std::to_string(arrival.before) +
                                    " such views in one place, then this one: "
                              : "; ") +
                arrivalText(arrival);
    if (std::ranges::any_of(scene.arrivals, &Arrival::window))
        text += ". In the window the camera rests for as many samples, orbits for a second and "
                "rests again";
    return text.empty() ? text : paragraph(escapeMarkup(text + '.'));
}

std::string shotsMarkup(const SceneResult& scene, const std::filesystem::path& folder)
{
    if (scene.shots.empty()) return {};
    std::string html = paragraph("One picture each with " + std::to_string(scene.shownSpp) +
                                 " samples per pixel (" + escapeMarkup(scene.shownDevice) + ").") +
                       "<div class=\"shots\">\n";
    for (const Shot& shot : scene.shots)
        html += "<figure>" + embeddedPng(folder / shot.file, scene.name + ": " + shot.name) +
                "<figcaption><b>" + escapeMarkup(shot.name) + "</b>" +
                (std::isnan(shot.relMse) ? ""
                                         : "<br>" + shortNumber(shot.seconds) + " s, relMSE " +
                                               shortNumber(shot.relMse)) +
                "</figcaption></figure>\n";
    return html + "</div>\n";
}

}  // namespace

std::string sceneMarkup(const Results& r, const SceneResult& scene,
                        const std::filesystem::path& folder)
{
    return paragraph(std::to_string(scene.size.x) + "×" + std::to_string(scene.size.y) + ", " +
                     std::to_string(scene.triangles) + " triangles. The reference has " +
                     std::to_string(scene.referenceSpp) + " samples per pixel and a relMSE of " +
                     shortNumber(scene.referenceRelMse) + " of its own, which is taken off.") +
           "<div class=\"pairoffigures\">\n" +
           curvesFigure("Error against time", "seconds", "relMSE", curvesOf(r, scene, false),
                        false) +
           curvesFigure("Efficiency against samples", "samples per pixel", "efficiency",
                        curvesOf(r, scene, true), true) +
           "</div>\n" + rowsTable(r, scene) + arrivalsMarkup(scene) + claimsMarkup(r, scene) +
           shotsMarkup(scene, folder);
}

}  // namespace app::guiding
