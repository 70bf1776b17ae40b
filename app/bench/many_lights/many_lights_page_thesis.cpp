// The thesis's tables beside ours. See many_lights_page_parts.h.
#include <cmath>

#include "app/bench/many_lights/many_lights_cases.h"
#include "app/bench/many_lights/many_lights_page_parts.h"
#include "app/bench/many_lights/many_lights_thesis.h"
#include "app/report/page.h"
#include "app/report/text.h"

namespace app::many_lights {

namespace {

using namespace report;

std::string timesText(double ratio)
{
    return std::isnan(ratio) ? "–" : std::isinf(ratio) ? "never" : shortNumber(ratio) + "×";
}

std::string ratioText(const SceneResult& scene, const std::string& method, const std::string& over,
                      uint32_t clusters, double (*number)(const Sample&))
{
    const Row *row = findRow(scene, method, clusters), *other = findRow(scene, over, clusters);
    return row == nullptr || other == nullptr ? "–" : spreadText(ratioOf(*row, *other, number));
}

/// BAMC over full sampling at equal clusters: the thesis's, ours ray by ray, in packets, and with
/// our completion.
std::string equalClusters(const Results& r)
{
    std::string rows;
    for (const SceneResult& scene : r.scenes) {
        const ThesisScene* thesis = thesisScene(scene.name);
        for (const uint32_t clusters : r.clusters) {
            if (findRow(scene, "full", clusters) == nullptr) continue;
            double time = kUnknown, rmse = kUnknown;
            for (size_t i = 0; thesis != nullptr && i < kThesisClusters.size(); ++i)
                if (kThesisClusters[i] == clusters) {
                    time = thesis->time[i];
                    rmse = thesis->rmse[i];
                }
            const auto cell = [&](const char* method, const char* over,
                                  double (*number)(const Sample&)) {
                return numberCell(ratioText(scene, method, over, clusters, number));
            };
            rows += "<tr><td>" + escapeMarkup(scene.name) + "</td>" +
                    numberCell(std::to_string(clusters)) + numberCell(shortNumber(time)) +
                    cell("thesis-single", "thesis-full-single", secondsOf) +
                    cell("thesis", "full", secondsOf) + cell("matching", "full", secondsOf) +
                    cell("matching", "full-single", secondsOf) + numberCell(shortNumber(rmse)) +
                    cell("thesis", "full", rmse8Of) + cell("matching", "full", rmse8Of) + "</tr>\n";
        }
    }
    return "<h3>BAMC over full sampling of as many clusters</h3>\n" +
           tableMarkup(
               "<th>scene</th>" + numberHead("clusters") + numberHead("time:<br>in the thesis") +
                   numberHead("its method,<br>ray by ray") + numberHead("its method,<br>packets") +
                   numberHead("matching,<br>packets") + numberHead("matching over<br>single rays") +
                   numberHead("8-bit RMSE:<br>in the thesis") + numberHead("its method") +
                   numberHead("matching"),
               rows);
}

double thesisTimes(const ThesisScene& scene, const std::string& method)
{
    if (method == "full" || method == "full-single") return scene.full;
    if (method == "lightslice") return scene.lightSlice;
    if (method == "matsep") return scene.matSep;
    return method == "illumination-cut" ? scene.illuminationCut : kUnknown;
}

/// Time for the error of BAMC with twice the main number of clusters.
std::string equalError(const Results& r)
{
    std::string rows;
    for (const SceneResult& scene : r.scenes) {
        const uint32_t twice = 2 * r.mainClusters;
        const uint32_t clusters =
            findRow(scene, "thesis", twice) != nullptr ? twice : r.mainClusters;
        const ThesisScene* thesis = thesisScene(scene.name);
        for (const Method& method : methodTable()) {
            const std::string name = method.name;
            if (!isCurve(method) || name == "thesis") continue;
            const Spread ours = equalErrorRatio(scene, name, clusters);
            if (ours.count == 0) continue;
            rows +=
                "<tr><td>" + escapeMarkup(scene.name) + "</td><td>" + escapeMarkup(name) + "</td>" +
                numberCell(std::to_string(clusters)) + numberCell(spreadText(ours)) +
                numberCell(timesText(thesis == nullptr ? kUnknown : thesisTimes(*thesis, name))) +
                "</tr>\n";
        }
    }
    return "<h3>Time to the error of BAMC, over its time</h3>\n" +
           paragraph(
               "How long each method needs for the 8-bit RMSE that <b>thesis</b> (in packets) "
               "reaches with so many clusters; between settings error is a power of time. "
               "The thesis's number is at 2000 clusters.") +
           "<details><summary>All scenes and methods</summary>\n" +
           tableMarkup("<th>scene</th><th>method</th>" + numberHead("BAMC's clusters") +
                           numberHead("ours") + numberHead("in the thesis"),
                       rows) +
           "</details>\n";
}

/// Time of AMC and elimination over BAMC at fixed rates.
std::string fixedRateTable(const Results& r)
{
    std::string head = "<th>scene</th><th>over BAMC</th>", rows;
    const std::vector<double> rates = fixedRates(r.quick);
    for (const double rate : rates) head += numberHead(shortNumber(100 * rate) + " %");
    for (const SceneResult& scene : r.scenes)
        for (const auto& [method, name] :
             {std::pair{"fixed-amc", "AMC"}, {"fixed-gauss-jordan", "GE"}}) {
            std::string cells;
            for (const double rate : rates) {
                const Row *row = findRow(scene, method, r.mainClusters, rate),
                          *bamc = findRow(scene, "fixed-matching", r.mainClusters, rate);
                if (row != nullptr && bamc != nullptr)
                    cells += numberCell(spreadText(ratioOf(*row, *bamc, secondsOf)));
            }
            if (!cells.empty())
                rows += "<tr><td>" + escapeMarkup(scene.name) + "</td><td>" + name + "</td>" +
                        cells + "</tr>\n";
        }
    if (rows.empty()) return {};
    for (const ThesisRates& thesis : thesisRates())
        for (const auto& [ratios, name] :
             {std::pair{&thesis.amc, "AMC"}, {&thesis.gaussJordan, "GE"}}) {
            rows += "<tr><td>thesis: " + std::string(thesis.scene) + "</td><td>" + name + "</td>";
            for (const double rate : rates)
                for (size_t i = 0; i < kThesisRates.size(); ++i)
                    if (kThesisRates[i] == rate) rows += numberCell(shortNumber((*ratios)[i]));
            rows += "</tr>\n";
        }
    return "<h3>Time at fixed rates of rows, over that of BAMC</h3>\n" + tableMarkup(head, rows);
}

}  // namespace

std::string thesisMarkup(const Results& r)
{
    return equalClusters(r) + equalError(r) + fixedRateTable(r);
}

}  // namespace app::many_lights
