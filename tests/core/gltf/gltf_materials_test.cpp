// Valid materials become exactly what they describe: factors, defaults, textures and their
// transforms. Lamps whose texture cannot be used do not shine (B72).
#include "tests/support/scenes/gltf_fixture.h"

namespace {

using test::Json;

TEST(GltfMaterials, EveryFactorArrives)
{
    test::Document document = test::triangle();
    document.material() = Json::parse(
        R"({"name":"all","emissiveFactor":[0.5,1,0],"alphaMode":"MASK","alphaCutoff":0.25,"doubleSided":true,
        "pbrMetallicRoughness":{"baseColorFactor":[0.1,0.2,0.3,0.4],"metallicFactor":0.5,"roughnessFactor":0.0},
        "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":8},"KHR_materials_ior":{"ior":1.33},
        "KHR_materials_specular":{"specularFactor":0.5,"specularColorFactor":[1,0.5,2]},
        "KHR_materials_transmission":{"transmissionFactor":0.75},
        "KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":2,"attenuationColor":[0.5,1,0]},
        "KHR_materials_clearcoat":{"clearcoatFactor":0.25,"clearcoatRoughnessFactor":0.125},"KHR_materials_unlit":{}}})");
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    const shared::Material& m = scene->materials.at(0).data;
    EXPECT_EQ(scene->materials[0].name, "all");
    EXPECT_EQ(m.baseColor, glm::vec3(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(m.alpha, 0.4f);
    EXPECT_EQ(m.alphaCutoff, 0.25f);
    EXPECT_EQ(m.metallic, 0.5f);
    EXPECT_EQ(m.roughness, 0.0f);
    EXPECT_EQ(m.emissive, glm::vec3(4, 8, 0));
    EXPECT_EQ(m.ior, 1.33f);
    EXPECT_EQ(m.specular, 0.5f);
    EXPECT_EQ(m.specularColor, glm::vec3(1, 0.5f, 2));
    EXPECT_EQ(m.transmission, 0.75f);
    EXPECT_NEAR(m.absorption.x, std::log(2.0) / 2, 1e-6);
    EXPECT_EQ(m.absorption.y, 0.0f);
    EXPECT_NEAR(m.absorption.z, std::log(1e6) / 2, 1e-4)
        << "black is capped at one part in a million";
    EXPECT_EQ(m.clearcoat, 0.25f);
    EXPECT_EQ(m.clearcoatRoughness, 0.125f);
    EXPECT_EQ(m.flags, shared::kMaterialDoubleSided | shared::kMaterialAlphaMask |
                           shared::kMaterialVolume | shared::kMaterialUnlit);
}

TEST(GltfMaterials, DefaultsAreThoseOfGltf)
{
    const auto check = [](const test::Document& document, const char* name) {
        const auto scene = test::load(document);
        ASSERT_TRUE(scene);
        ASSERT_EQ(scene->materials.size(), 1u);
        EXPECT_EQ(scene->materials[0].name, name);
        const shared::Material& m = scene->materials[0].data;
        EXPECT_EQ(m.baseColor, glm::vec3(1));
        EXPECT_EQ(m.alpha, 1.0f);
        EXPECT_EQ(m.metallic, 1.0f);
        EXPECT_EQ(m.roughness, 1.0f);
        EXPECT_EQ(m.emissive, glm::vec3(0));
        EXPECT_EQ(m.ior, 1.5f);
        EXPECT_EQ(m.specular, 1.0f);
        EXPECT_EQ(m.specularColor, glm::vec3(1));
        EXPECT_EQ(m.transmission, 0.0f);
        EXPECT_EQ(m.absorption, glm::vec3(0));
        EXPECT_EQ(m.alphaCutoff, 0.5f);
        EXPECT_EQ(m.normalScale, 1.0f);
        EXPECT_EQ(m.flags, 0u);
        const shared::Material shown = core::makeWorld(scene)->materials[0];
        EXPECT_EQ(shown.textures0 | shown.textures1 | shown.textures2 | shown.textures3 |
                      shown.textures4,
                  0u);
    };
    check(test::triangle(), "default");
    test::Document empty = test::triangle();
    empty.material();
    check(empty, "");
}

TEST(GltfMaterials, OpaqueIgnoresAlphaAndThinGlassHasNoVolume)
{
    test::Document document = test::triangle();
    document.material() =
        Json::parse(R"({"pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.25]},"extensions":{
        "KHR_materials_transmission":{"transmissionFactor":1},"KHR_materials_volume":{"thicknessFactor":0,"attenuationDistance":1,"attenuationColor":[0.5,0.5,0.5]}}})");
    const auto scene = test::load(document);
    EXPECT_EQ(scene->materials.at(0).data.alpha, 1.0f);
    EXPECT_EQ(scene->materials[0].data.flags, 0u);
}

TEST(GltfMaterials, SpecularGlossinessKeepsItsReflectance)
{
    test::Document document = test::triangle();
    document.material() = Json::parse(
        R"({"extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[0.8,0.4,0.2,1],
        "specularFactor":[0.25,0.125,0.0625],"glossinessFactor":0.75}}})");
    const auto scene = test::load(document);
    EXPECT_EQ(scene->warnings.total(), 0u);
    const shared::Material& m = scene->materials.at(0).data;
    const float root = (m.ior - 1) / (m.ior + 1);
    EXPECT_NEAR(root * root * m.specularColor.x, 0.25, 1e-6);
    EXPECT_NEAR(root * root * m.specularColor.y, 0.125, 1e-6);
    EXPECT_NEAR(m.baseColor.x, 0.8 * 0.75, 1e-6);
    EXPECT_EQ(m.metallic, 0.0f);
    EXPECT_EQ(m.roughness, 0.25f);
}

