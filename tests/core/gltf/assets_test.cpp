// The committed scenes are what their generator writes, load without a warning, and contain what
// they are made for.
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "assets/generator/scenes.h"
#include "assets/generator/shapes.h"
#include "core/gltf/gltf.h"
#include "core/image/png_file.h"
#include "core/scene/world.h"
#include "tests/support/files/source_folder.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/files/whole_files.h"

namespace {

using tests::kAssets;
using tests::readAll;

/// Relative names and sizes of scenes and their textures in a folder.
std::map<std::string, uintmax_t> assetFiles(const std::filesystem::path& folder)
{
    std::map<std::string, uintmax_t> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        const std::filesystem::path name = std::filesystem::relative(entry.path(), folder);
        const bool scene =
            !name.has_parent_path() && (name.extension() == ".gltf" || name.extension() == ".bin");
        if (entry.is_regular_file() && (scene || name.parent_path() == "textures"))
            files[name.string()] = entry.file_size();
    }
    return files;
}

/// The bytes; of a PNG those of its pixels, for every version of zlib packs them in its own way.
std::string contentOf(const std::filesystem::path& file)
{
    const std::string bytes = readAll(file);
    if (file.extension() != ".png") return bytes;
    const core::DecodedImage decoded = core::decodePng(std::as_bytes(std::span(bytes)), {});
    EXPECT_EQ(decoded.problem, "");
    const auto& pixels = decoded.image.pixels;
    return {reinterpret_cast<const char*>(pixels.data()), pixels.size()};
}

std::shared_ptr<const core::Scene> load(const std::string& name)
{
    return core::loadGltf(kAssets / (name + ".gltf"));
}

TEST(Assets, areWhatTheGeneratorWrites)
{
    const tests::TemporaryFolder folder;
    assets::writeAll(folder.path());
    const auto made = assetFiles(folder.path()), committed = assetFiles(kAssets);
    ASSERT_EQ(made.size(), committed.size());
    uintmax_t total = 0;
    for (const auto& [name, size] : made) {
        ASSERT_TRUE(committed.contains(name)) << name;
        EXPECT_TRUE(contentOf(folder / name) == contentOf(kAssets / name)) << name;
        total += size;
    }
    EXPECT_LT(total, 1000000u);
}

TEST(Assets, loadWithoutWarningsAndWithACamera)
{
    size_t scenes = 0;
    for (const auto& [name, size] : assetFiles(kAssets)) {
        if (std::filesystem::path(name).extension() != ".gltf") continue;
        const auto world = core::makeWorld(core::loadGltf(kAssets / name));
        for (const core::Warning& warning : world->warnings.listed)
            ADD_FAILURE() << name << ": " << warning.pointer << ": " << warning.message;
        EXPECT_EQ(world->warnings.total(), 0u);
        EXPECT_EQ(world->cameras.size(), 1u) << name;
        EXPECT_GT(world->cameras[0].aspect, 0.9) << name;
        EXPECT_FALSE(world->emitters.empty()) << name;
        ++scenes;
    }
    EXPECT_EQ(scenes, 15u);
}

TEST(Assets, holdTheFeaturesTheyAreFor)
{
    using namespace shared;
    const std::map<std::string, uint32_t> expected{
        {"textured-box", kFeatureTextures | kFeatureNormalMaps | kFeatureVertexExtra |
                             kFeatureAlpha | kFeatureEmissiveTextures | kFeatureShadingNormals},
        {"glass",
         kFeatureTransmission | kFeatureVolume | kFeatureClearcoat | kFeatureMetal | kFeatureDelta},
        {"lights", kFeaturePunctualLights | kFeatureEmissiveTriangles | kFeatureManyEmitters},
        {"sky", kFeatureEnvironment | kFeatureSun},
        {"furnace-sphere", kFeatureEnvironment},
        {"cornell-glossy", kFeatureSpecular | kFeatureMetal}};
    for (const auto& [name, features] : expected)
        EXPECT_EQ(core::makeWorld(load(name))->features & features, features) << name;
    for (const char* name : {"cornell-diffuse", "furnace-50", "furnace-80", "furnace-sphere"})
        EXPECT_EQ(
            core::makeWorld(load(name))->features & (kFeatureSpecular | kFeatureShadingNormals), 0u)
            << name;
}

TEST(Assets, cornellBoxesDifferInRoughnessOnly)
{
    const std::map<std::string, float> roughness{
        {"diffuse", 1.0f}, {"rough", 0.7f}, {"moderate", 0.35f}, {"glossy", 0.12f}};
    const auto reference = core::makeWorld(load("cornell-diffuse"));
    for (const auto& [name, value] : roughness) {
        const auto world = core::makeWorld(load("cornell-" + name));
        EXPECT_EQ(world->positions, reference->positions);
        for (const shared::Material& material : world->materials) {
            if (material.emissive != glm::vec3(0)) continue;
            EXPECT_EQ(material.roughness, value) << name;
            EXPECT_EQ(material.specular, name == "diffuse" ? 0.0f : 1.0f);
        }
    }
}

/// Signed volume that a world's triangles enclose: negative when the fronts look inward.
double enclosedVolume(const core::World& world)
{
    double volume = 0;
    for (const core::WorldTriangle& t : world.triangles) {
        const glm::dvec3 a = world.positions[t.v0], b = world.positions[t.v1],
                         c = world.positions[t.v2];
        volume += glm::dot(a, glm::cross(b, c)) / 6;
    }
    return volume / std::pow(world.placement.scale, 3);
}

