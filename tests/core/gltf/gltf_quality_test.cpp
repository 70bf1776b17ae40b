// Faults of an asset's quality are repaired, counted and reported with their place (B57, B58, B61,
// B64, B66-B68, B72-B74, B77, B78, B84, N7, N8, N17, N19).
#include "tests/support/scenes/gltf_fixture.h"

#include <cmath>
#include <map>

#include "shared/warp.h"
#include "tests/support/statistics/no_numbers.h"

namespace {

using test::Json;
using tests::kFloatInf;
using tests::kFloatNan;

const std::string kPrimitive = "/meshes/0/primitives/0";

const core::Transform& transformOf(const core::Scene& scene)
{
    return std::get<core::Transform>(scene.nodes.at(0).local);
}

/// The triangle with another list of positions and no indices.
test::Document withPositions(const std::vector<float>& positions)
{
    test::Document document = test::triangle();
    document.primitive().erase("indices");
    document.attributes()["POSITION"] = document.values(positions, test::kFloat, "VEC3", 3);
    return document;
}

TEST(GltfRepairs, EmptyScenesLoadAndSaySo)
{
    for (const char* text :
         {R"({"asset":{"version":"2.0"}})", R"({"asset":{"version":"2.0"},"scenes":[{}]})",
          R"({"asset":{"version":"2.0"},"nodes":[{}],"scenes":[{"nodes":[0]}]})"}) {
        const auto scene = test::loadText(text);
        ASSERT_TRUE(scene);
        EXPECT_EQ(test::warning(*scene, "EMPTY_SCENE").message,
                  "empty scene: there are no triangles to show");
        EXPECT_EQ(scene->materials.size(), 1u);
    }
    EXPECT_REPAIRED(
        scene,
        [] {
            test::Document document = test::triangle();
            document.json["meshes"][0]["primitives"] = Json::array();
            return document;
        }(),
        "EMPTY_ENTITY", "/meshes/0");
}

TEST(GltfRepairs, WithoutScenesEveryRootIsShown)
{
    test::Document document = test::triangle();
    document.json.erase("scenes");
    document.json.erase("scene");
    document.json["nodes"] = Json::parse(R"([{"children":[1]},{"mesh":0},{"mesh":0}])");
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    EXPECT_EQ(scene->nodes.size(), 3u);
    for (const size_t root : {size_t{0}, size_t{2}}) EXPECT_EQ(scene->nodes[root].parent, -1);
    EXPECT_EQ(scene->nodes[1].parent, 0);
}

TEST(GltfRepairs, TrianglesThatAreNotFiniteAreDropped)
{
    for (const float bad : {kFloatNan, kFloatInf, -kFloatInf, 3e38f}) {
        EXPECT_REPAIRED(scene,
                        withPositions({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, bad, 0, 0, 0, 1, 0}),
                        "ACCESSOR_INVALID_FLOAT", kPrimitive);
        EXPECT_EQ(scene->meshes.at(0).triangles, (std::vector<glm::uvec3>{{0, 1, 2}}));
        for (const glm::vec3& p : scene->meshes[0].positions)
            EXPECT_TRUE(std::abs(p.x) <= 1 && std::abs(p.y) <= 1);
        EXPECT_EQ(test::warning(*scene, "ACCESSOR_INVALID_FLOAT").message,
                  "1 triangles have positions that are not finite or beyond 1e18 — dropped");
    }
}

TEST(GltfRepairs, IncompleteTrianglesAreDropped)
{
    EXPECT_REPAIRED(scene, withPositions({0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 5, 5}),
                    "MESH_PRIMITIVE_INCOMPATIBLE_MODE", kPrimitive);
    EXPECT_EQ(scene->meshes.at(0).triangles.size(), 1u);
    EXPECT_REPAIRED(nothing, withPositions({0, 0, 0, 1, 0, 0}), "MESH_PRIMITIVE_INCOMPATIBLE_MODE",
                    kPrimitive);
    EXPECT_TRUE(nothing->meshes.empty());
}

TEST(GltfRepairs, PointsAndLinesAreSkipped)
{
    for (int mode = 0; mode < 4; ++mode) {
        test::Document document = test::triangle();
        document.primitive()["mode"] = mode;
        EXPECT_REPAIRED(scene, document, "PRIMITIVE_MODE_IGNORED", kPrimitive);
        EXPECT_TRUE(scene->meshes.empty());
    }
}

TEST(GltfRepairs, PrimitivesWithoutPositionsAreSkipped)
{
    test::Document document = test::triangle();
    document.json["meshes"][0]["primitives"].push_back({{"attributes", Json::object()}});
    EXPECT_REPAIRED(scene, document, "MESH_PRIMITIVE_NO_POSITION", "/meshes/0/primitives/1");
    EXPECT_EQ(scene->meshes.size(), 1u);
    document.json["meshes"][0]["primitives"][1] = Json::object();
    EXPECT_REPAIRED(bare, document, "MESH_PRIMITIVE_NO_POSITION", "/meshes/0/primitives/1");
}

TEST(GltfRepairs, NormalsThatDoNotFitGiveFlatShading)
{
    test::Document wrongCount = test::triangle();
    wrongCount.attributes()["NORMAL"] =
        wrongCount.values<float>({0, 0, 1, 0, 0, 1}, test::kFloat, "VEC3", 3);
    EXPECT_REPAIRED(count, wrongCount, "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT",
                    kPrimitive + "/attributes/NORMAL");
    EXPECT_FALSE(count->meshes.at(0).hasNormals);
    test::Document wrongType = test::triangle();
    wrongType.attributes()["NORMAL"] =
        wrongType.values<float>({0, 0, 0, 0, 0, 0}, test::kFloat, "VEC2", 2);
    EXPECT_REPAIRED(type, wrongType, "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT",
                    kPrimitive + "/attributes/NORMAL");
    EXPECT_FALSE(type->meshes.at(0).hasNormals);
}

TEST(GltfRepairs, NormalsWithoutDirectionBecomeThoseOfTheFaces)
{
    for (const float bad : {0.0f, kFloatNan, kFloatInf}) {
        test::Document document = test::triangle();
        document.attributes()["NORMAL"] =
            document.values<float>({1, 0, 0, bad, bad, bad, 0, 1, 0}, test::kFloat, "VEC3", 3);
        EXPECT_REPAIRED(scene, document, "ACCESSOR_INVALID_FLOAT",
                        kPrimitive + "/attributes/NORMAL");
        const core::Mesh& mesh = scene->meshes.at(0);
        EXPECT_EQ(mesh.attributes[0].normal, shared::packOct(glm::vec3(1, 0, 0)));
        EXPECT_EQ(mesh.attributes[1].normal, shared::packOct(glm::vec3(0, 0, 1)));
        EXPECT_EQ(mesh.attributes[2].normal, shared::packOct(glm::vec3(0, 1, 0)));
    }
}

TEST(GltfRepairs, NormalsOfWrongLengthAreNormalised)
{
    test::Document document = test::triangle();
    document.attributes()["NORMAL"] =
        document.values<float>({1e-30f, 0, 0, 0, 1e30f, 0, 0, 0, 1}, test::kFloat, "VEC3", 3);
    EXPECT_REPAIRED(scene, document, "ACCESSOR_VECTOR3_NON_UNIT",
                    kPrimitive + "/attributes/NORMAL");
    EXPECT_EQ(scene->meshes.at(0).attributes[0].normal, shared::packOct(glm::vec3(1, 0, 0)));
    EXPECT_EQ(scene->meshes[0].attributes[1].normal, shared::packOct(glm::vec3(0, 1, 0)));
    EXPECT_NE(test::warning(*scene, "ACCESSOR_VECTOR3_NON_UNIT").message.find("2 normals"),
              std::string::npos);
}

/// A triangle with normals along +z and a normal map.
test::Document withNormalMap()
{
    test::Document document = test::texturedTriangle(
        test::encodeImage("png", 1, 1, 3, std::vector<uint8_t>{128, 128, 255}));
    document.attributes()["NORMAL"] =
        document.values<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, test::kFloat, "VEC3", 3);
    document.material()["normalTexture"]["index"] = 0;
    return document;
}

