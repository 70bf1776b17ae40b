// See many_lights_reference.h.
#include "app/bench/many_lights_reference.h"

#include <nlohmann/json.hpp>

#include "app/base/json_file.h"
#include "app/base/program_version.h"
#include "app/base/read_value.h"
#include "app/files/camera_file.h"
#include "core/base/check.h"
#include "core/image/image.h"

namespace app::many_lights {

namespace {

namespace fs = std::filesystem;

constexpr const char* kKey = "rekindle:reference";  // of the metadata
constexpr const char* kSeconds = "rekindle:seconds";

uint32_t hashOf(std::span<const uint8_t> places)
{
    uint32_t hash = 2166136261u;  // FNV-1a
    for (const uint8_t place : places) hash = (hash ^ place) * 16777619u;
    return hash;
}

std::string keyOf(const LitScene& scene, const Subset& subset, double at)
{
    const core::ManyLightsParams& p = scene.common();
    return jsonText({{"version", kVersion},
                     {"commit", kCommit},
                     {"scene", scene.world().scene->hash},
                     {"at", at},
                     {"camera", cameraJson(scene.camera(), scene.world().placement)},
                     {"size", {scene.size().x, scene.size().y}},
                     {"lights", scene.lights()->set.lights.size()},
                     {"receivers", p.receivers},
                     {"slice-size", p.sliceSize},
                     {"clamp", p.clamp},
                     {"lost-light", std::string(core::enumName(p.lost))},
                     {"max-depth", p.maxDepth},
                     {"sampler", std::string(core::enumName(p.sampler))},
                     {"seed", p.seed},
                     {"places", hashOf(subset.places)}});
}

/// A file that cannot be read is no more than out of date.
std::optional<LightsReference> readKept(const fs::path& file, const std::string& key,
                                        const Subset& subset, glm::uvec2 size)
{
    std::error_code none;
    if (!fs::exists(file, none)) return {};
    try {
        const core::ImageFile kept = core::readExr(file);
        const auto found = kept.metadata.find(kKey);
        const core::Image& image = kept.layer("");
        if (found == kept.metadata.end() || found->second != key || image.width != size.x ||
            image.height != size.y || image.channels != 3)
            return {};
        LightsReference r{{}, 0, true};
        for (const uint32_t pixel : subset.pixels) {
            const float* value = image.at(pixel % size.x, pixel / size.x);
            r.values.emplace_back(value[0], value[1], value[2]);
        }
        const auto seconds = kept.metadata.find(kSeconds);
        if (seconds != kept.metadata.end()) readValue(seconds->second, {}, r.seconds);
        return r;
    } catch (const core::Error&) {
        return {};
    }
}

}  // namespace

std::optional<LightsReference> lightsReference(LitScene& scene, const Subset& subset, double at,
                                               const fs::path& file)
{
    const std::string key = keyOf(scene, subset, at);
    if (auto kept = readKept(file, key, subset, scene.size())) return kept;
    core::ManyLightsParams params = scene.common();
    params.clusters = static_cast<uint32_t>(scene.lights()->set.lights.size());
    params.completion = {.method = core::many_lights::CompletionMethod::full};
    auto lit = scene.light(params, true, scene.lights(), subset, params.seed);
    if (!lit) return {};
    core::Image image(scene.size().x, scene.size().y, 3);
    for (size_t i = 0; i < subset.pixels.size(); ++i)
        for (int c = 0; c < 3; ++c)
            image.at(subset.pixels[i] % image.width, subset.pixels[i] / image.width)[c] =
                lit->values[i][c];
    std::error_code error;
    fs::create_directories(file.parent_path(), error);
    core::writeExr(file, {{{"", image}}, {{kKey, key}, {kSeconds, numberText(lit->seconds)}}});
    return LightsReference{std::move(lit->values), lit->seconds, false};
}

}  // namespace app::many_lights
