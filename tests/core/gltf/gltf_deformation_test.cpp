// Skins and animated morph weights of files: what is read, in every format that is allowed, and
// what becomes of those that cannot be used (B84, B110, B111).
#include <cmath>
#include <random>

#include "core/scene/world.h"
#include "tests/support/scenes/gltf_fixture.h"
#include "tests/support/statistics/no_numbers.h"

namespace {

using test::Json;
using tests::kFloatNan;

/// The triangle's vertices follow joints (nodes 1 and 2, at x = 10 and y = 10): the first the one,
/// the second the other, the third a quarter and three quarters.
test::Document skinned()
{
    test::Document document = test::triangle();
    document.json["nodes"] = Json::parse(R"([{"mesh":0,"skin":0,"translation":[7,7,7]},
        {"translation":[10,0,0]},{"translation":[0,10,0]}])");
    document.json["scenes"][0]["nodes"] = {0, 1, 2};
    document.json["skins"] = Json::array({{{"joints", {1, 2}}}});
    document.attributes()["JOINTS_0"] = document.values<uint8_t>(
        {0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, test::kUnsignedByte, "VEC4", 4);
    document.attributes()["WEIGHTS_0"] = document.values<float>(
        {1, 0, 0, 0, 1, 0, 0, 0, 0.75f, 0.25f, 0, 0}, test::kFloat, "VEC4", 4);
    return document;
}

/// Vertices of the only mesh as they are shown, in the file's space.
std::vector<glm::dvec3> shown(const std::shared_ptr<const core::Scene>& scene, double time = 0)
{
    const auto world = core::makeWorld(scene, time);
    std::vector<glm::dvec3> positions;
    for (size_t v = 0; v + 1 < world->positions.size(); ++v)
        positions.push_back(world->placement.toFile(glm::dvec3(world->positions[v])));
    return positions;
}

void expectPositions(const std::vector<glm::dvec3>& positions,
                     const std::vector<glm::dvec3>& expected)
{
    ASSERT_EQ(positions.size(), expected.size());
    for (size_t v = 0; v < positions.size(); ++v)
        EXPECT_LT(glm::distance(positions[v], expected[v]), 1e-5)
            << v << ": " << positions[v].x << ' ' << positions[v].y << ' ' << positions[v].z;
}

const std::vector<glm::dvec3> kFollowed{{10, 0, 0}, {1, 10, 0}, {2.5, 8.5, 0}};
const std::vector<glm::dvec3> kStored{{7, 7, 7}, {8, 7, 7}, {7, 8, 7}};

TEST(GltfSkins, VerticesFollowJointsInsteadOfTheirNode)
{
    const auto scene = test::load(skinned());
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    ASSERT_EQ(scene->skins.size(), 1u);
    EXPECT_TRUE(scene->skins[0].inverseBinds.empty());
    const core::Deformation& shape = *scene->meshes[0].deformation;
    EXPECT_EQ(shape.joints, (std::vector<uint32_t>{0, 1}));
    EXPECT_EQ(shape.first, (std::vector<uint32_t>{0, 1, 2, 4})) << "weights of 0 are not stored";
    expectPositions(shown(scene), kFollowed);
}

TEST(GltfSkins, FormatsOfJointsAndWeights)
{
    for (const bool wide : {false, true}) {
        for (const int type : {test::kUnsignedByte, test::kUnsignedShort}) {
            test::Document document = skinned();
            if (wide)
                document.attributes()["JOINTS_0"] = document.values<uint16_t>(
                    {0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, test::kUnsignedShort, "VEC4", 4);
            document.attributes()["WEIGHTS_0"] =
                type == test::kUnsignedByte
                    ? document.values<uint8_t>({255, 0, 0, 0, 255, 0, 0, 0, 192, 64, 0, 0}, type,
                                               "VEC4", 4)
                    : document.values<uint16_t>(
                          {65535, 0, 0, 0, 65535, 0, 0, 0, 49152, 16384, 0, 0}, type, "VEC4", 4);
            document.json["accessors"].back()["normalized"] = true;
            const auto scene = test::load(document);
            EXPECT_EQ(scene->warnings.total(), 0u);
            expectPositions(shown(scene), kFollowed);
        }
    }
}

TEST(GltfSkins, EightInfluencesAndInverseBinds)
{
    test::Document document = skinned();
    document.attributes()["WEIGHTS_0"] = document.values<float>(
        {1, 0, 0, 0, 1, 0, 0, 0, 0.25f, 0.25f, 0, 0}, test::kFloat, "VEC4", 4);
    document.attributes()["JOINTS_1"] = document.values<uint8_t>(
        {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, test::kUnsignedByte, "VEC4", 4);
    document.attributes()["WEIGHTS_1"] =
        document.values<float>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.5f}, test::kFloat, "VEC4", 4);
    std::vector<float> binds;
    for (const float x : {-10.0f, 0.0f}) {
        const std::vector<float> matrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, 0, 1, 1};
        binds.insert(binds.end(), matrix.begin(), matrix.end());
    }
    document.json["skins"][0]["inverseBindMatrices"] =
        document.values<float>(binds, test::kFloat, "MAT4", 16);
    const auto scene = test::load(document);
    EXPECT_EQ(scene->warnings.total(), 0u);
    expectPositions(shown(scene), {{0, 0, 1}, {1, 10, 1}, {0, 8.5, 1}});
}