TEST(GltfRepairs, TangentsWithoutDirectionAreReplaced)
{
    const std::vector<std::vector<float>> faults{
        {0, 0, 0, 1},
        {kFloatNan, 0, 0, 1},
        {0, 0, 1, 1},
        {1, 0, 0, 0}};  // zero, NaN, along the normal, no handedness
    for (const std::vector<float>& fault : faults) {
        test::Document document = withNormalMap();
        std::vector<float> tangents{1, 0, 0, 1, 1, 0, 0, 1};
        tangents.insert(tangents.end(), fault.begin(), fault.end());
        document.attributes()["TANGENT"] = document.values(tangents, test::kFloat, "VEC4", 4);
        EXPECT_REPAIRED(scene, document, "ACCESSOR_VECTOR3_NON_UNIT",
                        kPrimitive + "/attributes/TANGENT");
        const core::Mesh& mesh = scene->meshes.at(0);
        ASSERT_TRUE(mesh.hasTangents);
        for (const shared::VertexAttributes& a : mesh.attributes) {
            const glm::vec4 t = shared::unpackTangent(a.tangent);
            EXPECT_NEAR(t.z, 0, 1e-3) << "orthogonal to the normal";
            EXPECT_NEAR(glm::length(glm::vec3(t)), 1, 1e-3);
        }
    }
}

