// See many_lights_reference.h.
#include "app/bench/many_lights/many_lights_reference.h"

#include <nlohmann/json.hpp>

#include "app/bench/kept_reference.h"
#include "app/files/camera_file.h"

namespace app::many_lights {

namespace {

uint32_t hashOf(std::span<const uint8_t> places)
{
    uint32_t hash = 2166136261u;  // FNV-1a
    for (const uint8_t place : places) hash = (hash ^ place) * 16777619u;
    return hash;
}

std::string keyOf(const LitScene& scene, const Subset& subset, double at)
{
    const core::ManyLightsParams& p = scene.common();
    return referenceKey({{"scene", scene.world().scene->hash},
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

LightsReference referenceOf(const KeptReference& kept, const Subset& subset)
{
    LightsReference r{{}, kept.seconds, true};
    const core::Image& image = kept.image.layer("");
    for (const uint32_t pixel : subset.pixels) {
        const float* value = image.at(pixel % image.width, pixel / image.width);
        r.values.emplace_back(value[0], value[1], value[2]);
    }
    return r;
}

}  // namespace

std::optional<LightsReference> lightsReference(LitScene& scene, const Subset& subset, double at,
                                               const std::filesystem::path& file)
{
    const std::string key = keyOf(scene, subset, at);
    if (const auto kept = readReference(file, key, scene.size(), {""}))
        return referenceOf(*kept, subset);
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
    keepReference(file, key, {{"", image}}, lit->seconds);
    return LightsReference{std::move(lit->values), lit->seconds, false};
}

}  // namespace app::many_lights