TEST(Assets, furnacesAreClosedAndAnswerAsTheySay)
{
    for (const auto& [name, albedo, answer] :
         {std::tuple("furnace-50", 0.5, 2.0), std::tuple("furnace-80", 0.8, 5.0)}) {
        const auto world = core::makeWorld(load(name));
        EXPECT_NEAR(enclosedVolume(*world), -8, 1e-5);
        EXPECT_EQ(world->emitters.size(), 12u);
        for (const core::WorldTriangle& t : world->triangles) {
            const shared::Material& wall = world->materials[t.material];
            EXPECT_NEAR(wall.baseColor.x, albedo, 1e-6);
            EXPECT_EQ(wall.emissive, glm::vec3(1));
            EXPECT_EQ(wall.specular, 0.0f);
        }
        const auto json = nlohmann::json::parse(readAll(kAssets / (std::string(name) + ".gltf")));
        EXPECT_EQ(json["scenes"][0]["extras"]["expectedRadiance"], answer);
        EXPECT_NEAR(answer, 1 / (1 - albedo), 1e-12);
    }
    const auto sphere = core::makeWorld(load("furnace-sphere"));
    EXPECT_NEAR(enclosedVolume(*sphere), 4.12, 0.05);  // below 4.19: facets
    for (const glm::vec4& texel : sphere->environment) EXPECT_EQ(glm::vec3(texel), glm::vec3(1));
}

TEST(Assets, hallHasAThousandLampsAllVisible)
{
    const auto scene = load("hall");
    size_t lamps = 0;
    for (const core::Node& node : scene->nodes)
        for (uint32_t mesh = node.meshes.begin; mesh < node.meshes.end; ++mesh) {
            const size_t material = size_t(scene->meshes[mesh].material);
            if (scene->materials[material].data.emissive == glm::vec3(0)) continue;
            ++lamps;
            const glm::dvec3 p = std::get<core::Transform>(node.local).translation;
            EXPECT_TRUE(std::abs(p.x) < 11.9 && std::abs(p.z) < 15.9 && p.y > 3 && p.y < 5.9);
        }
    EXPECT_GE(lamps, 1000u);
    EXPECT_EQ(core::makeWorld(scene)->emitters.size(), 4 * lamps);
}

TEST(Assets, lampBehindTheDoorShinesAwayFromIt)
{
    // It looks straight up from above the opening, which ends at 2.1 m: no straight path leads
    // through.
    const auto world = core::makeWorld(load("door-ajar"));
    ASSERT_EQ(world->emitters.size(), 2u);
    for (const shared::Emitter& lamp : world->emitters) {
        const glm::vec3 normal = glm::normalize(glm::cross(lamp.b - lamp.a, lamp.c - lamp.a));
        EXPECT_NEAR(normal.y, 1, 1e-6);
        const double height = double(lamp.a.y) / world->placement.scale + world->placement.centre.y;
        EXPECT_GT(height, 2.1);
    }
}

TEST(Assets, animationMovesEveryPart)
{
    const auto scene = load("animated");
    ASSERT_EQ(scene->animations.size(), 1u);
    EXPECT_EQ(scene->animations[0].duration, 2.0);
    EXPECT_EQ(scene->animations[0].channels.size(), 5u);
    const auto start = core::makeWorld(scene, 0), later = core::makeWorld(scene, 1);
    const glm::dvec3 before =
        start->cameras[0].position / start->placement.scale + start->placement.centre;
    const glm::dvec3 after =
        later->cameras[0].position / later->placement.scale + later->placement.centre;
    EXPECT_LT(glm::distance(before, glm::dvec3(0, 1, 5)), 1e-5);
    EXPECT_LT(glm::distance(after, glm::dvec3(5 * std::sqrt(0.5), 1, 5 * std::sqrt(0.5))), 1e-5);
    EXPECT_NE(start->positions, later->positions);
}

/// Twice the summed area vectors: zero for every closed surface.
glm::dvec3 areaVector(const assets::MeshData& mesh)
{
    glm::dvec3 sum(0);
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
        sum += glm::cross(b - a, c - a);
    }
    return sum;
}

TEST(Shapes, closeAndLookOutward)
{
    const std::vector<assets::MeshData> closed{assets::makeBox({-1, 0, 2}, {1, 3, 2.5f}, 30),
                                               assets::makeBox({0, 0, 0}, {1, 1, 1}, 0, true),
                                               assets::makeSphere({1, 2, 3}, 0.5f, 24, 12, true),
                                               assets::makeTetrahedron(2)};
    const double volumes[] = {3, -1, 0.5, 8 * 8 / (9 * std::sqrt(3.0))};
    for (size_t i = 0; i < closed.size(); ++i) {
        const assets::MeshData& mesh = closed[i];
        EXPECT_LT(glm::length(areaVector(mesh)), 1e-5);
        double volume = 0;
        for (const glm::uvec3& t : mesh.triangles) {
            const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y],
                             c = mesh.positions[t.z];
            volume += glm::dot(a, glm::cross(b, c)) / 6;
            const glm::dvec3 normal = glm::normalize(glm::cross(b - a, c - a));
            EXPECT_GT(glm::dot(normal, glm::dvec3(mesh.normals[t.x])), 0.95);
        }
        EXPECT_NEAR(volume, volumes[i], 0.03 * std::abs(volumes[i])) << i;
    }
}

}  // namespace