TEST(GltfRepairs, TangentsThatCannotBeComputedAreNoFault)
{
    test::Document document = withNormalMap();
    document.attributes()["TEXCOORD_0"] =
        document.values<float>({0, 0, 0, 0, 0, 0}, test::kFloat, "VEC2", 2);
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    EXPECT_TRUE(scene->meshes.at(0).hasTangents);
}

TEST(GltfRepairs, TextureCoordinatesThatAreNotFiniteBecomeZero)
{
    test::Document document = withNormalMap();
    document.attributes()["TEXCOORD_0"] =
        document.values<float>({kFloatNan, 0, 1e9f, -kFloatInf, 0, 1}, test::kFloat, "VEC2", 2);
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    for (const shared::VertexAttributes& a : scene->meshes.at(0).attributes)
        EXPECT_TRUE(std::isfinite(a.u) && std::isfinite(a.v));
    EXPECT_EQ(scene->meshes[0].attributes[1].u, 1e9f);
}

TEST(GltfRepairs, MissingTextureCoordinatesAreTold)
{
    test::Document document = withNormalMap();
    document.attributes().erase("TEXCOORD_0");
    EXPECT_REPAIRED(scene, document, "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS",
                    kPrimitive + "/attributes");
}

TEST(GltfRepairs, ColoursThatMeanNothingAreWhite)
{
    test::Document document = test::triangle();
    document.attributes()["COLOR_0"] =
        document.values<float>({kFloatNan, 0, 0, 0.5f, 0, 0, -1, 0, 0}, test::kFloat, "VEC3", 3);
    EXPECT_REPAIRED(scene, document, "ACCESSOR_INVALID_FLOAT", kPrimitive + "/attributes/COLOR_0");
    ASSERT_EQ(scene->meshes.at(0).extra.size(), 3u);
    EXPECT_EQ(scene->meshes[0].extra[0].colorRg, 0x3c003c00u);
    EXPECT_EQ(scene->meshes[0].extra[1].colorRg, 0x00003800u);
}

TEST(GltfRepairs, MaterialReferencesFallBack)
{
    test::Document document = test::triangle();
    document.primitive()["material"] = 9;
    EXPECT_REPAIRED(material, document, "UNRESOLVED_REFERENCE", kPrimitive + "/material");
    EXPECT_EQ(material->materials.at(0).name, "default");

    const auto texture = [](const char* pointer, const Json& value) {
        test::Document damaged = withNormalMap();
        damaged.json["samplers"] = Json::array({Json::object()});
        damaged.json["textures"][0]["sampler"] = 0;
        damaged.json[Json::json_pointer(pointer)] = value;
        return damaged;
    };
    const std::string base = "/materials/0/pbrMetallicRoughness/baseColorTexture";
    EXPECT_REPAIRED(index, texture((base + "/index").c_str(), 77), "UNRESOLVED_REFERENCE",
                    base + "/index");
    EXPECT_EQ(index->materials.at(0).textures[shared::kTextureBaseColor], -1);
    EXPECT_REPAIRED(set, texture((base + "/texCoord").c_str(), 5),
                    "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS", base);
    EXPECT_EQ(set->materials.at(0).textures[shared::kTextureBaseColor], -1);
    EXPECT_REPAIRED(sampler, texture("/textures/0/sampler", 12), "UNRESOLVED_REFERENCE",
                    "/textures/0/sampler");
    EXPECT_GE(sampler->materials.at(0).textures[shared::kTextureBaseColor], 0);
    EXPECT_REPAIRED(source, texture("/textures/0/source", 12), "UNRESOLVED_REFERENCE",
                    "/textures/0/source");
    EXPECT_REPAIRED(wrap, texture("/samplers/0/wrapS", 5), "VALUE_NOT_IN_LIST",
                    "/samplers/0/wrapS");
    EXPECT_REPAIRED(filter, texture("/samplers/0/magFilter", "x"), "VALUE_NOT_IN_LIST",
                    "/samplers/0/magFilter");
}

