// Scenes of one kind of light each: punctual lights, sky and sun, and a scene that moves.
#include <cmath>

#include <glm/gtc/constants.hpp>

#include "assets/generator/materials.h"
#include "assets/generator/scenes.h"
#include "assets/generator/shapes.h"
#include "assets/generator/textures.h"

namespace assets {

namespace {

/// Quaternion (x, y, z, w) of a turn by `degrees` about a unit axis.
glm::vec4 turn(glm::dvec3 axis, double degrees)
{
    const double half = 0.5 * glm::radians(degrees);
    return {glm::vec3(std::sin(half) * axis), float(std::cos(half))};
}

void addLight(GltfWriter& gltf, const char* name, const Json& light, glm::vec3 position,
              glm::vec4 rotation)
{
    gltf.addNode({{"name", name},
                  {"translation", toJson(position)},
                  {"rotation", toJson(rotation)},
                  {"extensions", {{"KHR_lights_punctual", {{"light", gltf.addLight(light)}}}}}});
}

/// Lights shine along their node's -Z, so a turn of -90 degrees about X points them down.
void addPunctualLights(GltfWriter& gltf)
{
    const Json point = {{"type", "point"}, {"color", {1, 0.7, 0.4}}, {"intensity", 6}};
    const Json spot = {{"type", "spot"},
                       {"color", {0.4, 0.7, 1}},
                       {"intensity", 30},
                       {"spot", {{"innerConeAngle", 0.3}, {"outerConeAngle", 0.5}}}};
    const Json directional = {{"type", "directional"}, {"color", {1, 1, 0.9}}, {"intensity", 0.4}};
    addLight(gltf, "point", point, {-2, 1.2f, 0.5f}, {0, 0, 0, 1});
    addLight(gltf, "spot", spot, {0, 3, 0.8f}, turn({1, 0, 0}, -90));
    addLight(gltf, "directional", directional, {0, 5, 0}, turn({1, 0, 0}, -50));
}

/// The box turns about the vertical, evenly; the ball jumps along a smooth arc; the pillar changes
/// height in steps.
void addMotion(GltfWriter& gltf, int box, int ball, int pillar)
{
    std::vector<glm::vec4> turns;
    for (int key = 0; key <= 4; ++key) turns.push_back(turn({0, 1, 0}, 45.0 * key));
    gltf.addChannel(box, "rotation", "LINEAR", {0, 0.5f, 1, 1.5f, 2}, turns);
    // Per key: in-tangent, value, out-tangent (metres per second).
    const std::vector<glm::vec3> arc{{0, 0, 0},  {-1, 0.3f, 0}, {1, 3, 0},  //
                                     {1, 0, 0},  {0, 1.5f, 0},  {1, 0, 0},  //
                                     {1, -3, 0}, {1, 0.3f, 0},  {0, 0, 0}};
    gltf.addChannel(ball, "translation", "CUBICSPLINE", {0, 1, 2}, arc);
    const std::vector<glm::vec3> heights{{1, 1, 1}, {1, 2, 1}, {1, 0.5f, 1}};
    gltf.addChannel(pillar, "scale", "STEP", {0, 0.7f, 1.4f}, heights);
}

/// A quarter of a circle around the middle of the scene, always looking at it.
void addCameraMotion(GltfWriter& gltf, int camera)
{
    std::vector<float> times;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec4> rotations;
    for (int key = 0; key <= 8; ++key) {
        const double degrees = 90.0 * key / 8, angle = glm::radians(degrees);
        times.push_back(float(key) * 0.25f);
        positions.emplace_back(5 * std::sin(angle), 1, 5 * std::cos(angle));
        rotations.push_back(turn({0, 1, 0}, degrees));
    }
    gltf.addChannel(camera, "translation", "LINEAR", times, positions);
    gltf.addChannel(camera, "rotation", "LINEAR", times, rotations);
}

/// Blue above, brighter towards the horizon, dark ground; no sun: that comes as a light of its own.
glm::dvec3 skyRadiance(double, double v)
{
    if (v > 0.5) return {0.12, 0.1, 0.08};
    const double height = std::cos(glm::pi<double>() * v);
    return glm::mix(glm::dvec3(0.9, 0.95, 1.0), glm::dvec3(0.15, 0.3, 0.7), std::sqrt(height));
}

}  // namespace

void writeLights(const std::filesystem::path& folder)
{
    GltfWriter gltf("lights",
                    "point, spot and directional lights and a quadrilateral over a plane");
    const int floor = gltf.addMaterial(lambertian("floor", {0.5, 0.5, 0.5}));
    const int block = gltf.addMaterial(lambertian("block", {0.7, 0.6, 0.5}));
    gltf.addShape("floor", makeQuad({-4, 0, 4}, {8, 0, 0}, {0, 0, -8}), floor);
    gltf.addShape("left block", makeBox({-1.6f, 0, -0.5f}, {-1, 0.8f, 0.1f}, 20), block);
    gltf.addShape("right block", makeBox({0.9f, 0, -0.4f}, {1.5f, 0.6f, 0.2f}, -30), block);
    addPunctualLights(gltf);
    const int lamp = gltf.addMaterial(emitter("quad", {8, 4, 6}));
    gltf.addShape("quad", makeQuad({1.8f, 1.5f, -1.2f}, {0.8f, 0, 0}, {0, -0.4f, 0.6f}), lamp);
    gltf.addCamera({0, 2.6, 5.5}, {0, 0.4, 0}, 0.75, 16.0 / 9.0);
    gltf.save(folder);
}

void writeSky(const std::filesystem::path& folder)
{
    writeEnvironment(folder / "textures" / "sky.hdr", 32, 16, skyRadiance);
    GltfWriter gltf("sky", "environment map and sun");
    const int floor = gltf.addMaterial(lambertian("floor", {0.4, 0.38, 0.35}));
    gltf.addShape("floor", makeQuad({-10, 0, 10}, {20, 0, 0}, {0, 0, -20}), floor);
    const auto ball = [&](const char* name, float x, const Json& material) {
        gltf.addShape(name, makeSphere({x, 0.5f, 0}, 0.5f, 40, 20, true),
                      gltf.addMaterial(material));
    };
    ball("left ball", -1.2f, lambertian("diffuse", {0.7, 0.3, 0.2}));
    ball("middle ball", 0, glossy("plastic", {0.2, 0.4, 0.2}, 0.2));
    ball("right ball", 1.2f, glossy("metal", {0.9, 0.8, 0.7}, 0.3, 1));
    gltf.setExtra("environment",
                  {{"uri", "textures/sky.hdr"}, {"mapping", "latlong"}, {"intensity", 1.0}});
    // 0.53 degrees across; irradiance 3 is radiance times the solid angle of the disk.
    const double radius = 0.004625, solidAngle = glm::pi<double>() * radius * radius;
    const glm::dvec3 irradiance(3, 2.8, 2.4);
    gltf.setExtra("sun",
                  {{"directionTowardsSun", toJson(glm::normalize(glm::dvec3(0.5, 0.7, 0.4)))},
                   {"angularRadius", radius},
                   {"radiance", toJson(irradiance / solidAngle)},
                   {"irradiance", toJson(irradiance)}});
    gltf.addCamera({0, 1.3, 4.5}, {0, 0.5, 0}, 0.6, 16.0 / 9.0);
    gltf.save(folder);
}

void writeAnimated(const std::filesystem::path& folder)
{
    GltfWriter gltf("animated", "two seconds: nodes and the camera move, in every interpolation");
    const int floor = gltf.addMaterial(lambertian("floor", {0.6, 0.6, 0.6}));
    const int red = gltf.addMaterial(lambertian("red", {0.7, 0.2, 0.15}));
    const int blue = gltf.addMaterial(glossy("blue", {0.15, 0.3, 0.7}, 0.3));
    gltf.addShape("floor", makeQuad({-4, 0, 4}, {8, 0, 0}, {0, 0, -8}), floor);
    const int box = gltf.addShape("box", makeBox({-0.4f, 0, -0.4f}, {0.4f, 0.8f, 0.4f}), red);
    const int ball = gltf.addShape("ball", makeSphere({0, 0, 0}, 0.3f, 32, 16, true), blue);
    const int pillar = gltf.addShape("pillar", makeBox({1.4f, 0, -0.9f}, {1.7f, 0.8f, -0.6f}), red);
    const int lamp = gltf.addMaterial(emitter("lamp", {10, 10, 9}));
    gltf.addShape("lamp", makeQuad({-1, 3.5f, -1}, {2, 0, 0}, {0, 0, 2}), lamp);
    const int camera = gltf.addCamera({0, 1, 5}, {0, 1, 0}, 0.6, 16.0 / 9.0);
    addMotion(gltf, box, ball, pillar);
    addCameraMotion(gltf, camera);
    gltf.save(folder);
}

}  // namespace assets
