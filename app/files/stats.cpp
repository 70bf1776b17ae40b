// Statistics and metadata of a render. See stats.h.
#include "app/files/stats.h"

#include <algorithm>

#include <sys/resource.h>

#include "app/base/json_file.h"
#include "app/base/program_version.h"
#include "app/files/camera_file.h"
#include "app/files/params_json.h"
#include "core/methods/method.h"
#include "core/scene/features.h"

namespace app {

using Json = nlohmann::ordered_json;

double RenderReport::renderSeconds() const
{
    double sum = 0;
    for (const FrameReport& frame : frames) sum += frame.seconds;
    return sum;
}

uint64_t RenderReport::rays() const
{
    uint64_t sum = 0;
    for (const FrameReport& frame : frames) sum += frame.rays;
    return sum;
}

uint64_t RenderReport::paths() const
{
    uint64_t sum = 0;
    for (const FrameReport& frame : frames) sum += frame.paths;
    return sum;
}

bool noiseIsBound(const core::AnyParams& params)
{
    const auto* sampler = core::findParam<core::SamplerKind>(params, "sampler");
    return sampler != nullptr && *sampler == core::SamplerKind::sobol;
}

std::vector<std::pair<std::string, double>> mapMeans(core::Renderer& renderer,
                                                     std::string_view method)
{
    std::vector<std::pair<std::string, double>> means;
    const std::vector<core::Image> maps = renderer.maps();
    const auto infos = core::methodNamed(method).maps;
    for (size_t i = 0; i < maps.size(); ++i) {
        double sum = 0;
        for (const float x : maps[i].pixels) sum += static_cast<double>(x);
        const auto count = static_cast<double>(std::max<size_t>(maps[i].pixels.size(), 1));
        means.emplace_back(infos[i].name, sum / count);
    }
    return means;
}

double peakHostMb()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024;  // Linux counts in KiB
}

std::string jsonLines(const Json& json)
{
    std::string text = "{";
    for (const auto& [name, value] : json.items())
        text += (text.size() > 1 ? ",\n " : "\n ") + jsonText(name) + ": " + jsonText(value);
    return text + "\n}\n";
}

/// A text as a field of CSV: in quotes where it must be.
static std::string csvField(const std::string& text)
{
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + '"';
}

std::string csvLines(const Json& rows)
{
    std::string csv;
    for (const Json& row : rows) {
        std::string head, line;
        for (const auto& [key, value] : row.items()) {
            head += (head.empty() ? "" : ",") + key;
            if (!line.empty()) line += ',';
            line += value.is_string() ? csvField(value.get<std::string>()) : jsonText(value);
        }
        if (csv.empty()) csv = head + '\n';
        csv += line + '\n';
    }
    return csv;
}

static double perSecond(double count, double seconds)
{
    return seconds > 0 ? count / seconds : 0;
}

static Json secondsJson(const RenderReport& r)
{
    return {
        {"load", r.loadSeconds},
        {"build", r.buildSeconds},
        {"compile", r.renderer.compileSeconds},
        {"prepare", std::max(0.0, r.prepareSeconds - r.buildSeconds - r.renderer.compileSeconds)},
        {"render", r.renderSeconds()},
        {"readback", r.readbackSeconds},
        {"device", r.deviceSeconds},
        {"total", r.totalSeconds}};
}

static Json detailsJson(const std::vector<core::StatsDetail>& details)
{
    Json json = Json::object();
    for (const core::StatsDetail& detail : details)
        std::visit([&](const auto& value) { json[detail.name] = value; }, detail.value);
    return json;
}

static Json framesJson(const RenderReport& r)
{
    Json frames = Json::array();
    for (const FrameReport& frame : r.frames) {
        frames.push_back({{"index", frame.index},
                          {"seconds", frame.seconds},
                          {"rays", frame.rays},
                          {"paths", frame.paths},
                          {"spp", frame.spp}});
        if (!frame.details.empty()) frames.back()["method_stats"] = detailsJson(frame.details);
        for (const auto& [name, mean] : frame.means) frames.back()["map_means"][name] = mean;
    }
    return frames;
}

/// A parameter that most methods have, or what stands for its absence.
static uint32_t paramOr(const core::AnyParams& params, const char* name, uint32_t otherwise)
{
    const uint32_t* value = core::findParam<uint32_t>(params, name);
    return value != nullptr ? *value : otherwise;
}

