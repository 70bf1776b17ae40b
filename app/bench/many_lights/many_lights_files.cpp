// See many_lights_files.h.
#include "app/bench/many_lights/many_lights_files.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "app/bench/many_lights/many_lights_claims.h"
#include "app/files/params_json.h"
#include "app/files/stats.h"
#include "app/report/text.h"

namespace app::many_lights {

namespace {

using report::padded, report::printed;
using Json = nlohmann::ordered_json;

Json spreadJson(const Spread& s)
{
    return {s.low, s.median, s.high};
}

/// Over `full` and `full-single` of as many clusters; null without them.
Json ratiosJson(const SceneResult& scene, const Row& row)
{
    Json json = Json::object();
    const Row *full = findRow(scene, "full", row.clusters),
              *single = findRow(scene, "full-single", row.clusters);
    if (full != nullptr) {
        json["seconds_over_full"] = spreadJson(ratioOf(row, *full, secondsOf));
        json["visibility_seconds_over_full"] = spreadJson(ratioOf(row, *full, visibilitySecondsOf));
        json["rmse_8bit_over_full"] = spreadJson(ratioOf(row, *full, rmse8Of));
    }
    if (const Row* same = fullInSameSlices(scene, row))
        json["rmse_8bit_over_full_in_same_slices"] = spreadJson(ratioOf(row, *same, rmse8Of));
    if (single != nullptr)
        json["seconds_over_full_single"] = spreadJson(ratioOf(row, *single, secondsOf));
    return json;
}

template <class Number> double medianOf(const Row& row, Number&& number)
{
    return spreadOf(row, number).median;
}

Json rowJson(const SceneResult& scene, const Row& row)
{
    const auto of = [&row](double Sample::*member) {
        return medianOf(row, [member](const Sample& s) { return s.*member; });
    };
    const Sample middle = middleSample(row);
    Json json{{"scene", scene.name},
              {"method", row.method},
              {"lights", scene.lights},
              {"clusters", row.clusters},
              {"row_rate", row.rowRate},
              {"technique", core::enumName(row.params.technique)},
              {"error_allowed", double(row.params.error)},
              {"slice_size", row.params.sliceSize},
              {"packets", row.packets},
              {"repetitions", row.samples.size()},
              {"seconds", of(&Sample::seconds)},
              {"visibility_seconds", medianOf(row, visibilitySecondsOf)},
              {"rays", std::round(of(&Sample::rays))},
              {"visibility_percent", 100 * of(&Sample::visibility)},
              {"author_visibility_percent", 100 * of(&Sample::authorVisibility)},
              {"rmse_8bit", of(&Sample::rmse8)},
              {"rmse_hdr", of(&Sample::rmse)},
              {"relmse_hdr", of(&Sample::relMse)},
              {"rmse_8bit_to_full", of(&Sample::toFull8)},
              {"split_seconds",
               {{"cut", middle.cut},
                {"order", middle.order},
                {"rays", middle.tracing},
                {"matching", middle.matching},
                {"shading", middle.shading}}},
              {"column_overhead_us", of(&Sample::columnOverhead)},
              {"measured_wall_seconds", of(&Sample::wallSeconds)},
              {"measured_thread_seconds", of(&Sample::threadSeconds)}};
    json.update(ratiosJson(scene, row));
    json["spread"] = {{"seconds", spreadJson(spreadOf(row, secondsOf))},
                      {"rmse_8bit", spreadJson(spreadOf(row, rmse8Of))}};
    return json;
}

Json sceneJson(const SceneResult& s)
{
    Json pictures = Json::array();
    for (const Shot& shot : s.shots)
        pictures.push_back({{"name", shot.name},
                            {"rmse_8bit", shot.rmse8},
                            {"file", shot.file.string()},
                            {"difference", shot.difference.string()}});
    return {{"scene", s.name},
            {"file", s.file.string()},
            {"triangles", s.triangles},
            {"size", {s.size.x, s.size.y}},
            {"lights", s.lights},
            {"receivers", s.receivers},
            {"lit_receivers", s.litReceivers},
            {"slices", s.slices},
            {"lit_slices", s.litSlices},
            {"share", double(s.litReceivers) / double(s.receivers)},
            {"pixels", s.pixels},
            {"clamp_distance", s.clampDistance},
            {"seconds_lights", s.lightSeconds},
            {"seconds_tree", s.treeSeconds},
            {"seconds_receivers", s.receiverSeconds},
            {"reference_seconds", s.referenceSeconds},
            {"reference_kept", s.referenceKept},
            {"clipped_share", s.clipped},
            {"rays_per_thread_second",
             {{"full", s.rates.packets},
              {"full-single", s.rates.single},
              {"rtcOccluded16", s.rates.raw},
              {"full_over_raw", s.rates.ratio}}},
            {"pictures_at", {s.shotCorner.x, s.shotCorner.y}},
            {"pictures_size", {s.shotSize.x, s.shotSize.y}},
            {"pictures", pictures}};
}

Json claimJson(const Claim& claim)
{
    Json findings = Json::array();
    for (const Finding& f : claim.findings)
        findings.push_back({{"scene", f.scene},
                            {"what", f.what},
                            {"value", spreadJson(f.value)},
                            {"low", f.low},
                            {"high", f.high},
                            {"verdict", verdictName(verdictOf(f))}});
    return {{"claim", claim.name},
            {"text", claim.text},
            {"verdict", verdictName(verdictOf(claim))},
            {"findings", findings}};
}

std::string sceneLines(const Results& r, const SceneResult& scene)
{
    std::string text = scene.name + ", " + std::to_string(r.mainClusters) + " clusters of " +
                       std::to_string(scene.lights) + " lights, " +
                       std::to_string(scene.litReceivers) + " of " +
                       std::to_string(scene.receivers) + " receivers:\n" + padded("", 32) +
                       "time/full  time/single  rays %   us/column  RMSE 8 bit  RMSE/full  same "
                       "slices  RMSE HDR\n";
    for (const Row& row : scene.rows) {
        if (row.clusters != r.mainClusters) continue;
        const Row *full = findRow(scene, "full", row.clusters),
                  *single = findRow(scene, "full-single", row.clusters);
        const auto ratio = [&row](const Row* other, auto&& number) {
            return other == nullptr ? kUnknown : ratioOf(row, *other, number).median;
        };
        const std::string rate =
            std::isnan(row.rowRate) ? "" : printed(" %.3g %%", 100 * row.rowRate);
        text += "  " + padded(row.method + rate, 30) +
                padded(printed("%.3f", ratio(full, secondsOf)), 11) +
                padded(printed("%.3f", ratio(single, secondsOf)), 13) +
                padded(printed("%.1f",
                               100 * medianOf(row, [](const Sample& s) { return s.visibility; })),
                       9) +
                padded(printed("%.2f", medianOf(row, columnOverheadOf)), 11) +
                padded(printed("%.5f", medianOf(row, rmse8Of)), 12) +
                padded(printed("%.3f", ratio(full, rmse8Of)), 11) +
                padded(printed("%.3f", ratio(fullInSameSlices(scene, row), rmse8Of)), 13) +
                printed("%.3g", medianOf(row, [](const Sample& s) { return s.rmse; })) + '\n';
    }
    return text;
}

}  // namespace

std::string resultsJson(const Results& r)
{
    Json rows = Json::array(), scenes = Json::array(), claims = Json::array();
    for (const SceneResult& scene : r.scenes) {
        scenes.push_back(sceneJson(scene));
        for (const Row& row : scene.rows) rows.push_back(rowJson(scene, row));
    }
    for (const Claim& claim : claimsOf(r)) claims.push_back(claimJson(claim));
    return jsonLines({{"schema", 1},
                      {"command", "bench manylights"},
                      {"version", r.version},
                      {"commit", r.commit},
                      {"machine", r.machine},
                      {"cores", r.cores},
                      {"quick", r.quick},
                      {"interrupted", r.interrupted},
                      {"seconds", r.seconds},
                      {"repetitions", r.repetitions},
                      {"clusters", r.clusters},
                      {"main_clusters", r.mainClusters},
                      {"exposure", r.exposure},
                      {"params", paramsJson(r.params)},
                      {"scenes", scenes},
                      {"rows", rows},
                      {"claims", claims}});
}

std::string resultsTable(const Results& r)
{
    std::string text;
    for (const SceneResult& scene : r.scenes) text += sceneLines(r, scene);
    for (const Claim& claim : claimsOf(r))
        if (!claim.findings.empty())
            text +=
                padded(std::string(verdictName(verdictOf(claim))) + ": ", 13) + claim.text + '\n';
    return text;
}

}  // namespace app::many_lights
