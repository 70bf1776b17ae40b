// Cornell boxes of four glossinesses, and furnaces: scenes whose answer is known.
#include "assets/generator/materials.h"
#include "assets/generator/scenes.h"
#include "assets/generator/shapes.h"
#include "assets/generator/textures.h"

namespace assets {

namespace {

constexpr glm::dvec3 kWhite(0.725, 0.71, 0.68), kRed(0.63, 0.065, 0.05), kGreen(0.14, 0.45, 0.091);

enum class Lamp { facesDown, facesUp };

/// Two metres a side, open to +Z, lamp of 0.5 m x 0.4 m just below the ceiling. `roughness` 0 means
/// Lambertian. A lamp that faces up hangs lower, is white below, and lights nothing but the
/// ceiling: what is seen is indirect light.
void writeCornell(const std::filesystem::path& folder, const std::string& name, double roughness,
                  Lamp hangs = Lamp::facesDown)
{
    GltfWriter gltf(name, roughness > 0 ? "GGX on every surface; the tall box is metal"
                                        : "every surface is Lambertian");
    const auto surface = [&](const std::string& what, glm::dvec3 color, double metallic = 0) {
        return gltf.addMaterial(roughness > 0 ? glossy(what, color, roughness, metallic)
                                              : lambertian(what, color));
    };
    const int white = surface("white", kWhite), red = surface("red", kRed);
    const int green = surface("green", kGreen), tall = surface("tall", kWhite, 1);
    const bool up = hangs == Lamp::facesUp;
    const int lamp =
        gltf.addMaterial(emitter("lamp", {17, 12, 4}, up ? glm::dvec3(0.78) : glm::dvec3(0)));
    gltf.addShape("floor", makeQuad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}), white);
    gltf.addShape("ceiling", makeQuad({-1, 2, -1}, {2, 0, 0}, {0, 0, 2}), white);
    gltf.addShape("back wall", makeQuad({-1, 0, -1}, {2, 0, 0}, {0, 2, 0}), white);
    gltf.addShape("left wall", makeQuad({-1, 0, 1}, {0, 0, -2}, {0, 2, 0}), red);
    gltf.addShape("right wall", makeQuad({1, 0, -1}, {0, 0, 2}, {0, 2, 0}), green);
    gltf.addShape("short box", makeBox({0.05f, 0, 0.05f}, {0.65f, 0.6f, 0.65f}, -17), white);
    gltf.addShape("tall box", makeBox({-0.65f, 0, -0.6f}, {-0.05f, 1.2f, 0}, 18), tall);
    gltf.addShape("lamp",
                  up ? makeQuad({-0.25f, 1.717f, 0.2f}, {0.5f, 0, 0}, {0, 0, -0.4f})
                     : makeQuad({-0.25f, 1.98f, -0.2f}, {0.5f, 0, 0}, {0, 0, 0.4f}),
                  lamp);
    gltf.addCamera({0, 1, 3.7}, {0, 1, 0}, 0.7, 1);
    gltf.save(folder);
}

/// Every wall reflects `albedo` and emits 1: the radiance everywhere, in every direction, is 1 / (1
/// - albedo).
void writeFurnace(const std::filesystem::path& folder, const std::string& name, double albedo,
                  double answer)
{
    GltfWriter gltf(name, "closed box; radiance is 1 / (1 - albedo) everywhere");
    MeshData box = makeBox({-1, -1, -1}, {1, 1, 1}, 0, true);
    box.normals.clear();
    box.texCoords.clear();
    gltf.addShape("box", box, gltf.addMaterial(furnaceWall(albedo, 1)));
    gltf.addCamera({0.3, -0.2, 0.4}, {-1, 0.3, -1}, 0.9, 1);
    gltf.setExtra("expectedRadiance", answer);
    gltf.save(folder);
}

}  // namespace

void writeCornellBoxes(const std::filesystem::path& folder)
{
    writeCornell(folder, "cornell-diffuse", 0);
    writeCornell(folder, "cornell-rough", 0.7);
    writeCornell(folder, "cornell-moderate", 0.35);
    writeCornell(folder, "cornell-glossy", 0.12);
    writeCornell(folder, "cbox-up", 0, Lamp::facesUp);
}

void writeFurnaces(const std::filesystem::path& folder)
{
    writeFurnace(folder, "furnace-50", 0.5, 2);
    writeFurnace(folder, "furnace-80", 0.8, 5);

    // Convex and facetted without vertex normals: a facet sees nothing but the environment.
    GltfWriter gltf("furnace-sphere",
                    "white Lambertian sphere in environment 1: radiance 1 everywhere");
    const int white = gltf.addMaterial(lambertian("white", {1, 1, 1}));
    gltf.addShape("sphere", makeSphere({0, 0, 0}, 1, 32, 16, false), white);
    gltf.addCamera({0, 0, 3}, {0, 0, 0}, 0.75, 1);
    gltf.setExtra("environment",
                  {{"uri", "textures/one.hdr"}, {"mapping", "latlong"}, {"intensity", 1.0}});
    gltf.setExtra("expectedRadiance", 1.0);
    writeEnvironment(folder / "textures" / "one.hdr", 8, 4,
                     [](double, double) { return glm::dvec3(1); });
    gltf.save(folder);
}

}  // namespace assets
