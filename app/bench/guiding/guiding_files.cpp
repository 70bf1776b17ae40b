// See guiding_files.h.
#include "app/bench/guiding/guiding_files.h"

#include <numeric>

#include <nlohmann/json.hpp>

#include "app/bench/guiding/guiding_claims.h"
#include "app/bench/guiding/guiding_goals.h"
#include "app/files/params_json.h"
#include "app/files/stats.h"
#include "app/report/text.h"

namespace app::guiding {

namespace {

using report::padded, report::printed;
using Json = nlohmann::ordered_json;

/// Columns of JSON and CSV alike.
Json rowJson(const Results& r, const SceneResult& scene, const Row& row)
{
    const auto of = [&row](double Sample::*member) {
        return meanOf(row, [member](const Sample& s) { return s.*member; });
    };
    const Row* plain = plainOf(scene, row);
    const Ratio variance = varianceRatio(*plain, row),
                gain = efficiency(deviceNamed(r, row.device), *plain, row);
    const Spread errors = [&row] {
        std::vector<double> values;
        for (const Sample& s : row.samples) values.push_back(s.relMse);
        return spreadOf(values);
    }();
    return {{"scene", scene.name},
            {"variant", row.variant},
            {"device", row.device},
            {"spp", row.spp},
            {"seeds", row.samples.size()},
            {"cpu_seconds", of(&Sample::cpuSeconds)},
            {"render_seconds", of(&Sample::renderSeconds)},
            {"rays", of(&Sample::rays)},
            {"relmse", row.relMse.value},
            {"relmse_se", row.relMse.error},
            {"relmse_low", errors.low},
            {"relmse_high", errors.high},
            {"variance_ratio", variance.value},
            {"variance_ratio_low", variance.low},
            {"variance_ratio_high", variance.high},
            {"eff", gain.value},
            {"eff_low", gain.low},
            {"eff_high", gain.high},
            {"mean_ratio", 1 + relativeBias(row)},
            {"mean_z", biasScore(row)},
            {"guided_share", of(&Sample::guidedShare)},
            {"guide_leaves", of(&Sample::leaves)},
            {"guide_bytes", of(&Sample::bytes)},
            {"guide_seconds", of(&Sample::guideSeconds)}};
}

double meanOf(const std::vector<double>& values)
{
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

Json rowsJson(const Results& r)
{
    Json rows = Json::array();
    for (const SceneResult& scene : r.scenes)
        for (const Row& row : scene.rows) rows.push_back(rowJson(r, scene, row));
    return rows;
}

Json claimsJson(const Results& r, const SceneResult& scene)
{
    Json claims = Json::array();
    for (const Claim& claim : claimsOf(r, scene)) {
        Json rows = Json::array();
        for (const Row* row : claim.rows) {
            const Row* plain = plainOf(scene, *row);
            rows.push_back({{"variant", row->variant},
                            {"relmse", row->relMse.value},
                            {"variance_ratio", varianceRatio(*plain, *row).value},
                            {"eff", efficiency(deviceNamed(r, row->device), *plain, *row).value}});
        }
        claims.push_back({{"family", std::string(familyName(claim.family))},
                          {"device", claim.device},
                          {"spp", claim.spp},
                          {"rows", rows},
                          {"says", claim.sentence}});
    }
    return claims;
}

Json sceneJson(const Results& r, const SceneResult& s)
{
    Json pictures = Json::array();
    for (const Shot& shot : s.shots)
        pictures.push_back({{"name", shot.name},
                            {"relmse", shot.relMse},
                            {"seconds", shot.seconds},
                            {"file", shot.file.string()}});
    Json arrivals = Json::array();
    for (const Arrival& a : s.arrivals)
        arrivals.push_back({{"device", a.device},
                            {"window", a.window},
                            {"degrees", a.degrees},
                            {"views_before", a.before},
                            {"relmse_path", meanOf(a.plain)},
                            {"relmse_guided", meanOf(a.guided)},
                            {"relmse_path_median", spreadOf(a.plain).median},
                            {"relmse_guided_median", spreadOf(a.guided).median},
                            {"variance_ratio", varianceRatio(a).value}});
    return {{"scene", s.name},
            {"file", s.file.string()},
            {"triangles", s.triangles},
            {"size", {s.size.x, s.size.y}},
            {"reference_spp", s.referenceSpp},
            {"reference_relmse", s.referenceRelMse},
            {"reference_seconds", s.referenceSeconds},
            {"reference_kept", s.referenceKept},
            {"arrivals", arrivals},
            {"pictures", pictures},
            {"claims", claimsJson(r, s)}};
}

std::string sceneTable(const Results& r, const SceneResult& scene)
{
    std::string text = scene.name + ", " + std::to_string(scene.size.x) + 'x' +
                       std::to_string(scene.size.y) + ":\n" + padded("", 24) +
                       "spp   seconds    relMSE      variance  efficiency  guided %  mean z\n";
    for (const Row& row : scene.rows) {
        const Row* plain = plainOf(scene, row);
        const BenchDevice& device = deviceNamed(r, row.device);
        const double seconds = meanOf(row, [&](const Sample& s) { return secondsOf(device, s); });
        const double share = meanOf(row, [](const Sample& s) { return s.guidedShare; });
        text += "  " + padded(row.variant + ", " + row.device, 22) +
                padded(std::to_string(row.spp), 6) + padded(printed("%.3f", seconds), 11) +
                padded(printed("%.4g", row.relMse.value), 12) +
                padded(printed("%.2f", varianceRatio(*plain, row).value), 10) +
                padded(printed("%.2f", efficiency(device, *plain, row).value), 12) +
                padded(printed("%.0f", 100 * share), 10) + printed("%.1f", biasScore(row)) + '\n';
    }
    for (const Arrival& arrival : scene.arrivals) text += arrivalText(arrival) + '\n';
    for (const Claim& claim : claimsOf(r, scene))
        if (!claim.sentence.empty())
            text +=
                claim.device + ", " + std::to_string(claim.spp) + " spp: " + claim.sentence + '\n';
    return text;
}

}  // namespace

std::string resultsJson(const Results& r)
{
    Json json = runJson(r, "bench guiding"), scenes = Json::array(), goals = Json::array();
    for (const SceneResult& scene : r.scenes) scenes.push_back(sceneJson(r, scene));
    for (const Goal& goal : goalsOf(r))
        goals.push_back({{"goal", goal.text},
                         {"eff_least", goal.least},
                         {"eff", goal.measured.value},
                         {"where", goal.where},
                         {"verdict", verdictName(goal.verdict)}});
    json.update({{"seeds", r.seeds},
                 {"sweep", r.sweep},
                 {"params", paramsJson(r.params)},
                 {"scenes", scenes},
                 {"rows", rowsJson(r)},
                 {"goals", goals}});
    return jsonLines(json);
}

std::string rowsCsv(const Results& r)
{
    return csvLines(rowsJson(r));
}

std::string resultsTable(const Results& r)
{
    std::string text;
    for (const SceneResult& scene : r.scenes) text += sceneTable(r, scene);
    for (const Goal& goal : goalsOf(r))
        if (goal.verdict != Verdict::notMeasured)
            text += padded(std::string(verdictName(goal.verdict)) + ": ", 8) + goal.text + ": " +
                    printed("%.2f", goal.measured.value) + " (" + goal.where + "), wanted " +
                    printed("%.2f", goal.least) + '\n';
    return text;
}

}  // namespace app::guiding