TEST(GltfRepairs, FactorsAreClampedOrIgnored)
{
    const auto material = [](const char* pointer, const Json& value) {
        test::Document document = test::triangle();
        document.material();
        document.json["materials"][0][Json::json_pointer(pointer)] = value;
        return document;
    };
    const std::string at = "/materials/0";
    const std::string pbr = "/pbrMetallicRoughness", x = "/extensions/KHR_materials_";
    EXPECT_REPAIRED(metallic, material((pbr + "/metallicFactor").c_str(), 7), "VALUE_NOT_IN_RANGE",
                    at + pbr + "/metallicFactor");
    EXPECT_EQ(metallic->materials.at(0).data.metallic, 1.0f);
    EXPECT_REPAIRED(roughness, material((pbr + "/roughnessFactor").c_str(), -1),
                    "VALUE_NOT_IN_RANGE", at + pbr + "/roughnessFactor");
    EXPECT_EQ(roughness->materials.at(0).data.roughness, 0.0f);
    EXPECT_REPAIRED(color, material((pbr + "/baseColorFactor").c_str(), {2, -1, 0.5, 1}),
                    "VALUE_NOT_IN_RANGE", at + pbr + "/baseColorFactor");
    EXPECT_EQ(color->materials.at(0).data.baseColor, glm::vec3(1, 0, 0.5f));
    EXPECT_REPAIRED(three, material((pbr + "/baseColorFactor").c_str(), {1, 0, 0}),
                    "ARRAY_LENGTH_NOT_IN_LIST", at + pbr + "/baseColorFactor");
    EXPECT_EQ(three->materials.at(0).data.baseColor, glm::vec3(1));
    EXPECT_REPAIRED(emissive, material("/emissiveFactor", {1, 2}), "ARRAY_LENGTH_NOT_IN_LIST",
                    at + "/emissiveFactor");
    EXPECT_EQ(emissive->materials.at(0).data.emissive, glm::vec3(0));
    EXPECT_REPAIRED(text, material((pbr + "/metallicFactor").c_str(), "shiny"), "TYPE_MISMATCH",
                    at + pbr + "/metallicFactor");
    EXPECT_REPAIRED(mode, material("/alphaMode", "GLASS"), "VALUE_NOT_IN_LIST", at + "/alphaMode");
    EXPECT_REPAIRED(sided, material("/doubleSided", 1), "TYPE_MISMATCH", at + "/doubleSided");
    EXPECT_REPAIRED(whole, material("/pbrMetallicRoughness", 3), "TYPE_MISMATCH", at + pbr);
    EXPECT_REPAIRED(strength, material((x + "emissive_strength/emissiveStrength").c_str(), -4),
                    "VALUE_NOT_IN_RANGE", at + x + "emissive_strength/emissiveStrength");
    EXPECT_REPAIRED(ior, material((x + "ior/ior").c_str(), 0.5), "VALUE_NOT_IN_RANGE",
                    at + x + "ior/ior");
    EXPECT_EQ(ior->materials.at(0).data.ior, 1.0f);
    EXPECT_REPAIRED(
        black,
        material((x + "volume").c_str(), {{"thicknessFactor", 1}, {"attenuationDistance", 0}}),
        "VALUE_NOT_IN_RANGE", at + x + "volume/attenuationDistance");
    for (int k = 0; k < 3; ++k)
        EXPECT_TRUE(std::isfinite(black->materials.at(0).data.absorption[k]));
}

