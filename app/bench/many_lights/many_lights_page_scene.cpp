// Plots, tables and pictures of one scene. See many_lights_page_parts.h.
#include <algorithm>
#include <array>
#include <cmath>

#include "app/bench/many_lights/many_lights_cases.h"
#include "app/bench/many_lights/many_lights_page_parts.h"
#include "app/report/curves.h"
#include "app/report/page.h"
#include "app/report/pixels.h"
#include "app/report/text.h"

namespace app::many_lights {

namespace {

using namespace report;
using report::Curve;  // not the viewer's

using Place = Point (*)(const SceneResult&, const Row&);

Point timeAndError(const SceneResult&, const Row& row)
{
    return {spreadOf(row, secondsOf).median, spreadOf(row, rmse8Of).median};
}

Point clustersAndRatio(const SceneResult& scene, const Row& row)
{
    const Row* full = findRow(scene, "full", row.clusters);
    return {double(row.clusters),
            full == nullptr ? kUnknown : ratioOf(row, *full, secondsOf).median};
}

/// Methods over the numbers of clusters, or over the errors that they allow.
std::vector<Curve> curvesOf(const SceneResult& scene, Place place)
{
    std::vector<Curve> curves;
    for (const Method& method : methodTable()) {
        if (!isCurve(method)) continue;
        const Look look = lookOf(method.name);
        Curve curve{method.name, look.style, look.shape, {}};
        for (const Row& row : scene.rows)
            if (row.method == method.name && !row.samples.empty())
                curve.points.push_back(place(scene, row));
        if (!curve.points.empty()) curves.push_back(std::move(curve));
    }
    return curves;
}

struct Part {
    const char *name, *style;
    double Sample::*seconds;
};
constexpr std::array kParts{
    Part{"cut", "c-yellow", &Sample::cut}, Part{"order", "c-pink", &Sample::order},
    Part{"rays", "c-blue", &Sample::tracing}, Part{"matching", "c-green", &Sample::matching},
    Part{"shading", "c-orange", &Sample::shading}};

/// A bar for each method at the main number of clusters, of the parts of its time.
std::string splitBars(const Results& r, const SceneResult& scene)
{
    constexpr double kRow = 19, kNames = 150, kBars = 700, kTop = 26, kNumbers = 90;
    std::vector<const Row*> rows;
    double most = 0;
    for (const Row& row : scene.rows) {
        if (row.clusters != r.mainClusters || !std::isnan(row.rowRate)) continue;
        rows.push_back(&row);
        most = std::max(most, spreadOf(row, secondsOf).median);
    }
    if (rows.empty() || !(most > 0)) return {};
    Drawing drawing;
    double x = kNames;
    for (const Part& part : kParts) {
        drawing.rectangle({x, 4}, 11, 11, std::string("block ") + part.style);
        drawing.text({x + 15, 14}, part.name, "label");
        x += 95;
    }
    for (size_t i = 0; i < rows.size(); ++i) {
        const double y = kTop + kRow * double(i);
        drawing.text({kNames - 8, y + 12}, rows[i]->method, "label", Anchor::end);
        double left = kNames;
        for (const Part& part : kParts) {
            const double width = kBars * (middleSample(*rows[i]).*part.seconds) / most;
            drawing.rectangle({left, y}, width, kRow - 5, std::string("block ") + part.style);
            left += width;
        }
        drawing.text({left + 6, y + 12}, shortNumber(spreadOf(*rows[i], secondsOf).median) + " s",
                     "note");
    }
    return "<figure>" +
           drawing.element(kNames + kBars + kNumbers, kTop + kRow * double(rows.size()),
                           scene.name + ": parts of the time of each method") +
           "<figcaption>Seconds of a whole frame on all cores, " + std::to_string(r.mainClusters) +
           " clusters.</figcaption></figure>\n";
}

std::string ratioCell(const Row& row, const Row* other, double (*number)(const Sample&))
{
    return numberCell(other == nullptr ? "–" : spreadText(ratioOf(row, *other, number)));
}

}  // namespace

Look lookOf(const std::string& method)
{
    constexpr std::array kColours{"c-grey", "c-blue", "c-orange", "c-green",
                                  "c-pink", "c-red",  "c-sky",    "c-yellow"};
    constexpr std::array kShapes{Shape::circle, Shape::square, Shape::diamond, Shape::triangle};
    const std::string_view single = "-single";
    const bool dashed = std::string_view(method).ends_with(single);
    const std::string base = dashed ? method.substr(0, method.size() - single.size()) : method;
    size_t at = 0;
    for (const Method& m : methodTable()) {
        if (m.name == base) break;
        at += m.packets ? 1 : 0;
    }
    return {std::string(kColours[at % kColours.size()]) + (dashed ? " dashed" : ""),
            kShapes[at % kShapes.size()]};
}

std::string scenePlots(const Results& r, const SceneResult& scene)
{
    return "<div class=\"pairoffigures\">\n" +
           curvesFigure("Time against error", "seconds of a frame", "8-bit RMSE",
                        curvesOf(scene, timeAndError), false) +
           curvesFigure("Time over full sampling of as many clusters", "clusters", "time / full",
                        curvesOf(scene, clustersAndRatio), true) +
           "</div>\n" + splitBars(r, scene);
}

std::string sceneTable(const Results& r, const SceneResult& scene)
{
    std::string rows;
    for (const Row& row : scene.rows) {
        if (row.clusters != r.mainClusters || !std::isnan(row.rowRate)) continue;
        const Row *full = findRow(scene, "full", row.clusters),
                  *single = findRow(scene, "full-single", row.clusters);
        const auto median = [&row](auto&& number) { return spreadOf(row, number).median; };
        rows += "<tr><td class=\"name\"><span class=\"swatch " + lookOf(row.method).style +
                "\"></span>" + escapeMarkup(row.method) + "</td>" +
                numberCell(spreadText(spreadOf(row, secondsOf))) + ratioCell(row, full, secondsOf) +
                ratioCell(row, full, visibilitySecondsOf) + ratioCell(row, single, secondsOf) +
                numberCell(shortNumber(100 * median([](const Sample& s) { return s.visibility; })) +
                           " %") +
                numberCell(shortNumber(median(columnOverheadOf))) +
                numberCell(spreadText(spreadOf(row, rmse8Of))) + ratioCell(row, full, rmse8Of) +
                ratioCell(row, fullInSameSlices(scene, row), rmse8Of) +
                numberCell(shortNumber(median([](const Sample& s) { return s.toFull8; }))) +
                numberCell(shortNumber(median([](const Sample& s) { return s.rmse; }))) +
                numberCell(shortNumber(median([](const Sample& s) { return s.relMse; }))) +
                "</tr>\n";
    }
    return tableMarkup("<th>method</th>" + numberHead("seconds") + numberHead("time / full") +
                           numberHead("visibility / full") + numberHead("time / full, single") +
                           numberHead("rays") + numberHead("µs / column") +
                           numberHead("8-bit RMSE") + numberHead("RMSE / full") +
                           numberHead("same slices") + numberHead("to full") +
                           numberHead("HDR RMSE") + numberHead("HDR relMSE"),
                       rows);
}

std::string ratesTable(const SceneResult& scene)
{
    std::string rows;
    for (const Row& row : scene.rows) {
        if (row.method != "fixed-matching") continue;
        rows += "<tr>" + numberCell(shortNumber(100 * row.rowRate) + " %") +
                numberCell(std::to_string(row.clusters));
        for (const char* other : {"fixed-amc", "fixed-gauss-jordan"}) {
            const Row* compared = findRow(scene, other, row.clusters, row.rowRate);
            rows += compared == nullptr ? numberCell("–") + numberCell("–")
                                        : ratioCell(*compared, &row, secondsOf) +
                                              ratioCell(*compared, &row, rmse8Of);
        }
        rows += numberCell(shortNumber(spreadOf(row, secondsOf).median)) +
                numberCell(shortNumber(spreadOf(row, rmse8Of).median)) + "</tr>\n";
    }
    if (rows.empty()) return {};
    return "<h3>Fixed rates of rows, over BAMC</h3>\n" +
           tableMarkup(numberHead("rows") + numberHead("clusters") + numberHead("AMC, time") +
                           numberHead("AMC, RMSE") + numberHead("GE, time") +
                           numberHead("GE, RMSE") + numberHead("BAMC, s") +
                           numberHead("BAMC, RMSE"),
                       rows);
}

std::string shotsMarkup(const SceneResult& scene, const std::filesystem::path& folder)
{
    if (scene.shots.empty()) return {};
    std::string html =
        paragraph("A part of the frame, " + std::to_string(scene.shotSize.x) + "×" +
                  std::to_string(scene.shotSize.y) + " pixels from (" +
                  std::to_string(scene.shotCorner.x) + ", " + std::to_string(scene.shotCorner.y) +
                  "), around where completion differs most from full sampling; below each picture "
                  "its difference to all lights, eight times as strong, on grey.") +
        "<div class=\"shots\">\n";
    for (const Shot& shot : scene.shots) {
        html += "<figure>" + embeddedPng(folder / shot.file, scene.name + ": " + shot.name);
        if (!shot.difference.empty())
            html += embeddedPng(folder / shot.difference, "difference to all lights");
        html += "<figcaption><b>" +
                escapeMarkup(shot.name == "reference" ? "all lights" : shot.name) + "</b>" +
                (shot.difference.empty() ? "" : "<br>8-bit RMSE " + shortNumber(shot.rmse8)) +
                "</figcaption></figure>\n";
    }
    return html + "</div>\n";
}

}  // namespace app::many_lights