/// Tangents that are made from coordinates double vertices: these follow as their twins do.
TEST(GltfSkins, DoubledVerticesFollowToo)
{
    test::Document document = skinned();
    const std::vector<uint8_t> pixel{128, 128, 255};
    const std::vector<std::byte> image = test::encodeImage("png", 1, 1, 3, pixel);
    const int view = document.view(image.data(), image.size());
    document.json["images"] = Json::array({{{"bufferView", view}, {"mimeType", "image/png"}}});
    document.json["textures"] = Json::array({{{"source", 0}}});
    document.material()["normalTexture"]["index"] = 0;
    document.attributes()["POSITION"] =
        document.values<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, test::kFloat, "VEC3", 3);
    document.attributes()["NORMAL"] =
        document.values<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, test::kFloat, "VEC3", 3);
    document.attributes()["TEXCOORD_0"] =
        document.values<float>({0, 0, 1, 0, 1, 1, 0, 0}, test::kFloat, "VEC2", 2);
    document.attributes()["JOINTS_0"] = document.values<uint8_t>(
        {0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, test::kUnsignedByte, "VEC4", 4);
    document.attributes()["WEIGHTS_0"] = document.values<float>(
        {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, test::kFloat, "VEC4", 4);
    document.primitive()["indices"] =
        document.values<uint16_t>({0, 1, 2, 1, 3, 2}, test::kUnsignedShort, "SCALAR", 1);
    document.primitive()["targets"] =
        Json::array({{{"POSITION", document.values<float>({0, 0, 0, 0, 0, 2, 0, 0, 3, 0, 0, 0},
                                                          test::kFloat, "VEC3", 3)}}});
    const int times = document.values<float>({0, 1}, test::kFloat, "SCALAR", 1);
    const int weights = document.values<float>({0, 1}, test::kFloat, "SCALAR", 1);
    document.json["animations"] = Json::array(
        {{{"channels",
           Json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}})},
          {"samplers", Json::array({{{"input", times}, {"output", weights}}})}}});
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    ASSERT_GT(scene->meshes.at(0).positions.size(), 4u) << "the halves are of two handednesses";
    const std::vector<glm::vec3>& rest = scene->meshes[0].positions;
    const std::vector<glm::dvec3> positions = shown(scene, 1);
    for (size_t v = 0; v < rest.size(); ++v) {
        const bool first = rest[v].x == rest[v].y;  // (0, 0) and (1, 1) follow the first joint
        const glm::dvec3 offset = first               ? glm::dvec3(10, 0, 0)
                                  : rest[v].x == 1.0f ? glm::dvec3(0, 10, 2)
                                                      : glm::dvec3(0, 10, 3);
        EXPECT_LT(glm::distance(positions[v], glm::dvec3(rest[v]) + offset), 1e-5) << v;
    }
}

TEST(GltfSkins, WeightsAreMadeToAddUpToOne)
{
    test::Document document = skinned();
    document.attributes()["WEIGHTS_0"] = document.values<float>(
        {2, 0, 0, 0, 0, 0, 0, 0, 0.375f, 0.125f, 0, 0}, test::kFloat, "VEC4", 4);
    EXPECT_REPAIRED(scaled, document, "ACCESSOR_WEIGHTS_NON_NORMALIZED",
                    "/meshes/0/primitives/0/attributes/WEIGHTS_0");
    expectPositions(shown(scaled), kFollowed);
    EXPECT_EQ(scaled->warnings.total(), 1u);
    document.attributes()["WEIGHTS_0"] = document.values<float>(
        {1, -3, 0, 0, 1, 0, 0, 0, 0.75f, 0.25f, 0, 0}, test::kFloat, "VEC4", 4);
    EXPECT_REPAIRED(negative, document, "ACCESSOR_WEIGHTS_NEGATIVE",
                    "/meshes/0/primitives/0/attributes/WEIGHTS_0");
    expectPositions(shown(negative), kFollowed);
    document.attributes()["WEIGHTS_0"] = document.values<float>(
        {1, kFloatNan, HUGE_VALF, 0, 1, 0, 0, 0, 0.75f, 0.25f, 0, 0}, test::kFloat, "VEC4", 4);
    EXPECT_REPAIRED(infinite, document, "ACCESSOR_INVALID_FLOAT",
                    "/meshes/0/primitives/0/attributes/WEIGHTS_0");
    expectPositions(shown(infinite), kFollowed);
}

