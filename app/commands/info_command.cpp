// One table of facts, printed as text or JSON. See info_command.h.
#include "app/commands/info_command.h"

#include <array>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/base/log.h"
#include "app/files/camera_file.h"
#include "app/files/load.h"
#include "app/files/stats.h"
#include "core/base/text.h"
#include "core/scene/features.h"

namespace app {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 6> kEmitterNames{"triangles",   "points",       "spots",
                                                   "directional", "environments", "suns"};

// What trees and their building take per triangle at the peak, as scenes of 70 thousand to a
// million triangles showed.
constexpr double kHostBvhBytes = 100, kDeviceBvhBytes = 55;
constexpr double kHostInstanceBytes = 500, kDeviceInstanceBytes = 200;  // of a million

template <class T> double bytesOf(const core::SharedArray<T>& v)
{
    return static_cast<double>(v.size() * sizeof(T));
}

double megabytes(double bytes)
{
    return bytes / (1 << 20);
}

/// What renderers hold of the world, without their trees.
double worldBytes(const core::World& w)
{
    return bytesOf(w.positions) + bytesOf(w.attributes) + bytesOf(w.extra) + bytesOf(w.triangles) +
           bytesOf(w.instanceTable) + bytesOf(w.triangleEmitter) + bytesOf(w.materials) +
           bytesOf(w.textureReferences) + bytesOf(w.texels) + bytesOf(w.emitters) +
           bytesOf(w.emitterCdf) + bytesOf(w.emitterTree) + bytesOf(w.environment) +
           bytesOf(w.environmentCdf);
}

Json countsJson(const core::World& w)
{
    const core::Scene& scene = *w.scene;
    uint64_t instances = 0;
    for (const core::Node& node : scene.nodes) {
        const int places = node.placements;
        instances += node.meshes.size() *
                     (places < 0 ? 1 : scene.placements[static_cast<size_t>(places)].size());
    }
    return {{"triangles", core::shownTriangles(w)},
            {"stored_triangles", w.triangles.size()},
            {"kept_instances", w.instances.size()},
            {"vertices", w.positions.empty() ? 0 : w.positions.size() - 1},  // the last is padding
            {"nodes", scene.nodes.size()},
            {"instances", instances},
            {"meshes", scene.meshes.size()},
            {"materials", w.materials.size()},
            {"textures", scene.textures.size()},
            {"texels", w.texels.size()},
            {"texel_mb", megabytes(bytesOf(w.texels))},
            {"file_mb", megabytes(static_cast<double>(scene.fileBytes))}};
}

Json lightsJson(const core::World& w)
{
    std::array<uint64_t, kEmitterNames.size()> counts{};
    for (const shared::Emitter& emitter : w.emitters) ++counts.at(emitter.kind & 0xffu);
    Json json;
    for (size_t i = 0; i < counts.size(); ++i) json[kEmitterNames[i]] = counts[i];
    return json;
}

Json boundsJson(const core::World& w)
{
    return {{"low", vectorJson(w.placement.toFile(w.boundsLow))},
            {"high", vectorJson(w.placement.toFile(w.boundsHigh))}};
}

Json warningsJson(const core::Warnings& warnings)
{
    Json counts = Json::object(), listed = Json::array();
    for (const auto& count : warnings.counts) counts[count.code] = count.count;
    for (const core::Warning& w : warnings.listed)
        listed.push_back({{"code", w.code},
                          {"severity", "warning"},
                          {"pointer", w.pointer},
                          {"message", w.message}});
    return {{"total", warnings.total()}, {"counts", counts}, {"listed", listed}};
}

Json infoJson(const LoadedWorld& loaded)
{
    const core::World& w = *loaded.world;
    const core::Scene& scene = *w.scene;
    Json cameras = Json::array(), animations = Json::array();
    for (const core::Camera& camera : w.cameras) cameras.push_back(cameraJson(camera, w.placement));
    for (const core::Animation& animation : scene.animations)
        animations.push_back({{"name", animation.name},
                              {"seconds", animation.duration},
                              {"channels", animation.channels.size()}});
    const double triangles = static_cast<double>(w.triangles.size()), base = worldBytes(w);
    const double instances = static_cast<double>(w.instances.size());
    return {
        {"schema", 1},
        {"command", "info"},
        {"scene", scene.file.string()},
        {"name", scene.name},
        {"scene_hash", scene.hash},
        {"seconds", loaded.seconds},
        {"counts", countsJson(w)},
        {"lights", lightsJson(w)},
        {"cameras", cameras},
        {"animations", animations},
        {"bounds", boundsJson(w)},
        {"placement", {{"centre", vectorJson(w.placement.centre)}, {"scale", w.placement.scale}}},
        {"features",
         {{"used", core::featureList(w.features, true)},
          {"skipped", core::featureList(w.features, false)}}},
        {"memory_mb",
         {{"scene", megabytes(base)},
          {"cpu", megabytes(base + kHostBvhBytes * triangles + kHostInstanceBytes * instances)},
          {"vulkan",
           megabytes(base + kDeviceBvhBytes * triangles + kDeviceInstanceBytes * instances)}}},
        {"warnings", warningsJson(w.warnings)}};
}

std::string brief(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
}

std::string vectorText(const Json& v)
{
    return '(' + brief(v[0]) + ", " + brief(v[1]) + ", " + brief(v[2]) + ')';
}

std::string joined(const Json& names)
{
    std::string text;
    for (const auto& name : names) text += (text.empty() ? "" : ", ") + name.get<std::string>();
    return text.empty() ? "none" : text;
}

std::string cameraText(size_t index, const Json& camera)
{
    std::string text = std::to_string(index) + " \"" + camera.value("name", "") + "\" at " +
                       vectorText(camera["position"]) + " towards " + vectorText(camera["forward"]);
    text += camera.contains("yfov") ? ", " + brief(camera["yfov"]) + " degrees high"
                                    : ", orthographic, half height " + brief(camera["ymag"]);
    if (camera["aspect"].get<double>() > 0) text += ", aspect " + brief(camera["aspect"]);
    if (camera["aperture_radius"].get<double>() > 0)
        text += ", aperture " + brief(camera["aperture_radius"]) + ", focus at " +
                brief(camera["focus_distance"]);
    return text;
}

/// Counts that are not zero, as "2 triangles, 1 sun".
std::string lightsText(const Json& lights)
{
    std::string text;
    for (const auto& [name, count] : lights.items())
        if (count.get<uint64_t>() > 0)
            text += (text.empty() ? "" : ", ") + count.dump() + ' ' + name;
    return text.empty() ? "none" : text;
}

void printText(const Json& info, const core::Warnings& warnings, std::ostream& out)
{
    const auto row = [&out](const std::string& name, const std::string& text) {
        out << name << std::string(name.size() < 12 ? 12 - name.size() : 1, ' ')
            << core::printable(text) << '\n';
    };
    const Json& counts = info["counts"];
    row("scene", info["scene"].get<std::string>() + ", " + brief(counts["file_mb"]) +
                     " MiB, hash " + info["scene_hash"].get<std::string>() + ", loaded in " +
                     brief(info["seconds"]) + " s");
    row("geometry", counts["triangles"].dump() + " triangles, " + counts["vertices"].dump() +
                        " vertices, " + counts["instances"].dump() + " mesh instances on " +
                        counts["nodes"].dump() + " nodes");
    row("materials", counts["materials"].dump() + " materials, " + counts["textures"].dump() +
                         " textures, " + counts["texels"].dump() + " texels (" +
                         brief(counts["texel_mb"]) + " MiB)");
    row("lights", lightsText(info["lights"]));
    for (size_t i = 0; i < info["cameras"].size(); ++i)
        row(i == 0 ? "cameras" : "", cameraText(i, info["cameras"][i]));
    row("animations", info["animations"].empty() ? "none" : "");
    for (const auto& a : info["animations"])
        row("", '"' + a["name"].get<std::string>() + "\", " + brief(a["seconds"]) + " s, " +
                    a["channels"].dump() + " channels");
    row("bounds", vectorText(info["bounds"]["low"]) + " to " + vectorText(info["bounds"]["high"]));
    row("placement", "rendered at (file - " + vectorText(info["placement"]["centre"]) + ") * " +
                         brief(info["placement"]["scale"]));
    row("needs", joined(info["features"]["used"]));
    row("left out", joined(info["features"]["skipped"]));
    row("memory", "about " + brief(info["memory_mb"]["vulkan"]) + " MiB on a Vulkan device, " +
                      brief(info["memory_mb"]["cpu"]) + " MiB with --device cpu");
    const std::vector<std::string> lines = warningLines(warnings);
    row("warnings", lines.empty() ? "none" : std::to_string(warnings.total()));
    for (const std::string& line : lines) out << "  " << line << '\n';
}

}  // namespace

int infoCommand(const InfoOptions& options, std::ostream& out)
{
    Log log(false);
    SceneOptions scene = options.scene;  // what the file holds, unless told otherwise
    if (scene.load.environment == core::kAnyEnvironment)
        scene.load.environment = core::kOwnEnvironment;
    const LoadedWorld loaded = loadWorld(scene, 0, log.callback());
    const Json info = infoJson(loaded);
    if (options.json)
        out << jsonLines(info);
    else
        printText(info, loaded.world->warnings, out);
    return 0;
}

}  // namespace app
