// See light_files.h.
#include "app/bench/light/light_files.h"

#include <nlohmann/json.hpp>

#include "app/bench/pair_error.h"
#include "app/files/params_json.h"
#include "app/files/stats.h"
#include "app/report/text.h"

namespace app::light {

namespace {

using report::padded, report::printed;
using Json = nlohmann::ordered_json;

Spread spreadOfErrors(const Row& row)
{
    std::vector<double> values;
    for (const Sample& s : row.samples) values.push_back(s.relMse);
    return spreadOf(values);
}

/// Columns of JSON and CSV alike.
Json rowJson(const Results& r, const SceneResult& scene, const Row& row)
{
    const Row& plain = *plainOf(scene, row);
    const BenchDevice& device = deviceNamed(r, row.device);
    const Spread errors = spreadOfErrors(row);
    const Ratio error = errorRatio(plain, row, &Sample::relMse),
                gain = efficiency(device, plain, row, &Sample::relMse),
                trimmedGain = efficiency(device, plain, row, &Sample::trimmed);
    return {{"scene", scene.name},
            {"strategy", row.strategy},
            {"device", row.device},
            {"spp", row.spp},
            {"pairs", row.samples.size()},
            {"cpu_seconds", meanOf(row, &Sample::cpuSeconds)},
            {"render_seconds", meanOf(row, &Sample::renderSeconds)},
            {"build_seconds", row.buildSeconds},
            {"rays", meanOf(row, &Sample::rays)},
            {"relmse", meanOf(row, &Sample::relMse)},
            {"relmse_low", errors.low},
            {"relmse_high", errors.high},
            {"relmse_trimmed", meanOf(row, &Sample::trimmed)},
            {"time_ratio", timeRatio(device, plain, row).value},
            {"error_ratio", error.value},
            {"error_ratio_trimmed", errorRatio(plain, row, &Sample::trimmed).value},
            {"eff", gain.value},
            {"eff_low", gain.low},
            {"eff_high", gain.high},
            {"eff_trimmed", trimmedGain.value},
            {"eff_trimmed_low", trimmedGain.low},
            {"eff_trimmed_high", trimmedGain.high},
            {"mean_ratio", 1 + relativeBias(row)},
            {"mean_z", biasScore(row)}};
}

Json rowsJson(const Results& r)
{
    Json rows = Json::array();
    for (const SceneResult& scene : r.scenes)
        for (const Row& row : scene.rows) rows.push_back(rowJson(r, scene, row));
    return rows;
}

Json sceneJson(const SceneResult& s)
{
    return {{"scene", s.name},
            {"file", s.file.string()},
            {"triangles", s.triangles},
            {"emitters", s.emitters},
            {"has_tree", s.hasTree},
            {"chooses_by_tree", s.choosesByTree},
            {"size", {s.size.x, s.size.y}},
            {"load_seconds", s.loadSeconds}};
}

std::string sceneTable(const Results& r, const SceneResult& scene)
{
    std::string text = scene.name + ", " + std::to_string(scene.size.x) + 'x' +
                       std::to_string(scene.size.y) + ", " +
                       report::counted(scene.emitters, "emitter") + ", chosen by " +
                       (scene.choosesByTree ? "tree" : "power") + ":\n" + padded("", 18) +
                       "spp   seconds  x time  relMSE      trimmed     efficiency  trimmed  "
                       "mean z\n";
    for (const Row& row : scene.rows) {
        const Row& plain = *plainOf(scene, row);
        const BenchDevice& device = deviceNamed(r, row.device);
        const auto gain = [&](double Sample::*error) {
            return printed("%.2f", efficiency(device, plain, row, error).value);
        };
        text += "  " + padded(row.strategy + ", " + row.device, 16) +
                padded(std::to_string(row.spp), 6) +
                padded(printed("%.3f", meanSeconds(device, row)), 9) +
                padded(printed("%.2f", timeRatio(device, plain, row).value), 8) +
                padded(printed("%.4g", meanOf(row, &Sample::relMse)), 12) +
                padded(printed("%.4g", meanOf(row, &Sample::trimmed)), 12) +
                padded(gain(&Sample::relMse), 12) + padded(gain(&Sample::trimmed), 9) +
                printed("%.1f", biasScore(row)) + '\n';
    }
    return text;
}

}  // namespace

std::string resultsJson(const Results& r)
{
    Json json = runJson(r, "bench light"), scenes = Json::array();
    for (const SceneResult& scene : r.scenes) scenes.push_back(sceneJson(scene));
    json.update({{"pairs", r.pairs},
                 {"params", paramsJson(r.params)},
                 {"scenes", scenes},
                 {"rows", rowsJson(r)}});
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
    return text;
}

}  // namespace app::light
