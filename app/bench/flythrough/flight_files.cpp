// See flight_files.h.
#include "app/bench/flythrough/flight_files.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "app/base/read_value.h"
#include "app/files/params_json.h"
#include "app/files/stats.h"
#include "app/report/text.h"

namespace app::flight {

namespace {

using report::padded, report::printed;
using Json = nlohmann::ordered_json;

/// Columns of JSON and CSV alike.
Json rowJson(const std::string& scene, const Row& row)
{
    const PictureErrors& e = row.errors;
    return {{"scene", scene},
            {"strategy", row.strategy},
            {"n", row.samples},
            {"step", row.step},
            {"distance", row.distance},
            {"frame", row.frame},
            {"rays", row.rays},
            {"seconds", row.seconds},
            {"variance", e.variance},
            {"rmse", std::sqrt(std::max(0.0, e.mse.value))},
            {"relmse", e.relMse.value},
            {"relmse_se", e.relMse.error},
            {"mean_signed_error", e.signedError.value},
            {"mean_signed_error_se", e.signedError.error},
            {"relmse_trimmed", e.trimmed.value},
            {"pictures", e.pictures},
            {"relmse_ratio", row.ratio.value},
            {"relmse_ratio_se", row.ratio.error},
            {"mse_ratio", row.mseRatio},
            {"trimmed_ratio", row.trimmedRatio.value},
            {"trimmed_ratio_se", row.trimmedRatio.error},
            {"equal_time_ratio", row.timeRatio},
            {"equal_time_trimmed_ratio", row.trimmedTimeRatio}};
}

Json windowJson(const SceneResult& scene)
{
    Json rows = Json::array();
    for (const WindowRow& row : scene.window)
        rows.push_back({{"strategy", row.strategy},
                        {"paths", row.paths},
                        {"target_seconds", row.target},
                        {"picture_seconds", row.pictureSeconds},
                        {"scale", row.scale},
                        {"surface_scale", row.fineScale},
                        {"share", row.share},
                        {"relmse", row.errors.relMse.value},
                        {"relmse_se", row.errors.relMse.error},
                        {"relmse_trimmed", row.errors.trimmed.value},
                        {"mean_signed_error", row.errors.signedError.value},
                        {"mean_signed_error_se", row.errors.signedError.error},
                        {"pictures", row.errors.pictures},
                        {"relmse_ratio", row.ratio.value},
                        {"relmse_ratio_se", row.ratio.error},
                        {"trimmed_ratio", row.trimmedRatio.value},
                        {"trimmed_ratio_se", row.trimmedRatio.error},
                        {"shown_mse", row.shown.value},
                        {"shown_mse_ratio", row.shownRatio.value},
                        {"shown_mse_ratio_se", row.shownRatio.error},
                        {"under_way_mse", row.underWay.value},
                        {"under_way_mse_ratio", row.underWayRatio.value},
                        {"under_way_mse_ratio_se", row.underWayRatio.error},
                        {"shown_mse_by_size", row.bySize.value},
                        {"shown_mse_by_size_ratio", row.bySizeRatio.value}});
    return {{"speed", scene.windowSpeed},
            {"seconds", scene.windowSeconds},
            {"mean_reference", scene.windowRadiance},
            {"rows", rows}};
}

Json sceneJson(const SceneResult& scene)
{
    Json shots = Json::array();
    for (const Shot& shot : scene.shots)
        shots.push_back({{"name", shot.name},
                         {"n", shot.samples},
                         {"seconds", shot.seconds},
                         {"relmse", shot.relMse},
                         {"file", shot.file.string()},
                         {"part", shot.part.string()}});
    Json json{{"scene", scene.name},
              {"file", scene.file.string()},
              {"triangles", scene.triangles},
              {"size", {scene.size.x, scene.size.y}},
              {"way", scene.way},
              {"step_unit", scene.unit},
              {"mean_reference", scene.radiance},
              {"reference_relmse", scene.referenceRelMse},
              {"reference_seconds", scene.referenceSeconds},
              {"reference_kept", scene.referenceKept},
              {"shown_step", scene.shownStep},
              {"pictures", shots}};
    if (!scene.window.empty()) json["window"] = windowJson(scene);
    return json;
}

Json sweepJson(const Results& r, const SweepPoint& p)
{
    return {{"scene", r.sweptScene},
            {"strategy", r.sweptStrategy},
            {"parameter", p.parameter},
            {"value", p.value},
            {"step", p.step},
            {"frame", r.longest()},
            {"seconds", p.seconds},
            {"relmse", p.errors.relMse.value},
            {"relmse_ratio", p.ratio.value},
            {"relmse_ratio_se", p.ratio.error},
            {"trimmed_ratio", p.trimmedRatio.value},
            {"trimmed_ratio_se", p.trimmedRatio.error},
            {"mean_signed_error", p.errors.signedError.value},
            {"mean_signed_error_se", p.errors.signedError.error}};
}

}  // namespace

std::string resultsJson(const Results& r)
{
    Json rows = Json::array(), scenes = Json::array(), sweeps = Json::array(),
         leftOut = Json::object();
    for (const SceneResult& scene : r.scenes) {
        scenes.push_back(sceneJson(scene));
        for (const Row& row : scene.rows) rows.push_back(rowJson(scene.name, row));
        for (const Row& row : scene.atRest)
            if (row.samples > 1) rows.push_back(rowJson(scene.name, row));
    }
    for (const SweepPoint& point : r.sweeps) sweeps.push_back(sweepJson(r, point));
    for (const auto& [name, why] : r.leftOut) leftOut[name] = why;
    return jsonLines({{"schema", 1},
                      {"command", "bench flythrough"},
                      {"version", r.version},
                      {"commit", r.commit},
                      {"device", r.device},
                      {"driver", r.driver},
                      {"clock", r.clock},
                      {"quick", r.quick},
                      {"interrupted", r.interrupted},
                      {"seconds", r.seconds},
                      {"strategies", r.strategies},
                      {"left_out", leftOut},
                      {"steps", r.steps},
                      {"frames", r.frames},
                      {"seeds", r.seeds},
                      {"reference_spp", r.referenceSpp},
                      {"fps", r.framesPerSecond},
                      {"params", paramsJson(r.params)},
                      {"window_size", {r.windowSize.x, r.windowSize.y}},
                      {"scenes", scenes},
                      {"rows", rows},
                      {"sweeps", sweeps}});
}

std::string rowsCsv(const Results& r)
{
    Json rows = Json::array();
    for (const SceneResult& scene : r.scenes)
        for (const Row& row : scene.rows) rows.push_back(rowJson(scene.name, row));
    return csvLines(rows);
}

static std::string windowTable(const Results& r, const SceneResult& scene)
{
    std::string text =
        scene.name + ", in the window's loop, " + std::to_string(r.windowSize.x) + 'x' +
        std::to_string(r.windowSize.y) + ", " + numberText(scene.windowSpeed) + ' ' + scene.unit +
        " per second:\n" + padded("", 26) +
        "target ms  ms/picture  light  surfaces  relMSE/discard  no fireflies  as shown           "
        "under way         by size\n";
    for (const WindowRow& row : scene.window)
        text +=
            "  " +
            padded(row.strategy + (row.paths == 1 ? "" : ", rays " + printed("%g", row.paths)),
                   24) +
            padded(printed("%.0f", 1e3 * row.target), 11) +
            padded(printed("%.0f", 1e3 * row.pictureSeconds), 12) +
            padded(printed("%.2f", row.scale), 7) + padded(printed("%.2f", row.fineScale), 10) +
            padded(printed("%.3g", row.ratio.value) + printed(" +- %.2g", row.ratio.error), 16) +
            padded(printed("%.3g", row.trimmedRatio.value), 14) +
            padded(printed("%.3g", row.shownRatio.value) +
                       printed(" +- %.2g", row.shownRatio.error),
                   18) +
            padded(printed("%.3g", row.underWayRatio.value) +
                       printed(" +- %.2g", row.underWayRatio.error),
                   18) +
            printed("%.3g", row.bySizeRatio.value) + '\n';
    return text;
}

std::string resultsTable(const Results& r)
{
    std::string text;
    for (const SceneResult& scene : r.scenes) {
        const uint32_t frame = r.longest();
        text += scene.name + ", after " + std::to_string(frame) + " frames with steps of " +
                numberText(scene.shownStep) + ' ' + scene.unit + ":\n" + padded("", 26) +
                "relMSE/discard  no fireflies   at equal time  mean signed error    ms/frame\n";
        for (const std::string& strategy : r.strategies) {
            const Row* row = rowOf(scene, strategy, scene.shownStep, frame);
            if (row == nullptr) continue;
            const Measured& bias = row->errors.signedError;
            text += "  " + padded(strategy, 24) + padded(printed("%.3g", row->ratio.value), 16) +
                    padded(printed("%.3g", row->trimmedRatio.value), 15) +
                    padded(printed("%.3g", row->trimmedTimeRatio), 15) +
                    padded(printed("%+.2f %%", 100 * bias.value / scene.radiance) +
                               printed(" +- %.2f %%", 100 * bias.error / scene.radiance),
                           21) +
                    printed("%.3g", 1e3 * row->seconds) + '\n';
        }
        if (!scene.window.empty()) text += windowTable(r, scene);
    }
    return text;
}

}  // namespace app::flight