TEST(GltfRepairs, RotationsAreMadeUnit)
{
    const auto rotated = [](const Json& q) {
        test::Document document = test::triangle();
        document.json["nodes"][0]["rotation"] = q;
        return document;
    };
    for (const Json& q :
         {Json{0, 0, 0, 2}, Json{0, 0, 0, 1e-20}, Json{0, 0, 0, 1e-300}, Json{0, 0, 0, 1e300}}) {
        EXPECT_REPAIRED(scene, rotated(q), "ROTATION_NON_UNIT", "/nodes/0/rotation");
        EXPECT_NEAR(transformOf(*scene).rotation.w, 1, 1e-12);
    }
    EXPECT_REPAIRED(zero, rotated({0, 0, 0, 0}), "ROTATION_NON_UNIT", "/nodes/0/rotation");
    EXPECT_EQ(transformOf(*zero).rotation, glm::dquat(1, 0, 0, 0));
    const auto fine = test::load(rotated({0.7071067, 0, 0, 0.7071068}));
    EXPECT_EQ(fine->warnings.total(), 0u) << "rounding is no fault";
}

TEST(GltfRepairs, StrangeScalesAndMatricesStayFinite)
{
    test::Document document = test::triangle();
    document.json["nodes"][0]["scale"] = {1e300, -1, 0};
    EXPECT_REPAIRED(scene, document, "VALUE_NOT_IN_RANGE", "/nodes/0/scale");
    EXPECT_EQ(transformOf(*scene).scale, glm::dvec3(1e18, -1, 0));
    test::Document projective = test::triangle();
    projective.json["nodes"][0]["matrix"] = {1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1};
    EXPECT_REPAIRED(matrix, projective, "NODE_MATRIX_NON_TRS", "/nodes/0/matrix");
    EXPECT_EQ(std::get<glm::dmat4x3>(matrix->nodes[0].local)[0], glm::dvec3(1, 0, 0));
    EXPECT_EQ(std::get<glm::dmat4x3>(matrix->nodes[0].local)[3], glm::dvec3(7, 8, 9));
    projective.json["nodes"][0]["matrix"] = std::vector<int>(16, 0);
    const auto zero = test::load(projective);
    ASSERT_TRUE(zero);
    EXPECT_EQ(std::get<glm::dmat4x3>(zero->nodes[0].local)[3], glm::dvec3(0));
}

TEST(GltfRepairs, CamerasFallBack)
{
    const auto camera = [](const Json& lens) {
        test::Document document = test::triangle();
        document.json["cameras"] = Json::array({{{"type", "perspective"}, {"perspective", lens}}});
        document.json["nodes"][0]["camera"] = 0;
        return document;
    };
    const std::string at = "/cameras/0/perspective";
    EXPECT_REPAIRED(zero, camera({{"yfov", 0}, {"znear", 0.1}}), "VALUE_NOT_IN_RANGE",
                    at + "/yfov");
    EXPECT_EQ(zero->cameras.at(0).yfov, 0.9);
    EXPECT_REPAIRED(missing, camera({{"znear", 0.1}}), "UNDEFINED_PROPERTY", at);
    EXPECT_REPAIRED(wide, camera({{"yfov", 3.2}, {"znear", 0.1}}), "VALUE_NOT_IN_RANGE",
                    at + "/yfov");
    EXPECT_REPAIRED(narrow, camera({{"yfov", 1e-9}, {"znear", 0.1}}), "VALUE_NOT_IN_RANGE",
                    at + "/yfov");
    EXPECT_EQ(narrow->cameras.at(0).yfov, 1e-3);
    EXPECT_REPAIRED(aspect, camera({{"yfov", 1}, {"aspectRatio", 0}, {"znear", 0.1}}),
                    "VALUE_NOT_IN_RANGE", at + "/aspectRatio");
    EXPECT_EQ(aspect->cameras.at(0).aspect, 0.0);
    EXPECT_REPAIRED(near, camera({{"yfov", 1}, {"znear", 0}}), "CAMERA_ZFAR_LEQUAL_ZNEAR", at);
    EXPECT_REPAIRED(planes, camera({{"yfov", 1}, {"znear", 2}, {"zfar", 1}}),
                    "CAMERA_ZFAR_LEQUAL_ZNEAR", at);
    test::Document untyped = camera(Json::object());
    untyped.json["cameras"][0] = Json::object();
    EXPECT_REPAIRED(none, untyped, "UNDEFINED_PROPERTY", "/cameras/0");
    EXPECT_EQ(none->cameras.at(0).yfov, 0.9);
    test::Document unresolved = test::triangle();
    unresolved.json["nodes"][0]["camera"] = 3;
    EXPECT_REPAIRED(reference, unresolved, "UNRESOLVED_REFERENCE", "/nodes/0/camera");
    EXPECT_TRUE(reference->cameras.empty());
}

