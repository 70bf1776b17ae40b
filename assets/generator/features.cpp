// Scenes that use one family of material features each: textures, and everything that light passes
// through.
#include "assets/generator/materials.h"
#include "assets/generator/scenes.h"
#include "assets/generator/shapes.h"

namespace assets {

namespace {

constexpr int kRepeat = 10497, kClamp = 33071, kMirror = 33648;
constexpr int kNearest = 9728, kLinear = 9729;

int addTexture(GltfWriter& gltf, const std::string& file, int wrapS, int wrapT,
               int filter = kLinear)
{
    return gltf.addTexture(
        "textures/" + file,
        {{"magFilter", filter}, {"minFilter", filter}, {"wrapS", wrapS}, {"wrapT", wrapT}});
}

/// Lambertian with a base colour texture.
Json textured(const std::string& name, const Json& texture)
{
    Json material = lambertian(name, {1, 1, 1});
    material["pbrMetallicRoughness"]["baseColorTexture"] = texture;
    return material;
}

/// Texture coordinates from `low` to `high` instead of 0 to 1.
MeshData withCoordinates(MeshData mesh, float low, float high)
{
    for (glm::vec2& uv : mesh.texCoords) uv = low + (high - low) * uv;
    return mesh;
}

/// Bumpy floor whose pattern is scaled, turned and moved; no tangents, so that they have to be
/// derived.
void addFloor(GltfWriter& gltf)
{
    Json pattern = textureInfo(addTexture(gltf, "checker.png", kRepeat, kRepeat, kNearest));
    pattern["extensions"]["KHR_texture_transform"] = {
        {"offset", {0.1, 0.2}}, {"rotation", 0.3}, {"scale", {4, 4}}};
    Json material = glossy("floor", {1, 1, 1}, 0.4);
    material["pbrMetallicRoughness"]["baseColorTexture"] = pattern;
    material["normalTexture"] = textureInfo(addTexture(gltf, "bumps.png", kRepeat, kRepeat));
    material["normalTexture"]["scale"] = 0.7;
    gltf.addShape("floor", makeQuad({-2, 0, 2}, {4, 0, 0}, {0, 0, -4}), gltf.addMaterial(material));
}

/// Three panels on the back wall: repeated, clamped and mirrored; and one read by its second
/// coordinates.
void addPanels(GltfWriter& gltf)
{
    constexpr glm::vec3 kAcross(0.8f, 0, 0), kUp(0, 0.8f, 0);
    float x = -1.9f;
    for (const int wrap : {kRepeat, kClamp, kMirror}) {
        const int texture = addTexture(gltf, "grid.png", wrap, wrap);
        const MeshData panel =
            withCoordinates(makeQuad({x, 1.6f, -1.95f}, kAcross, kUp), -0.5f, 1.5f);
        gltf.addShape("panel", panel, gltf.addMaterial(textured("panel", textureInfo(texture))));
        x += 1.0f;
    }
    Json second = textureInfo(addTexture(gltf, "grid.png", kRepeat, kMirror));
    second["texCoord"] = 1;
    MeshData panel = makeQuad({1.1f, 1.6f, -1.95f}, kAcross, kUp);
    panel.texCoords1 = {{2, 0}, {2, 2}, {0, 2}, {0, 0}};  // turned by a quarter, twice
    gltf.addShape("second coordinates", panel, gltf.addMaterial(textured("second", second)));
}

/// Normal map with explicit tangents (mirrored: handedness -1) and a map of roughness and metal.
void addMappedPanel(GltfWriter& gltf)
{
    Json material = glossy("mapped", {0.9, 0.7, 0.5}, 1, 1);
    material["normalTexture"] = textureInfo(addTexture(gltf, "bumps.png", kRepeat, kRepeat));
    material["pbrMetallicRoughness"]["metallicRoughnessTexture"] =
        textureInfo(addTexture(gltf, "rough.png", kClamp, kClamp));
    MeshData panel = makeQuad({-1.9f, 0.5f, -1.95f}, {0.8f, 0, 0}, {0, 0.8f, 0});
    panel.texCoords = {{1, 1}, {0, 1}, {0, 0}, {1, 0}};
    panel.tangents.assign(4, {-1, 0, 0, -1});
    gltf.addShape("mapped panel", panel, gltf.addMaterial(material));
}

/// Alpha: masked leaves, and a pane that lets 60 % through.
void addAlpha(GltfWriter& gltf)
{
    Json material = textured("leaf", textureInfo(addTexture(gltf, "leaf.png", kClamp, kClamp)));
    material["alphaMode"] = "MASK";
    material["alphaCutoff"] = 0.5;
    const int leaf = gltf.addMesh("leaf", makeQuad({-0.3f, 0, 0}, {0.6f, 0, 0}, {0, 0.9f, 0}),
                                  gltf.addMaterial(material));
    // Rotations about +Y by 0, 60 and 120 degrees.
    for (const glm::vec4 turn : {glm::vec4(0, 0, 0, 1), glm::vec4(0, 0.5f, 0, 0.8660254f),
                                 glm::vec4(0, 0.8660254f, 0, 0.5f)})
        gltf.addNode({{"name", "leaf"},
                      {"mesh", leaf},
                      {"translation", {-0.2, 0, 0.2}},
                      {"rotation", toJson(turn)}});
    Json pane = lambertian("pane", {0.2, 0.4, 0.8});
    pane["pbrMetallicRoughness"]["baseColorFactor"][3] = 0.4;
    pane["alphaMode"] = "BLEND";
    gltf.addShape("pane", makeQuad({0.4f, 0.05f, 1}, {0.7f, 0, 0}, {0, 0.8f, 0}),
                  gltf.addMaterial(pane));
}

/// Left wall with a colour at each vertex; panel on the right wall that shines through a texture.
void addColorAndGlow(GltfWriter& gltf)
{
    MeshData wall = makeQuad({-2, 0, 2}, {0, 0, -4}, {0, 3, 0});
    wall.colors = {{230, 60, 40, 255}, {60, 200, 60, 255}, {50, 80, 230, 255}, {220, 200, 60, 255}};
    gltf.addShape("left wall", wall,
                  gltf.addMaterial(lambertian("vertex colours", {0.9, 0.9, 0.9})));
    Json glow = emitter("glow", {3, 3, 3});
    glow["emissiveTexture"] = textureInfo(addTexture(gltf, "grid.png", kRepeat, kRepeat));
    gltf.addShape("glow", makeQuad({1.98f, 0.8f, -1}, {0, 0, 1.5f}, {0, 1.5f, 0}),
                  gltf.addMaterial(glow));
}

void addGlassObjects(GltfWriter& gltf)
{
    const auto transmissive = [](const std::string& name, double roughness) {
        Json material = glossy(name, {1, 1, 1}, roughness);
        material["extensions"]["KHR_materials_transmission"] = {{"transmissionFactor", 1}};
        material["extensions"]["KHR_materials_ior"] = {{"ior", 1.5}};
        return material;
    };
    Json solid = transmissive("green glass", 0);
    solid["doubleSided"] = false;
    solid["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 1},
                                                   {"attenuationDistance", 0.5},
                                                   {"attenuationColor", {0.5, 0.9, 0.6}}};
    Json rough = transmissive("rough glass", 0.3);
    rough["doubleSided"] = false;
    rough["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 1}};
    Json coated = glossy("coated", {0.6, 0.05, 0.04}, 0.6);
    coated["extensions"]["KHR_materials_clearcoat"] = {{"clearcoatFactor", 1},
                                                       {"clearcoatRoughnessFactor", 0.05}};
    Json tinted = glossy("tinted", {0.1, 0.1, 0.12}, 0.25);
    tinted["extensions"]["KHR_materials_specular"] = {{"specularFactor", 1},
                                                      {"specularColorFactor", {1, 0.6, 0.2}}};
    const auto ball = [&](const char* name, glm::vec3 centre, const Json& material) {
        gltf.addShape(name, makeSphere(centre, 0.4f, 40, 20, true), gltf.addMaterial(material));
    };
    ball("glass ball", {-1.1f, 0.42f, 0.3f}, solid);
    ball("rough glass ball", {-0.1f, 0.42f, -0.4f}, rough);
    ball("coated ball", {0.9f, 0.4f, 0.3f}, coated);
    ball("tinted ball", {1.5f, 0.4f, -0.8f}, tinted);
    ball("mirror ball", {-1.6f, 0.4f, -0.9f}, glossy("mirror", {0.95, 0.93, 0.88}, 0, 1));
    gltf.addShape("thin pane", makeQuad({0, 0.02f, 1}, {0.9f, 0, -0.4f}, {0, 0.9f, 0}),
                  gltf.addMaterial(transmissive("pane", 0)));
}

}  // namespace

void writeTextured(const std::filesystem::path& folder)
{
    GltfWriter gltf("textured-box", "texture transforms, wrapping, maps, alpha, vertex colours");
    const int white = gltf.addMaterial(lambertian("white", {0.75, 0.75, 0.75}));
    gltf.addShape("back wall", makeQuad({-2, 0, -2}, {4, 0, 0}, {0, 3, 0}), white);
    gltf.addShape("right wall", makeQuad({2, 0, -2}, {0, 0, 4}, {0, 3, 0}), white);
    gltf.addShape("ceiling", makeQuad({-2, 3, -2}, {4, 0, 0}, {0, 0, 4}), white);
    addFloor(gltf);
    addPanels(gltf);
    addMappedPanel(gltf);
    addAlpha(gltf);
    addColorAndGlow(gltf);
    const int globe = addTexture(gltf, "grid.png", kRepeat, kClamp);
    gltf.addShape("globe", makeSphere({0.9f, 0.5f, -1}, 0.5f, 32, 16, true),
                  gltf.addMaterial(textured("globe", textureInfo(globe))));
    const int lamp = gltf.addMaterial(emitter("lamp", {14, 13, 12}));
    gltf.addShape("lamp", makeQuad({-0.5f, 2.97f, -0.5f}, {1, 0, 0}, {0, 0, 1}), lamp);
    gltf.addCamera({0.1, 1.5, 5.2}, {0, 1.4, 0}, 0.72, 4.0 / 3.0);
    gltf.save(folder);
}

void writeGlass(const std::filesystem::path& folder)
{
    GltfWriter gltf("glass", "solid and thin glass, clearcoat, tinted reflection, a mirror");
    const int floor = gltf.addMaterial(lambertian("floor", {0.6, 0.6, 0.6}));
    const int wall = gltf.addMaterial(lambertian("wall", {0.5, 0.55, 0.65}));
    gltf.addShape("floor", makeQuad({-3, 0, 2.5f}, {6, 0, 0}, {0, 0, -5}), floor);
    gltf.addShape("wall", makeQuad({-3, 0, -2.5f}, {6, 0, 0}, {0, 4, 0}), wall);
    addGlassObjects(gltf);
    const int lamp = gltf.addMaterial(emitter("lamp", {12, 11, 10}));
    gltf.addShape("lamp", makeQuad({-1, 3.5f, -1}, {2, 0, 0}, {0, 0, 2}), lamp);
    gltf.addCamera({0, 1.6, 4.5}, {0, 0.5, -0.2}, 0.6, 16.0 / 9.0);
    gltf.save(folder);
}

}  // namespace assets
