// EXT_mesh_gpu_instancing: nodes that show a mesh in many places (B99).
#include "tests/support/scenes/gltf_fixture.h"

#include <cmath>

#include "core/scene/instances.h"

namespace {

test::Json& attributesOf(test::Document& document)
{
    test::Json& node = document.json["nodes"][0];
    return node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
}

/// Three places: shifted, turned by normalised shorts, scaled.
test::Document placed()
{
    test::Document document = test::triangle();
    document.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
    document.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
    const int translation =
        document.values<float>({0, 0, 0, 4, 0, 0, 0, 5, 0}, test::kFloat, "VEC3", 3);
    const int scale = document.values<float>({1, 1, 1, 2, 3, 4, 1, 1, 1}, test::kFloat, "VEC3", 3);
    // No turn, a quarter about Z (in 32767ths), and a length that is not 1
    const int rotation = document.values<int16_t>(
        {0, 0, 0, 32767, 0, 0, 23170, 23170, 0, 0, 0, 10000}, 5122, "VEC4", 4);
    document.json["accessors"][static_cast<size_t>(rotation)]["normalized"] = true;
    attributesOf(document) = {
        {"TRANSLATION", translation}, {"SCALE", scale}, {"ROTATION", rotation}};
    return document;
}

TEST(GltfPlacements, ShowAMeshInManyPlaces)
{
    const auto scene = test::load(placed());
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    const int at = scene->nodes[0].placements;
    ASSERT_GE(at, 0);
    const std::vector<core::MeshPlacement>& places = scene->placements[static_cast<size_t>(at)];
    ASSERT_EQ(places.size(), 3u);
    EXPECT_EQ(places[1].translation, glm::vec3(4, 0, 0));
    EXPECT_EQ(places[1].scale, glm::vec3(2, 3, 4));
    EXPECT_NEAR(places[1].rotation.z, std::sqrt(0.5f), 1e-4f);
    EXPECT_NEAR(places[1].rotation.w, std::sqrt(0.5f), 1e-4f);
    EXPECT_NEAR(places[2].rotation.w, 1, 1e-6f);

    const auto flat = core::makeWorld(scene, 0, 0, {}, core::Instancing::flat);
    const auto kept = core::makeWorld(scene, 0, 0, {}, core::Instancing::kept);
    EXPECT_EQ(flat->triangles.size(), 3u);
    EXPECT_EQ(kept->triangles.size(), 1u);
    EXPECT_EQ(kept->instances.size(), 3u);
    // The second: scaled, turned, shifted. (1,0,0) -> (2,0,0) -> (0,2,0) -> (4,2,0)
    const core::WorldTriangle& t = flat->triangles[1];
    const auto inFile = [&](uint32_t v) {
        return flat->placement.toFile(glm::dvec3(flat->positions[v]));
    };
    EXPECT_NEAR(glm::distance(inFile(t.v1), glm::dvec3(4, 2, 0)), 0, 1e-3);
    EXPECT_NEAR(glm::distance(inFile(t.v2), glm::dvec3(1, 0, 0)), 0, 1e-3);
}

TEST(GltfPlacements, NoneOrOneOrNothingToSay)
{
    const std::string extension = "/nodes/0/extensions/EXT_mesh_gpu_instancing";
    test::Document none = placed();
    attributesOf(none) = test::Json::object();
    EXPECT_REPAIRED(scene, none, "UNDEFINED_PROPERTY", extension + "/attributes");
    EXPECT_EQ(core::makeWorld(scene)->triangles.size(), 1u) << "as without the extension";
    none.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = test::Json::object();
    EXPECT_REPAIRED(absent, none, "UNDEFINED_PROPERTY", extension);
    EXPECT_EQ(core::makeWorld(absent)->triangles.size(), 1u);

    test::Document turnless = placed();
    attributesOf(turnless) = {
        {"ROTATION", turnless.values<float>({0, 0, 0, 0, 0, 0, 0, 1}, test::kFloat, "VEC4", 4)}};
    const auto repaired = test::load(turnless);
    ASSERT_TRUE(repaired);
    EXPECT_EQ(test::warning(*repaired, "ROTATION_NON_UNIT").pointer,
              "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/ROTATION");

    test::Document lost = placed();
    const float infinite = INFINITY;
    attributesOf(lost) = {
        {"TRANSLATION", lost.values<float>({0, 0, 0, infinite, 0, 0}, test::kFloat, "VEC3", 3)}};
    const auto world = core::makeWorld(test::load(lost));
    EXPECT_EQ(world->triangles.size(), 1u);
    EXPECT_EQ(world->warnings.total(), 1u);
}

/// Attributes of an application's own say how many there are, and nothing of where they stand.
TEST(GltfPlacements, AttributesOfTheirOwnCountToo)
{
    test::Document own = placed();
    attributesOf(own) = {
        {"_FEATURE_ID_0", own.values<float>({0, 1, 2, 3}, test::kFloat, "SCALAR", 1)}};
    own.json["nodes"][0]["translation"] = {5, 0, 0};
    const auto scene = test::load(own);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    ASSERT_EQ(scene->placements.size(), 1u);
    ASSERT_EQ(scene->placements[0].size(), 4u);
    EXPECT_EQ(scene->placements[0][3].translation, glm::vec3(0));
    EXPECT_EQ(scene->placements[0][3].scale, glm::vec3(1));
    EXPECT_EQ(core::makeWorld(scene)->triangles.size(), 4u);
    attributesOf(own) = {{"_FEATURE_ID_0", 99}};
    EXPECT_REFUSED(own.text(), "UNRESOLVED_REFERENCE",
                   "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/_FEATURE_ID_0");
}

TEST(GltfPlacements, WhatDoesNotFitIsRefused)
{
    const std::string pointer = "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/";
    test::Document uneven = placed();
    attributesOf(uneven)["SCALE"] =
        uneven.values<float>({1, 1, 1, 1, 1, 1}, test::kFloat, "VEC3", 3);
    EXPECT_REFUSED(uneven.text(), "INSTANCING_COUNT", pointer + "SCALE");
    test::Document wrong = placed();
    attributesOf(wrong)["SCALE"] = 1;  // indices
    EXPECT_REFUSED(wrong.text(), "INSTANCING_FORMAT", pointer + "SCALE");
    test::Document missing = placed();
    attributesOf(missing)["ROTATION"] = 99;
    EXPECT_REFUSED(missing.text(), "UNRESOLVED_REFERENCE", pointer + "ROTATION");
}

/// 10^6 places of a mesh of 100 triangles: written out they do not fit, as instances they do.
TEST(GltfPlacements, AreCountedBeforeTheyAreMade)
{
    test::Document many = test::triangle();
    std::vector<uint16_t> indices;
    for (int i = 0; i < 100; ++i) indices.insert(indices.end(), {0, 1, 2});
    many.primitive()["indices"] = many.values<uint16_t>(indices, test::kUnsignedShort, "SCALAR", 1);
    attributesOf(many) = {
        {"TRANSLATION", many.values(std::vector<float>(3'000'000), test::kFloat, "VEC3", 3)}};
    core::LoadOptions options;
    options.maxMemoryMb = 512;
    EXPECT_TRUE(test::load(many, options));
    options.instancing = core::Instancing::flat;
    EXPECT_EQ(test::refusal(many.text(), options).code, "TOO_LARGE");
    options.instancing = core::Instancing::automatic;
    options.maxMemoryMb = 256;
    EXPECT_EQ(test::refusal(many.text(), options).code, "TOO_LARGE");
}

}  // namespace