TEST(GltfRepairs, LightsAreSkippedOrClamped)
{
    const auto light = [](const Json& value) {
        test::Document document = test::triangle();
        document.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({value});
        document.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
        return document;
    };
    const std::string at = "/extensions/KHR_lights_punctual/lights/0";
    EXPECT_REPAIRED(untyped, light(Json::object()), "VALUE_NOT_IN_LIST", at);
    EXPECT_TRUE(untyped->lights.empty());
    EXPECT_EQ(untyped->nodes[0].light, -1);
    EXPECT_REPAIRED(number, light(3), "TYPE_MISMATCH", at);
    EXPECT_REPAIRED(coneless, light({{"type", "spot"}}), "UNDEFINED_PROPERTY", at);
    EXPECT_EQ(coneless->lights.size(), 1u);
    EXPECT_REPAIRED(negative, light({{"type", "point"}, {"intensity", -3}}), "VALUE_NOT_IN_RANGE",
                    at + "/intensity");
    EXPECT_EQ(negative->lights.at(0).intensity, 0.0f);
    EXPECT_REPAIRED(huge, light({{"type", "point"}, {"intensity", 1e30}}), "VALUE_NOT_IN_RANGE",
                    at + "/intensity");
    EXPECT_EQ(huge->lights.at(0).intensity, 1e18f);
    EXPECT_REPAIRED(
        cones,
        light({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.5}, {"outerConeAngle", 0.5}}}}),
        "KHR_LIGHTS_PUNCTUAL_LIGHT_SPOT_ANGLES", at + "/spot");
    EXPECT_LT(cones->lights.at(0).innerCone, cones->lights[0].outerCone);
    test::Document unresolved = light({{"type", "point"}});
    unresolved.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 12;
    EXPECT_REPAIRED(reference, unresolved, "UNRESOLVED_REFERENCE",
                    "/nodes/0/extensions/KHR_lights_punctual/light");
    EXPECT_EQ(reference->nodes[0].light, -1);
}

TEST(GltfRepairs, SkinsOfMeshesWithoutJointsAreIgnored)
{
    test::Document document = test::triangle();
    document.json["skins"] = Json::array({{{"joints", {0}}}});
    document.json["nodes"][0]["skin"] = 0;
    EXPECT_REPAIRED(scene, document, "NODE_SKIN_WITH_NON_SKINNED_MESH",
                    "/meshes/0/primitives/0/attributes");
    EXPECT_EQ(scene->meshes.size(), 1u);
}

TEST(GltfRepairs, NamesOfTheWrongTypeAreIgnored)
{
    test::Document document = test::triangle();
    document.json["nodes"][0]["name"] = 5;
    EXPECT_REPAIRED(scene, document, "TYPE_MISMATCH", "/nodes/0/name");
}

/// The scene's nodes stand in another order than the document's, and are fewer.
TEST(GltfRepairs, WarningsOfTheWorldNameTheDocumentsNodes)
{
    test::Document document = test::triangle();
    document.json["nodes"] = Json::parse(R"([{"mesh":0,"scale":[0,0,0]},{"mesh":0},{},
        {"extensions":{"KHR_lights_punctual":{"light":0}}},{"children":[0,1,3]}])");
    document.json["scenes"][0]["nodes"] = {4};
    document.json["extensionsUsed"] = {"KHR_lights_punctual"};
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "point"}, {"range", 5}}};
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    std::map<std::string, std::string> places;
    const auto world = core::makeWorld(scene);
    for (const core::Warning& warning : world->warnings.listed)
        places[warning.code] = warning.pointer;
    EXPECT_EQ(places["NODE_SCALE_ZERO"], "/nodes/0");
    EXPECT_EQ(places["LIGHT_RANGE_IGNORED"], "/nodes/3");
}

}  // namespace
