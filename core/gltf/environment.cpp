// Environment map and sun, as scenes[].extras.environment and .sun hold them (not part of glTF).
#include <algorithm>
#include <cmath>
#include <span>

#include "core/base/progress.h"
#include "core/base/text.h"
#include "core/gltf/guard.h"
#include "core/gltf/parts.h"
#include "core/gltf/texture_image.h"

namespace core::gltf {

namespace {

/// Decodes a panorama; `pointer` and `name` tell what it is.
Environment decodePanorama(Load& load, const Content& content, const std::string& pointer,
                           const std::string& name)
{
    if (!content.problem.empty())
        load.refuse("IO_ERROR", pointer, "environment: " + content.problem);
    load.hash.add(content.bytes);
    load.scene.fileBytes += content.bytes.size();
    ImageGuards guards;
    guards.maxSize = load.options.maxTextureSize;
    guards.beforeAllocation = [&](uint64_t pixels, uint64_t rawBytes) {
        load.reserveMemory(rawBytes + pixels * sizeof(glm::vec4), pointer);
    };
    const DecodedImage decoded = decodeImage(content.bytes, guards, load.stop);
    load.checkpoint();
    if (!decoded.problem.empty())
        load.refuse("IMAGE_UNUSABLE", pointer, "environment: " + decoded.problem);
    Environment environment;
    environment.file = printable(name);
    environment.width = decoded.image.width;
    environment.height = decoded.image.height;
    uint64_t repaired = 0;
    environment.texels = makeRadiance(decoded.image, repaired);
    if (!decoded.damage.empty())
        load.warn("IMAGE_DAMAGED", pointer, decoded.damage + " — shown as far as it could be read");
    if (repaired > 0)
        load.warn("IMAGE_INVALID_VALUES", pointer,
                  std::to_string(repaired) +
                      " values are negative, not finite or above 1e30 — replaced");
    return environment;
}

void readMap(Load& load, const Object& object)
{
    if (!object.has("uri"))  // of another tool: `extras` belong to nobody
        return load.warn("UNDEFINED_PROPERTY", object.pointer(),
                         "'uri' is missing — no environment");
    const std::string uri = object.requiredString("uri");
    const std::string mapping = object.has("mapping") ? object.softString("mapping") : "latlong";
    if (mapping != "latlong")
        load.refuse("VALUE_NOT_IN_LIST", object.at("mapping"),
                    "is " + describe(mapping) + ", must be latlong");
    Environment environment = decodePanorama(load, readUri(load, uri), object.at("uri"), uri);
    environment.intensity = static_cast<float>(object.softNumber("intensity", 1, 0, kHuge));
    load.scene.environment = std::move(environment);
}

bool shines(const glm::vec3& c)
{
    return c.x > 0 || c.y > 0 || c.z > 0;
}

/// Whether light comes from somewhere on a surface of this material: a pattern can take it all.
bool emits(const Scene& scene, const Material& material)
{
    const glm::vec3& emissive = material.data.emissive;
    if (!shines(emissive)) return false;
    const int use = material.textures[shared::kTextureEmissive];
    const int texture = use < 0 ? -1 : scene.textureUses[static_cast<size_t>(use)].texture;
    if (texture < 0) return true;
    // Half floats, none of them negative: but for the sign, the bits of zero alone are all 0.
    const auto lit = [&](const Texel& t) {
        return (emissive.x > 0 && (t.r & 0x7fffu) != 0) ||
               (emissive.y > 0 && (t.g & 0x7fffu) != 0) || (emissive.z > 0 && (t.b & 0x7fffu) != 0);
    };
    return std::ranges::any_of(scene.textures[static_cast<size_t>(texture)].texels, lit);
}

/// Whether every picture would be black. Unlit surfaces are seen without light. Of the materials
/// only those of triangles count: lines and points are not shown.
bool nothingShines(const Scene& scene)
{
    if (scene.environment && scene.environment->intensity > 0) return false;
    if (scene.sun && shines(scene.sun->radiance)) return false;
    std::vector<bool> seen(scene.materials.size(), false);
    for (const Mesh& mesh : scene.meshes)
        if (!mesh.triangles.empty()) seen[static_cast<size_t>(mesh.material)] = true;
    for (size_t i = 0; i < seen.size(); ++i) {
        const Material& material = scene.materials[i];
        const bool unlit = (material.data.flags & shared::kMaterialUnlit) != 0;
        if (seen[i] && (unlit || emits(scene, material))) return false;
    }
    for (const Node& node : scene.nodes)
        if (node.light >= 0) {
            const PunctualLight& light = scene.lights[static_cast<size_t>(node.light)];
            if (light.intensity > 0 && shines(light.color)) return false;
        }
    return true;
}

/// Without a sun, and lighter above, so that shapes are seen.
Environment plainSky()
{
    Environment sky;
    sky.file = kPlainSky;
    sky.width = 4;
    sky.height = 64;
    for (uint32_t row = 0; row < sky.height; ++row) {
        const float up = std::cos(3.14159265f * (float(row) + 0.5f) / float(sky.height));
        sky.texels.insert(sky.texels.end(), sky.width, glm::vec4(glm::vec3(0.65f + 0.35f * up), 1));
    }
    return sky;
}

/// What was asked for instead of the scene's own. The hash is that of what is shown, however it was
/// asked for.
void readAsked(Load& load)
{
    const std::string& asked = load.options.environment;
    const auto addToHash = [&load](std::string_view kind) {
        load.hash.add(std::as_bytes(std::span(kind)));
    };
    if (asked == kNoEnvironment) return addToHash(kNoEnvironment);
    if (asked == kAnyEnvironment || asked == kPlainSky) {
        addToHash(kPlainSky);
        load.scene.environment = plainSky();
        return;
    }
    addToHash("panorama");
    const Content content = readFile(asked, load.options.maxFileMb << 20);
    if (!content.problem.empty())
        load.refuse("IO_ERROR", "", "environment " + asked + ": " + content.problem,
                    "give the file of a panorama, or plain, none, own or auto");
    load.scene.environment = decodePanorama(load, content, "", asked);
}

void readSun(Load& load, const Object& object)
{
    constexpr double kHalfPi = 1.5707963267948966;
    const auto d = object.softNumbers<3>("directionTowardsSun", {0, 1, 0}, -1e6, 1e6);
    const glm::dvec3 direction(d[0], d[1], d[2]);
    if (!(glm::length(direction) > 1e-12)) {
        load.warn("VALUE_NOT_IN_RANGE", object.at("directionTowardsSun"),
                  "has no direction — no sun");
        return;
    }
    Sun sun;
    sun.directionTowards = glm::vec3(glm::normalize(direction));
    sun.angularRadius =
        static_cast<float>(object.softNumber("angularRadius", 0.004625, 1e-5, kHalfPi));
    const auto radiance = object.softNumbers<3>("radiance", {0, 0, 0}, 0, kHuge);
    sun.radiance = {radiance[0], radiance[1], radiance[2]};
    load.scene.sun = sun;
}

}  // namespace

void readEnvironment(Load& load)
{
    load.stage("environment", kUnknownShare);
    load.fileHash = load.hash;  // what is around the scene is no part of it
    const std::string& asked = load.options.environment;
    if (asked == kOwnEnvironment || asked == kAnyEnvironment) {
        const std::optional<Object> scene = shownScene(load);
        if (const auto extras = scene ? scene->extras() : std::nullopt) {
            if (const auto map = extras->softObject("environment")) readMap(load, *map);
            if (const auto sun = extras->softObject("sun")) readSun(load, *sun);
        }
        if (asked == kOwnEnvironment || !nothingShines(load.scene)) return;
        load.scene.sun.reset();
        load.scene.environment.reset();
    }
    readAsked(load);
}

}  // namespace core::gltf

namespace core {

bool isEnvironmentFile(const std::string& environment)
{
    for (const char* word : {kOwnEnvironment, kAnyEnvironment, kNoEnvironment, kPlainSky})
        if (environment == word) return false;
    return true;
}

}  // namespace core