/// Whatever cannot be used: the mesh is shown as it is stored, where its node is.
TEST(GltfSkins, UnusableOnesShowTheMeshAsItIsStored)
{
    const auto expectStored = [](const test::Document& document, const char* code,
                                 const std::string& pointer) {
        EXPECT_REPAIRED(scene, document, code, pointer);
        expectPositions(shown(scene), kStored);
    };
    const std::string attributes = "/meshes/0/primitives/0/attributes";
    test::Document d = skinned();
    d.json["skins"][0]["joints"] = {1, 99};
    expectStored(d, "UNRESOLVED_REFERENCE", "/skins/0/joints/1");
    d.json["skins"][0]["joints"] = {1, "a"};
    expectStored(d, "UNRESOLVED_REFERENCE", "/skins/0/joints/1");
    d.json["skins"][0]["joints"] = Json::array();
    expectStored(d, "EMPTY_ENTITY", "/skins/0");
    d.json["skins"][0]["joints"] = {1};
    expectStored(d, "ACCESSOR_JOINTS_INDEX_OOB", "/meshes/0");
    d = skinned();
    d.json["scenes"][0]["nodes"] = {0, 1};
    expectStored(d, "NODE_SKIN_NO_SCENE", "/skins/0/joints/1");
    d = skinned();
    d.attributes().erase("WEIGHTS_0");
    expectStored(d, "MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH", attributes);
    d.attributes().erase("JOINTS_0");
    expectStored(d, "NODE_SKIN_WITH_NON_SKINNED_MESH", attributes);
    d = skinned();
    d.attributes()["JOINTS_0"] =
        d.values<uint8_t>({0, 0, 0, 0, 1, 0, 0, 0}, test::kUnsignedByte, "VEC4", 4);
    expectStored(d, "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", attributes + "/JOINTS_0");
    d = skinned();
    d.attributes()["WEIGHTS_0"] = 0;
    expectStored(d, "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", attributes + "/WEIGHTS_0");
    d = skinned();
    d.json["skins"][0]["inverseBindMatrices"] =
        d.values<float>(std::vector<float>(16, 1), test::kFloat, "MAT4", 16);
    expectStored(d, "INVALID_IBM_ACCESSOR_COUNT", "/skins/0/inverseBindMatrices");
    d.json["skins"][0]["inverseBindMatrices"] =
        d.values<float>(std::vector<float>(32, kFloatNan), test::kFloat, "MAT4", 16);
    expectStored(d, "ACCESSOR_INVALID_FLOAT", "/skins/0/inverseBindMatrices");
    d.json["skins"][0]["inverseBindMatrices"] = 0;
    expectStored(d, "SKIN_IBM_INVALID_FORMAT", "/skins/0/inverseBindMatrices");
    d.json["skins"][0]["inverseBindMatrices"] = 77;
    expectStored(d, "UNRESOLVED_REFERENCE", "/skins/0/inverseBindMatrices");
}

TEST(GltfSkins, DamageThatIsRepaired)
{
    test::Document d = skinned();
    std::vector<float> flat(32, 0);
    for (const size_t i : {0u, 5u, 10u, 16u, 21u, 26u}) flat[i] = 1;
    d.json["skins"][0]["inverseBindMatrices"] = d.values<float>(flat, test::kFloat, "MAT4", 16);
    EXPECT_REPAIRED(rows, d, "ACCESSOR_INVALID_IBM", "/skins/0/inverseBindMatrices");
    expectPositions(shown(rows), kFollowed);
    d = skinned();
    d.attributes()["JOINTS_1"] = 0;
    EXPECT_REPAIRED(second, d, "MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH",
                    "/meshes/0/primitives/0/attributes");
    expectPositions(shown(second), kFollowed);
    d = skinned();
    d.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
        d.values<float>({0, 0, 0}, test::kFloat, "VEC3", 3);
    d.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
    EXPECT_REPAIRED(placed, d, "SKIN_IGNORED", "/skins/0");
    expectPositions(shown(placed), kStored);
}

