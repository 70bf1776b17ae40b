// Cameras and KHR_lights_punctual: faults are repaired, since a scene without them can still be
// shown.
#include <algorithm>
#include <numbers>

#include "core/gltf/parts.h"

namespace core::gltf {

namespace {

using std::numbers::pi;

/// A value that must be above zero (and at most `high`); otherwise a warning and `fallback`.
double positive(const Object& object, const char* key, double fallback, double high)
{
    Load& load = object.load();
    const std::optional<Json> value = object.find(key);
    if (!value) {
        load.warn("UNDEFINED_PROPERTY", object.pointer(),
                  std::string("'") + key + "' is missing — " + describe(fallback) + " instead");
        return fallback;
    }
    if (value->isNumber() && value->number() > 0 && value->number() <= high) return value->number();
    load.warn("VALUE_NOT_IN_RANGE", object.at(key),
              "is " + describe(*value) + ", must be above 0 and at most " + describe(high) + " — " +
                  describe(fallback) + " instead");
    return fallback;
}

/// A path tracer ignores clip planes, but a wrong one deserves a warning.
void checkClipPlanes(const Object& lens)
{
    const std::optional<Json> near = lens.find("znear"), far = lens.find("zfar");
    const bool wrong =
        (near && (!near->isNumber() || near->number() < 0)) ||
        (far && (!far->isNumber() || far->number() <= 0)) ||
        (near && far && near->isNumber() && far->isNumber() && far->number() <= near->number());
    const bool perspectiveAtZero =
        lens.has("yfov") && near && near->isNumber() && near->number() == 0;
    if (wrong || perspectiveAtZero)
        lens.load().warn("CAMERA_ZFAR_LEQUAL_ZNEAR", lens.pointer(),
                         "has clip planes that make no sense — clip planes are not used anyway");
}

SceneCamera readCamera(Load& load, const Object& object)
{
    constexpr double kMinFov = 1e-3, kMaxFov = 179.9 / 180 * pi, kDefaultFov = 0.9;
    SceneCamera camera;
    camera.name = object.name();
    const std::string type = object.softString("type");
    const std::optional<Object> lens =
        object.softObject(type == "orthographic" ? "orthographic" : "perspective");
    if (!lens || (type != "perspective" && type != "orthographic")) {
        load.warn("UNDEFINED_PROPERTY", object.pointer(),
                  "is neither a perspective nor an orthographic camera — a perspective of 0.9 rad "
                  "instead");
        return camera;
    }
    checkClipPlanes(*lens);
    if (type == "orthographic") {
        camera.orthographic = true;
        camera.ymag = positive(*lens, "ymag", 1, kHuge);
        const double xmag = positive(*lens, "xmag", camera.ymag, kHuge);
        camera.aspect = xmag / camera.ymag;
    } else {
        camera.yfov = positive(*lens, "yfov", kDefaultFov, kMaxFov);
        if (camera.yfov < kMinFov) {
            load.warn("VALUE_NOT_IN_RANGE", lens->at("yfov"), "is below 0.001 rad — clamped");
            camera.yfov = kMinFov;
        }
        if (lens->has("aspectRatio")) camera.aspect = positive(*lens, "aspectRatio", 0, 1e6);
    }
    if (const std::optional<Object> extras = object.extras()) {
        camera.apertureRadius = extras->softNumber("apertureRadius", 0, 0, kHuge);
        camera.focusDistance = extras->softNumber("focusDistance", 0, 0, kHuge);
    }
    return camera;
}

std::optional<PunctualLight> readLight(Load& load, const Object& object)
{
    PunctualLight light;
    light.name = object.name();
    const std::string type = object.softString("type");
    if (type == "point")
        light.kind = shared::kEmitterPoint;
    else if (type == "spot")
        light.kind = shared::kEmitterSpot;
    else if (type == "directional")
        light.kind = shared::kEmitterDirectional;
    else {
        load.warn("VALUE_NOT_IN_LIST", object.pointer(),
                  "is no point, spot or directional light — light skipped");
        return std::nullopt;
    }
    const auto color = object.softNumbers<3>("color", {1, 1, 1}, 0, kHuge);
    light.color = {color[0], color[1], color[2]};
    light.intensity = static_cast<float>(object.softNumber("intensity", 1, 0, kHuge));
    light.range = static_cast<float>(object.softNumber("range", 0, 0, kHuge));
    if (light.kind != shared::kEmitterSpot) return light;
    const std::optional<Object> spot = object.softObject("spot");
    if (!spot) {
        load.warn("UNDEFINED_PROPERTY", object.pointer(),
                  "'spot' is missing — a cone of 0 to 45 degrees instead");
        return light;
    }
    light.outerCone = static_cast<float>(spot->softNumber("outerConeAngle", pi / 4, 1e-4, pi / 2));
    const double inner = spot->softNumber("innerConeAngle", 0, 0, pi / 2);
    light.innerCone = static_cast<float>(inner);
    if (!(light.innerCone < light.outerCone)) {
        load.warn("KHR_LIGHTS_PUNCTUAL_LIGHT_SPOT_ANGLES", spot->pointer(),
                  "has an inner cone that is not inside the outer — made a little smaller");
        light.innerCone = light.outerCone * 0.999f;
    }
    return light;
}

}  // namespace

void readCameras(Load& load, const NodePlan& plan)
{
    const size_t count = countOf(load, "cameras");
    std::vector<SceneCamera> cameras;
    for (size_t i = 0; i < count; ++i)
        cameras.push_back(readCamera(load, topLevel(load, "cameras", i)));
    for (const NodeUse& use : plan.cameraUses) {
        Node& node = load.scene.nodes[static_cast<size_t>(use.node)];
        SceneCamera camera = cameras[use.index];
        camera.node = use.node;
        if (camera.name.empty()) camera.name = use.name;
        node.camera = static_cast<int>(load.scene.cameras.size());
        load.scene.cameras.push_back(std::move(camera));
    }
}

void readLights(Load& load, const NodePlan& plan)
{
    const Object root(load, load.document.root(), "");
    const std::optional<Object> extension = root.extension("KHR_lights_punctual");
    std::vector<int> sceneLight;  // per light of the document, -1: skipped
    if (extension && extension->has("lights")) {
        const std::optional<Json> list = extension->find("lights");
        if (!list->isArray())
            load.warn("TYPE_MISMATCH", extension->at("lights"),
                      "is " + describe(*list) + ", must be an array — ignored");
        else
            for (size_t i = 0; i < list->size(); ++i) {
                std::optional<PunctualLight> light;
                if ((*list)[i].isObject())
                    light = readLight(load, extension->element("lights", i));
                else
                    load.warn("TYPE_MISMATCH", child(extension->at("lights"), i),
                              "is " + describe((*list)[i]) + ", must be an object — light skipped");
                sceneLight.push_back(light ? static_cast<int>(load.scene.lights.size()) : -1);
                if (light) load.scene.lights.push_back(std::move(*light));
            }
    }
    for (const NodeUse& use : plan.lightUses)
        load.scene.nodes[static_cast<size_t>(use.node)].light = sceneLight[use.index];
}

}  // namespace core::gltf
