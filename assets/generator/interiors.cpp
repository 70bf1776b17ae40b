// Interiors that are hard for one reason each: a thousand lamps; light that only enters through a
// door left ajar.
#include <array>
#include <string>
#include <vector>

#include "assets/generator/materials.h"
#include "assets/generator/scenes.h"
#include "assets/generator/shapes.h"

namespace assets {

namespace {

/// Uniform in [0, 1): a fixed sequence (Steele et al., "Fast Splittable Pseudorandom Number
/// Generators", 2014).
class Sequence {
public:
    float next()
    {
        state_ += 0x9e3779b97f4a7c15u;
        uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return float((z ^ (z >> 31)) >> 40) * 0x1p-24f;
    }

private:
    uint64_t state_ = 1;
};

constexpr float kColumnHalf = 0.4f;  // columns are turned by 45 degrees

/// Positions of the hall's columns on the floor.
std::vector<glm::vec2> columnPlaces()
{
    std::vector<glm::vec2> places;
    for (const float x : {-5.0f, 5.0f})
        for (int z = -12; z <= 12; z += 4) places.emplace_back(x, z);
    return places;
}

bool nearColumn(float x, float z)
{
    for (const glm::vec2& place : columnPlaces())
        if (glm::distance(place, glm::vec2(x, z)) < 2 * kColumnHalf) return true;
    return false;
}

/// Small lamps of six colours, instances of six meshes, scattered over a grid of 32 x 33 but for
/// the columns.
void addLamps(GltfWriter& gltf)
{
    constexpr std::array<glm::dvec3, 6> kColors{
        glm::dvec3(150, 120, 80), glm::dvec3(160, 70, 30), glm::dvec3(60, 110, 160),
        glm::dvec3(130, 40, 90),  glm::dvec3(60, 130, 60), glm::dvec3(120, 120, 120)};
    std::array<int, 6> meshes{};
    for (size_t i = 0; i < kColors.size(); ++i) {
        const std::string name = "lamp " + std::to_string(i);
        meshes[i] =
            gltf.addMesh(name, makeTetrahedron(0.06f), gltf.addMaterial(emitter(name, kColors[i])));
    }
    Sequence random;
    for (int row = 0; row < 33; ++row)
        for (int column = 0; column < 32; ++column) {
            const float x = -11.5f + 23.0f * (float(column) + 0.6f * random.next()) / 32.0f;
            const float z = -15.5f + 31.0f * (float(row) + 0.6f * random.next()) / 33.0f;
            const float y = 3.2f + 2.4f * random.next();
            const size_t mesh = size_t(6.0f * random.next());
            if (nearColumn(x, z)) continue;
            gltf.addNode({{"mesh", meshes[mesh]}, {"translation", toJson(glm::vec3(x, y, z))}});
        }
}

void addDoorRooms(GltfWriter& gltf)
{
    const int wall = gltf.addMaterial(lambertian("wall", {0.72, 0.7, 0.66}));
    const int floor = gltf.addMaterial(lambertian("floor", {0.45, 0.32, 0.2}));
    const int wood = gltf.addMaterial(glossy("wood", {0.5, 0.28, 0.12}, 0.3));
    MeshData room = makeBox({-3, 0, -5}, {3, 3, 5}, 0, true);
    gltf.addShape("room", room, wall);
    gltf.addShape("floor", makeQuad({-3, 0.001f, 5}, {6, 0, 0}, {0, 0, -10}), floor);
    // The wall between the rooms reaches into the outer walls, so that nothing shines past its
    // edges.
    MeshData divide = makeBox({-3.05f, -0.05f, -0.1f}, {0.2f, 3.05f, 0.1f});
    append(divide, makeBox({1.2f, -0.05f, -0.1f}, {3.05f, 3.05f, 0.1f}));
    append(divide, makeBox({0.2f, 2.1f, -0.1f}, {1.2f, 3.05f, 0.1f}));
    gltf.addShape("dividing wall", divide, wall);
    // Hinged at x = 1.2, opened by 25 degrees into the room of the camera (rotation about +Y, half
    // angle 12.5).
    gltf.addNode(
        {{"name", "door"},
         {"mesh", gltf.addMesh("door", makeBox({-1, 0.01f, -0.02f}, {0, 2.09f, 0.02f}), wood)},
         {"translation", toJson(glm::vec3(1.2f, 0, 0.12f))},
         {"rotation", toJson(glm::vec4(0, 0.21643961f, 0, 0.97629601f))}});
}

}  // namespace

void writeHall(const std::filesystem::path& folder)
{
    GltfWriter gltf("hall", "a thousand small lamps over a glossy floor");
    const int wall = gltf.addMaterial(lambertian("wall", {0.6, 0.58, 0.55}));
    const int floor = gltf.addMaterial(glossy("floor", {0.35, 0.33, 0.3}, 0.15));
    const int column = gltf.addMaterial(lambertian("column", {0.75, 0.72, 0.65}));
    gltf.addShape("walls", makeBox({-12, 0, -16}, {12, 6, 16}, 0, true), wall);
    gltf.addShape("floor", makeQuad({-12, 0.001f, 16}, {24, 0, 0}, {0, 0, -32}), floor);
    MeshData columns;
    for (const glm::vec2& place : columnPlaces())
        append(columns, makeBox({place.x - kColumnHalf, 0, place.y - kColumnHalf},
                                {place.x + kColumnHalf, 6, place.y + kColumnHalf}, 45));
    gltf.addShape("columns", columns, column);
    addLamps(gltf);
    gltf.addCamera({1.5, 1.7, 15}, {-0.5, 2, 0}, 0.9, 16.0 / 9.0);
    gltf.save(folder);
}

void writeDoorAjar(const std::filesystem::path& folder)
{
    // The lamp hangs above the door's opening and shines upward: nothing of it arrives without a
    // bounce.
    GltfWriter gltf("door-ajar", "the lamp shines at the ceiling of the other room");
    addDoorRooms(gltf);
    const int lamp = gltf.addMaterial(emitter("lamp", {1200, 1080, 880}));
    gltf.addShape("lamp", makeQuad({-0.4f, 2.3f, -2}, {0.8f, 0, 0}, {0, 0, -0.8f}), lamp);
    const int table = gltf.addMaterial(lambertian("table", {0.3, 0.25, 0.35}));
    gltf.addShape("table", makeBox({-2.2f, 0, 0.8f}, {-0.6f, 0.75f, 1.8f}), table);
    const int diffuse = gltf.addMaterial(lambertian("diffuse", {0.7, 0.4, 0.2}));
    const int shiny = gltf.addMaterial(glossy("shiny", {0.1, 0.3, 0.6}, 0.1));
    const int metal = gltf.addMaterial(glossy("metal", {0.9, 0.8, 0.6}, 0.2, 1));
    gltf.addShape("left ball", makeSphere({-1.9f, 0.95f, 1.3f}, 0.2f, 24, 12, true), diffuse);
    gltf.addShape("middle ball", makeSphere({-1.4f, 0.95f, 1.3f}, 0.2f, 24, 12, true), shiny);
    gltf.addShape("right ball", makeSphere({-0.9f, 0.95f, 1.3f}, 0.2f, 24, 12, true), metal);
    gltf.addCamera({-0.3, 1.5, 4.8}, {-0.1, 1.1, 0}, 0.75, 4.0 / 3.0);
    gltf.save(folder);
}

}  // namespace assets
