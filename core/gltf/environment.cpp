// Environment map and sun, as scenes[].extras.environment and .sun hold them (not part of glTF).
#include <cmath>

#include "core/base/progress.h"
#include "core/base/text.h"
#include "core/gltf/guard.h"
#include "core/gltf/parts.h"
#include "core/gltf/texture_image.h"

namespace core::gltf {

namespace {

void readMap(Load& load, const Object& object)
{
    const std::string uri = object.requiredString("uri");
    const std::string mapping = object.has("mapping") ? object.softString("mapping") : "latlong";
    if (mapping != "latlong")
        load.refuse("VALUE_NOT_IN_LIST", object.at("mapping"),
                    "is " + describe(mapping) + ", must be latlong");
    Content content = readUri(load, uri);
    if (!content.problem.empty())
        load.refuse("IO_ERROR", object.at("uri"), "environment: " + content.problem);
    load.hash.add(content.bytes);
    load.scene.fileBytes += content.bytes.size();
    ImageGuards guards;
    guards.maxSize = load.options.maxTextureSize;
    guards.beforeAllocation = [&](uint64_t pixels, uint64_t rawBytes) {
        load.reserveMemory(rawBytes + pixels * sizeof(glm::vec4), object.pointer());
    };
    const DecodedImage decoded = decodeImage(content.bytes, guards, load.stop);
    load.checkpoint();
    if (!decoded.problem.empty())
        load.refuse("IMAGE_UNUSABLE", object.at("uri"), "environment: " + decoded.problem);
    Environment environment;
    environment.file = printable(uri);
    environment.width = decoded.image.width;
    environment.height = decoded.image.height;
    uint64_t repaired = 0;
    environment.texels = makeRadiance(decoded.image, repaired);
    if (!decoded.damage.empty())
        load.warn("IMAGE_DAMAGED", object.at("uri"),
                  decoded.damage + " — shown as far as it could be read");
    if (repaired > 0)
        load.warn("IMAGE_INVALID_VALUES", object.at("uri"),
                  std::to_string(repaired) +
                      " values are negative, not finite or above 1e30 — replaced");
    environment.intensity = static_cast<float>(object.softNumber("intensity", 1, 0, kHuge));
    load.scene.environment = std::move(environment);
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
    const std::optional<Object> scene = shownScene(load);
    const std::optional<Object> extras = scene ? scene->softObject("extras") : std::nullopt;
    if (!extras) return;
    if (const std::optional<Object> map = extras->softObject("environment")) readMap(load, *map);
    if (const std::optional<Object> sun = extras->softObject("sun")) readSun(load, *sun);
}

}  // namespace core::gltf