TEST(GltfSkins, AHundredThousandJointsLoadOrAreRefusedByEstimate)
{
    test::Document d = skinned();
    Json joints = Json::array();
    for (int i = 0; i < 100'000; ++i) joints.push_back(1 + i % 2);
    d.json["skins"][0]["joints"] = joints;
    expectPositions(shown(test::load(d)), kFollowed);
    // Matrices without a buffer view are zeros that cost the file nothing.
    d.json["accessors"].push_back(
        {{"componentType", test::kFloat}, {"count", 100'000}, {"type", "MAT4"}});
    d.json["skins"][0]["inverseBindMatrices"] = d.json["accessors"].size() - 1;
    core::LoadOptions options;
    options.maxMemoryMb = 4;
    EXPECT_EQ(test::refusal(d.text(), options).code, "TOO_LARGE");
}

/// The triangle with two targets, a node of its own weights, and an animation of the other's.
test::Document morphing(const std::vector<float>& weights)
{
    test::Document d = test::triangle();
    d.primitive()["targets"] = Json::array(
        {{{"POSITION", d.values<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, test::kFloat, "VEC3", 3)}},
         {{"POSITION", d.values<float>({0, 0, 0, 0, 8, 0, 0, 0, 0}, test::kFloat, "VEC3", 3)}}});
    d.json["meshes"][0]["weights"] = {0, 0.5};
    d.json["nodes"].push_back({{"mesh", 0}, {"translation", {20, 0, 0}}});
    d.json["scenes"][0]["nodes"] = {0, 1};
    const int input = d.values<float>({0, 2}, test::kFloat, "SCALAR", 1);
    const int output = d.values<float>(weights, test::kFloat, "SCALAR", 1);
    d.json["animations"] = Json::array(
        {{{"channels",
           Json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}})},
          {"samplers", Json::array({{{"input", input}, {"output", output}}})}}});
    return d;
}

TEST(GltfMorphs, WeightsAreAnimated)
{
    const auto scene = test::load(morphing({0, 0, 1, 0.25f}));
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    EXPECT_EQ(scene->animations.at(0).duration, 2.0);
    ASSERT_EQ(scene->meshes.size(), 2u) << "the other node's weights stay, in a rigid mesh";
    EXPECT_TRUE(scene->meshes[0].deformation);
    EXPECT_FALSE(scene->meshes[1].deformation);
    EXPECT_EQ(scene->meshes[0].deformation->targets.at(1).vertices, std::vector<uint32_t>{1})
        << "only what a target changes is stored";
    for (const double time : {0.0, 0.5, 2.0}) {
        const double a = 0.5 * time, b = 0.125 * time;
        std::vector<glm::dvec3> positions = shown(scene, time);
        ASSERT_EQ(positions.size(), 6u);
        if (positions[0].x > 10)
            std::rotate(positions.begin(), positions.begin() + 3, positions.end());
        expectPositions(positions,
                        {{0, 0, a}, {1, 8 * b, a}, {0, 1, a}, {20, 0, 0}, {21, 4, 0}, {20, 1, 0}});
    }
}

/// Exporters write channels of one value: these cost nothing.
TEST(GltfMorphs, ConstantWeightsMakeARigidMesh)
{
    const auto scene = test::load(morphing({1, 0, 1, 0}));
    ASSERT_EQ(scene->meshes.size(), 2u);
    EXPECT_FALSE(scene->meshes[0].deformation);
    EXPECT_EQ(scene->meshes[0].positions[1], glm::vec3(1, 0, 1));
    EXPECT_TRUE(core::makeWorld(scene)->movingTriangles.empty());
}