std::string statsJson(const RenderReport& r)
{
    const RenderOptions& o = *r.options;
    uint64_t samples = 0;
    for (const FrameReport& frame : r.frames) samples += frame.spp;
    const double pixels = static_cast<double>(r.size.x) * r.size.y, seconds = r.renderSeconds();
    const core::FilmCounters& c = r.counters;
    const Json params = paramsJson(o.params);
    Json json{{"schema", 1},
              {"command", "render"},
              {"version", kVersion},
              {"commit", kCommit},
              {"scene", o.scene.file.string()},
              {"scene_hash", r.world->scene->hash},
              {"device", r.renderer.device},
              {"driver", r.renderer.driver},
              {"method", std::string(o.params.id())},
              {"reuse", params.value("reuse", "none")},
              {"size", {r.size.x, r.size.y}},
              {"spp", r.frames.empty() ? 0 : r.frames.back().spp},
              {"seed", paramOr(o.params, "seed", 0)},
              {"max_depth", paramOr(o.params, "max-depth", 0)},
              {"params", params},
              {"biased", biasedParams(o.params)},
              {"features",
               {{"used", core::featureList(r.world->features, true)},
                {"skipped", core::featureList(r.world->features, false)}}},
              {"camera", cameraJson(r.camera, r.world->placement)},
              {"triangles", core::shownTriangles(*r.world)},
              {"stored_triangles", r.world->triangles.size()},
              {"kept_instances", r.world->instances.size()},
              {"hierarchy_cached", r.renderer.hierarchyCached},
              {"ended", r.ended},
              {"seconds", secondsJson(r)},
              {"rays", r.rays()},
              {"paths", r.paths()},
              {"rays_per_second", perSecond(static_cast<double>(r.rays()), seconds)},
              {"samples_per_second", perSecond(pixels * static_cast<double>(samples), seconds)},
              {"peak_host_mb", peakHostMb()},
              {"peak_device_mb", static_cast<double>(r.renderer.peakDeviceBytes) / (1 << 20)},
              {"counters",
               {{"nan", c.nan},
                {"inf", c.inf},
                {"negative", c.negative},
                {"stack_overflow", c.stackOverflow}}},
              {"warnings", r.warnings},
              {"frames", framesJson(r)},
              {"method_stats", detailsJson(r.renderer.details)}};
    if (r.rmse) json["rmse"] = *r.rmse;
    if (r.referenceNoise) json["reference_noise"] = *r.referenceNoise;
    if (r.noise) {
        json["noise"] = *r.noise;
        json["noise_is_bound"] = noiseIsBound(o.params);
    }
    if (o.untilRmse) json["until_rmse"] = *o.untilRmse;
    if (o.untilNoise) json["until_noise"] = *o.untilNoise;
    if (o.budgetMs) json["budget_ms"] = *o.budgetMs;
    if (o.budgetRays) json["budget_rays"] = *o.budgetRays;
    if (o.budgetMs || o.budgetRays) json["over_budget"] = r.overBudget;
    if (o.validation) json["validation_messages"] = r.validationMessages;
    return jsonLines(json);
}

core::Metadata imageMetadata(const PictureFacts& f)
{
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, "%.3f", f.seconds);
    core::Metadata m{{"software", std::string("rekindle ") + kVersion},
                     {"commit", kCommit},
                     {"scene", f.scene.file.string()},
                     {"scene_hash", f.scene.world->scene->hash},
                     {"environment", f.scene.environment},
                     {"camera", jsonText(cameraJson(f.camera, f.scene.world->placement))},
                     {"width", std::to_string(f.size.x)},
                     {"height", std::to_string(f.size.y)},
                     {"spp", std::to_string(f.samples)},
                     {"seed", std::to_string(paramOr(f.params, "seed", 0))},
                     {"method", std::string(f.params.id())},
                     {"params", jsonText(paramsJson(f.params))},
                     {"device", f.device},
                     {"driver", f.driver},
                     {"seconds", seconds},
                     {"ended", f.ended}};
    if (f.follows) m["follows"] = "true";
    if (f.scene.time != 0) m["at"] = Json(f.scene.time).dump();
    const double laidOutAt = f.scene.world->laidOutAt;
    if (laidOutAt != f.scene.time) m["laid_out_at"] = Json(laidOutAt).dump();
    const std::vector<std::string> biased = biasedParams(f.params);
    if (!biased.empty()) m["biased"] = Json(biased).dump();
    return m;
}

core::Metadata imageMetadata(const RenderReport& r)
{
    const FrameReport frame = r.frames.empty() ? FrameReport{} : r.frames.back();
    return imageMetadata({.scene = {.file = r.options->scene.file,
                                    .world = r.world,
                                    .time = r.time,
                                    .environment = r.options->scene.load.environment},
                          .camera = r.camera,
                          .size = r.size,
                          .params = r.options->params,
                          .samples = frame.spp,
                          .seconds = frame.seconds,
                          .device = r.renderer.device,
                          .driver = r.renderer.driver,
                          .ended = r.ended,
                          .follows = frame.follows});
}

}  // namespace app