TEST(GltfMaterials, TextureSlotsSamplersAndTransforms)
{
    test::Document document =
        test::texturedTriangle(test::encodeImage("png", 2, 3, 3, std::vector<uint8_t>(18, 9)));
    document.attributes()["TEXCOORD_1"] = document.attributes()["TEXCOORD_0"];
    document.json["samplers"] = Json::array(
        {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}, {{"magFilter", 9729}}});
    document.json["textures"].push_back({{"source", 0}, {"sampler", 0}});
    document.material() = Json::parse(
        R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0},"metallicRoughnessTexture":{"index":1}},
        "normalTexture":{"index":1,"scale":0.5},"emissiveTexture":{"index":0,"texCoord":1,"extensions":{"KHR_texture_transform":
            {"offset":[0.25,0.5],"rotation":1.5707963267948966,"scale":[2,3]}}},
        "extensions":{"KHR_materials_transmission":{"transmissionTexture":{"index":1}},
        "KHR_materials_specular":{"specularTexture":{"index":1},"specularColorTexture":{"index":0}},
        "KHR_materials_clearcoat":{"clearcoatTexture":{"index":1},"clearcoatRoughnessTexture":{"index":1,"extensions":{"KHR_texture_transform":{"texCoord":1}}}}}})");
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    EXPECT_EQ(scene->textures.size(), 2u) << "one for colours, one for data";
    const core::Material& material = scene->materials.at(0);
    const auto record = [&](uint32_t slot) {
        return scene->textureUses.at(static_cast<size_t>(material.textures[slot])).record;
    };
    EXPECT_EQ(record(shared::kTextureBaseColor).flags, 0u);
    EXPECT_EQ(record(shared::kTextureBaseColor).width, 2u);
    EXPECT_EQ(record(shared::kTextureBaseColor).height, 3u);
    EXPECT_EQ(record(shared::kTextureNormal).flags,
              shared::kWrapClamp << shared::kTextureWrapSShift |
                  shared::kWrapMirror << shared::kTextureWrapTShift | shared::kTextureNearest);
    EXPECT_EQ(material.data.normalScale, 0.5f);
    EXPECT_EQ(material.textures[shared::kTextureNormal],
              material.textures[shared::kTextureTransmission])
        << "equal uses are shared";
    EXPECT_EQ(material.textures[shared::kTextureSpecularColor],
              material.textures[shared::kTextureBaseColor]);
    EXPECT_NE(record(shared::kTextureClearcoatRoughness).flags & shared::kTextureTexCoord1, 0u);

    // (u, v) = (1, 0) scaled to (2, 0), turned by a quarter, shifted: the convention of
    // TextureTransformTest.
    const shared::TextureReference emissive = record(shared::kTextureEmissive);
    EXPECT_EQ(emissive.flags, shared::kTextureTexCoord1 | shared::kTextureTransformed);
    EXPECT_NEAR(emissive.row0.x + emissive.row0.z, 0.25, 1e-6);
    EXPECT_NEAR(emissive.row1.x + emissive.row1.z, 0.5 - 2, 1e-6);
    EXPECT_NEAR(emissive.row0.y + emissive.row0.z, 0.25 + 3, 1e-6);
    EXPECT_NEAR(emissive.row1.y + emissive.row1.z, 0.5, 1e-6);

    const auto packed = [&](uint32_t slot) {
        return static_cast<uint32_t>(material.textures[slot] + 1);
    };
    const shared::Material m = core::makeWorld(scene)->materials[0];
    EXPECT_EQ(m.textures0, packed(0) | packed(1) << 16);
    EXPECT_EQ(m.textures1, packed(2) | packed(3) << 16);
    EXPECT_EQ(m.textures4, packed(8));
}

/// A lamp's pattern that cannot be had: no light, as where its image is broken, and the warning
/// says so. Other uses are left out alone.
TEST(GltfMaterials, UnusableEmissionTexturesBringNoLight)
{
    test::Document document =
        test::texturedTriangle(test::encodeImage("png", 1, 1, 3, std::vector<uint8_t>(3, 9)));
    document.json["textures"].push_back({{"extensions", {{"EXT_texture_webp", {{"source", 0}}}}}});
    document.json["textures"].push_back({{"source", 7}});
    document.material()["emissiveFactor"] = {1, 1, 1};
    const std::string info = "/materials/0/emissiveTexture";
    const struct {
        Json texture;
        const char* code;
        std::string pointer;
    } cases[] = {{{{"index", 0}, {"texCoord", 2}}, "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS", info},
                 {{{"index", 1}}, "TEXTURE_WITHOUT_SOURCE", "/textures/1"},
                 {{{"index", 2}}, "UNRESOLVED_REFERENCE", "/textures/2/source"},
                 {{{"index", 9}}, "UNRESOLVED_REFERENCE", info + "/index"},
                 {Json::object(), "UNDEFINED_PROPERTY", info},
                 {5, "TYPE_MISMATCH", info}};
    for (const auto& [texture, code, pointer] : cases) {
        SCOPED_TRACE(texture.dump());
        document.material()["emissiveTexture"] = texture;
        EXPECT_REPAIRED(scene, document, code, pointer);
        EXPECT_EQ(scene->materials.at(0).data.emissive, glm::vec3(0));
        EXPECT_NE(test::warning(*scene, code).message.find("— no light"), std::string::npos);
    }
    document.material().erase("emissiveTexture");
    document.material()["normalTexture"] = {{"index", 0}, {"texCoord", 2}};
    EXPECT_REPAIRED(other, document, "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS",
                    "/materials/0/normalTexture");
    EXPECT_EQ(other->materials.at(0).data.emissive, glm::vec3(1));
}

}  // namespace