TEST(GltfMorphs, FaultyTargetsAreIgnoredAndTold)
{
    EXPECT_REPAIRED(count, morphing({0, 0, 1}), "ANIMATION_SAMPLER_INVALID",
                    "/animations/0/samplers/0");
    EXPECT_FALSE(count->meshes[0].deformation);
    test::Document d = morphing({0, 0, 1, 1});
    d.primitive()["targets"][0]["POSITION"] =
        d.values<float>({0, 0, kFloatNan, 0, 0, 1, 0, 0, HUGE_VALF}, test::kFloat, "VEC3", 3);
    EXPECT_REPAIRED(infinite, d, "ACCESSOR_INVALID_FLOAT",
                    "/meshes/0/primitives/0/targets/0/POSITION");
    EXPECT_EQ(infinite->meshes[0].deformation->targets[0].vertices, std::vector<uint32_t>{1});
    d.primitive()["targets"][0]["POSITION"] = d.values<float>({0, 0, 1}, test::kFloat, "VEC3", 3);
    EXPECT_REPAIRED(shorter, d, "MESH_PRIMITIVE_MORPH_TARGET_INVALID",
                    "/meshes/0/primitives/0/targets/0/POSITION");
    EXPECT_EQ(shorter->meshes[0].deformation->targets.size(), 2u);
    d = morphing({0, 0, 1, 1});
    d.json["nodes"][0].erase("mesh");
    EXPECT_REPAIRED(none, d, "ANIMATION_CHANNEL_TARGET_NODE_WEIGHTS_NO_MORPHS",
                    "/animations/0/channels/0/target/path");
}

TEST(GltfMorphs, TargetsAreCountedBeforeTheyAreStored)
{
    test::Document d = morphing({0, 0, 1, 1});
    const size_t vertices = 30'000;
    const std::vector<float> ones(3 * vertices, 1);
    const int positions = d.values<float>(ones, test::kFloat, "VEC3", 3);
    d.json["meshes"][0]["primitives"][0].erase("indices");
    d.attributes()["POSITION"] = positions;
    Json targets = Json::array();
    for (int i = 0; i < 200; ++i) targets.push_back({{"POSITION", positions}});
    d.primitive()["targets"] = targets;
    d.json["meshes"][0].erase("weights");
    const int output = d.values<float>(std::vector<float>(400, 0.5f), test::kFloat, "SCALAR", 1);
    d.json["animations"][0]["samplers"][0]["output"] = output;
    std::vector<float> rising(400, 0);
    rising.back() = 1;
    d.json["animations"][0]["samplers"][0]["output"] =
        d.values<float>(rising, test::kFloat, "SCALAR", 1);
    core::LoadOptions options;
    options.maxMemoryMb = 64;
    const test::Refusal refused = test::refusal(d.text(), options);
    EXPECT_EQ(refused.code, "TOO_LARGE");
    EXPECT_EQ(refused.pointer.find("/meshes/0/primitives/0/targets/"), 0u) << refused.pointer;
}

/// Loads and shows what is left of a damaged file; what the loader lets through must not crash.
void show(const std::string& text)
{
    try {
        core::LoadOptions options;
        options.maxMemoryMb = 64;
        const auto scene = core::loadGltfFromMemory(test::bytesOf(text), "mutant.gltf", options);
        const auto world = core::makeWorld(scene, 0.3);
        core::poseWorld(world, 1.2);
    } catch (const core::Error&) {
    }
}

TEST(GltfMorphs, DamagedDeformationsAreShownOrRefused)
{
    test::Document document = skinned();
    const test::Document other = morphing({0, 0, 1, 1});
    document.primitive()["targets"] = Json::array({{{"POSITION", 0}}, {{"POSITION", 0}}});
    document.json["animations"] = other.json["animations"];
    document.json["animations"][0]["samplers"][0] = {
        {"input", document.values<float>({0, 2}, test::kFloat, "SCALAR", 1)},
        {"output", document.values<float>({0, 0, 1, 1}, test::kFloat, "SCALAR", 1)}};
    document.json["skins"][0]["inverseBindMatrices"] =
        document.values<float>(std::vector<float>(32, 0.5f), test::kFloat, "MAT4", 16);
    document.json["nodes"].push_back({{"mesh", 0}, {"skin", 0}});
    document.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
    const std::vector<std::byte> glb = document.glb();
    const std::string whole(reinterpret_cast<const char*>(glb.data()), glb.size());
    const size_t json = whole.find("BIN") - 8;
    std::mt19937 random(3);
    for (int i = 0; i < 6000; ++i) {
        std::string mutant = whole;
        for (int k = 0; k < 3; ++k) {
            // Digits of the text, or any byte of the content: joints, weights, keys, matrices
            const size_t digit = mutant.find_first_of("0123456789", 20 + random() % (json - 20));
            if (i % 2 == 0 && digit < json)
                mutant[digit] = static_cast<char>('0' + random() % 10);
            else
                mutant[json + 8 + random() % (mutant.size() - json - 8)] =
                    static_cast<char>(random() & 0xffu);
        }
        show(mutant);
    }
}

}  // namespace
