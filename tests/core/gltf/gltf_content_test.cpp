// Valid content becomes exactly the scene that it describes: geometry, materials, textures, nodes,
// lights, animation.
#include "tests/support/scenes/gltf_fixture.h"

#include <cmath>

#include <glm/gtc/packing.hpp>

#include "shared/warp.h"

namespace {

using test::Json;

std::vector<uint8_t> onePixel()
{
    return {128, 128, 255};
}

core::Mesh onlyMesh(const test::Document& document)
{
    const auto scene = test::load(document);
    if (!scene || scene->meshes.size() != 1) {
        ADD_FAILURE() << "no single mesh";
        return {};
    }
    EXPECT_EQ(scene->warnings.total(), 0u);
    return scene->meshes[0];
}

TEST(GltfGeometry, IndexTypesAndNoIndices)
{
    for (const int type : {test::kUnsignedByte, test::kUnsignedShort, test::kUnsignedInt}) {
        test::Document document = test::triangle();
        if (type == test::kUnsignedByte)
            document.primitive()["indices"] =
                document.values<uint8_t>({2, 0, 1}, type, "SCALAR", 1);
        if (type == test::kUnsignedShort)
            document.primitive()["indices"] =
                document.values<uint16_t>({2, 0, 1}, type, "SCALAR", 1);
        if (type == test::kUnsignedInt)
            document.primitive()["indices"] =
                document.values<uint32_t>({2, 0, 1}, type, "SCALAR", 1);
        EXPECT_EQ(onlyMesh(document).triangles, (std::vector<glm::uvec3>{{2, 0, 1}}));
    }
    test::Document document = test::triangle();
    document.primitive().erase("indices");
    const core::Mesh mesh = onlyMesh(document);
    EXPECT_EQ(mesh.triangles, (std::vector<glm::uvec3>{{0, 1, 2}}));
    EXPECT_EQ(mesh.positions, (std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_FALSE(mesh.hasNormals);
    EXPECT_TRUE(mesh.attributes.empty() && mesh.extra.empty()) << "nothing needs them";
}

TEST(GltfGeometry, StripsAndFansKeepTheirFront)
{
    test::Document document = test::triangle();
    document.attributes()["POSITION"] = document.values<float>(
        {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0}, test::kFloat, "VEC3", 3);
    document.primitive().erase("indices");
    document.primitive()["mode"] = 5;
    const core::Mesh strip = onlyMesh(document);
    EXPECT_EQ(strip.triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}));
    for (const glm::uvec3& t : strip.triangles)
        EXPECT_GT(glm::cross(strip.positions[t.y] - strip.positions[t.x],
                             strip.positions[t.z] - strip.positions[t.x])
                      .z,
                  0);
    document.primitive()["mode"] = 6;
    document.primitive()["indices"] =
        document.values<uint16_t>({0, 1, 3, 2}, test::kUnsignedShort, "SCALAR", 1);
    const core::Mesh fan = onlyMesh(document);
    EXPECT_EQ(fan.triangles, (std::vector<glm::uvec3>{{1, 3, 0}, {3, 2, 0}}));
}

TEST(GltfGeometry, OnlyTheRangeOfVerticesInUseIsKept)
{
    test::Document document = test::triangle();
    document.attributes()["POSITION"] = document.values<float>(
        {9, 9, 9, 9, 9, 9, 0, 0, 0, 1, 0, 0, 0, 1, 0, 9, 9, 9}, test::kFloat, "VEC3", 3);
    document.primitive()["indices"] =
        document.values<uint16_t>({2, 3, 4}, test::kUnsignedShort, "SCALAR", 1);
    const core::Mesh mesh = onlyMesh(document);
    EXPECT_EQ(mesh.positions, (std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(mesh.triangles, (std::vector<glm::uvec3>{{0, 1, 2}}));
}

TEST(GltfGeometry, InterleavedAttributes)
{
    test::Document document = test::texturedTriangle(test::encodeImage("png", 1, 1, 3, onePixel()));
    // Per vertex: position, normal, coordinates; 32 bytes apart.
    const std::vector<float> data{0, 0, 0,     0,      0, 1, 0.25f, 0.5f, 1, 0, 0, 0,
                                  1, 0, 0.75f, 0.125f, 0, 1, 0,     1,    0, 0, 1, 2};
    const int view = document.view(data.data(), data.size() * 4, 32);
    const int position = document.accessor(view, test::kFloat, 3, "VEC3"),
              normal = document.accessor(view, test::kFloat, 3, "VEC3"),
              uv = document.accessor(view, test::kFloat, 3, "VEC2");
    document.json["accessors"][static_cast<size_t>(normal)]["byteOffset"] = 12;
    document.json["accessors"][static_cast<size_t>(uv)]["byteOffset"] = 24;
    document.attributes() = {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", uv}};
    const core::Mesh mesh = onlyMesh(document);
    EXPECT_EQ(mesh.positions[1], glm::vec3(1, 0, 0));
    EXPECT_EQ(mesh.attributes[1].normal, shared::packOct(glm::vec3(0, 1, 0)));
    EXPECT_EQ(mesh.attributes[1].u, 0.75f);
    EXPECT_EQ(mesh.attributes[2].v, 2.0f);
    EXPECT_TRUE(mesh.hasNormals && mesh.hasTexCoords && !mesh.hasTangents);
}

TEST(GltfGeometry, QuantisedAttributes)
{
    test::Document document = test::texturedTriangle(test::encodeImage("png", 1, 1, 3, onePixel()));
    document.json["extensionsUsed"] =
        document.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    const std::vector<int16_t> positions{0, 0, 0, 0, 300, -2, 7, 0, 0, 500, 0, 0};
    const int position = document.accessor(document.view(positions.data(), 24, 8), 5122, 3, "VEC3");
    const std::vector<int8_t> normals{0, 0, 127, 0, 127, 0, 0, 0, 0, -127, 0, 0};
    const int normal = document.accessor(document.view(normals.data(), 12, 4), 5120, 3, "VEC3");
    const std::vector<uint16_t> uvs{0, 65535, 13107, 0, 65535, 32768};
    const int uv = document.accessor(document.view(uvs.data(), 12, 4), 5123, 3, "VEC2");
    document.json["accessors"][static_cast<size_t>(normal)]["normalized"] = true;
    document.json["accessors"][static_cast<size_t>(uv)]["normalized"] = true;
    document.attributes() = {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", uv}};
    const core::Mesh mesh = onlyMesh(document);
    EXPECT_EQ(mesh.positions[1], glm::vec3(300, -2, 7));
    EXPECT_EQ(mesh.attributes[2].normal, shared::packOct(glm::vec3(0, -1, 0)));
    EXPECT_EQ(mesh.attributes[0].v, 1.0f);
    EXPECT_NEAR(mesh.attributes[1].u, 0.2, 1e-6);
    EXPECT_NEAR(mesh.attributes[2].v, 32768 / 65535.0, 1e-6);
}

TEST(GltfGeometry, VertexColoursAndTheSecondSet)
{
    test::Document document = test::texturedTriangle(test::encodeImage("png", 1, 1, 3, onePixel()));
    document.attributes()["COLOR_0"] = document.values<uint8_t>(
        {255, 0, 51, 102, 255, 255, 255, 255, 0, 0, 0, 0}, test::kUnsignedByte, "VEC4", 4);
    document.json["accessors"].back()["normalized"] = true;
    core::Mesh mesh = onlyMesh(document);
    ASSERT_EQ(mesh.extra.size(), 3u);
    const glm::vec2 rg = glm::unpackHalf2x16(mesh.extra[0].colorRg),
                    ba = glm::unpackHalf2x16(mesh.extra[0].colorBa);
    EXPECT_EQ(rg, glm::vec2(1, 0));
    EXPECT_NEAR(ba.x, 0.2, 1e-4);
    EXPECT_NEAR(ba.y, 0.4, 3e-4);

    document.attributes()["COLOR_0"] =
        document.values<float>({1, 1, 1, 1, 1, 1, 1, 1, 1}, test::kFloat, "VEC3", 3);
    EXPECT_TRUE(onlyMesh(document).extra.empty()) << "white colours change nothing";

    document.attributes()["TEXCOORD_1"] =
        document.values<float>({5, 6, 7, 8, 9, 10}, test::kFloat, "VEC2", 2);
    EXPECT_TRUE(onlyMesh(document).extra.empty()) << "no texture uses the second set";
    document.material()["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1;
    mesh = onlyMesh(document);
    ASSERT_EQ(mesh.extra.size(), 3u);
    EXPECT_EQ(mesh.extra[1].u1, 7.0f);
    EXPECT_EQ(mesh.extra[1].colorRg, 0x3c003c00u);
}

TEST(GltfGeometry, TangentsFollowTheCoordinates)
{
    // A square in the xy plane, seen from +z. `flip`: v grows upwards instead of down, so the image
    // is mirrored.
    for (const bool flip : {false, true}) {
        test::Document document =
            test::texturedTriangle(test::encodeImage("png", 1, 1, 3, onePixel()));
        document.material()["normalTexture"]["index"] = 0;
        const float top = flip ? 1.0f : 0.0f, bottom = 1 - top;
        document.attributes() = {
            {"POSITION",
             document.values<float>({0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0}, test::kFloat, "VEC3", 3)},
            {"NORMAL",
             document.values<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, test::kFloat, "VEC3", 3)},
            {"TEXCOORD_0", document.values<float>({0, bottom, 1, bottom, 1, top, 0, top},
                                                  test::kFloat, "VEC2", 2)}};
        document.primitive()["indices"] =
            document.values<uint16_t>({0, 1, 2, 0, 2, 3}, test::kUnsignedShort, "SCALAR", 1);
        const core::Mesh mesh = onlyMesh(document);
        ASSERT_TRUE(mesh.hasTangents);
        for (const shared::VertexAttributes& a : mesh.attributes) {
            const glm::vec4 t = shared::unpackTangent(a.tangent);
            EXPECT_NEAR(glm::distance(glm::vec3(t), glm::vec3(1, 0, 0)), 0, 1e-4);
            // The bitangent cross(n, t) w points up in the image, which is down in v.
            EXPECT_EQ(t.w, flip ? -1.0f : 1.0f);
        }
        document.attributes()["TANGENT"] = document.values<float>(
            {0, 1, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1}, test::kFloat, "VEC4", 4);
        const glm::vec4 given = shared::unpackTangent(onlyMesh(document).attributes[3].tangent);
        EXPECT_NEAR(given.y, 1, 1e-4);
        EXPECT_EQ(given.w, -1.0f);
    }
}

/// A map that is laid over the surface turned or mirrored (KHR_texture_transform) has its tangents
/// turned or mirrored with it.
TEST(GltfGeometry, TangentsFollowTheTransformOfTheMap)
{
    struct Case {
        test::Json transform;
        glm::vec3 tangent;
        float handedness;
    };
    for (const Case& c : {Case{{{"rotation", 1.5707963267948966}}, {0, -1, 0}, 1},
                          Case{{{"scale", {-2, 3}}, {"offset", {0.5, 0.25}}}, {-1, 0, 0}, -1}}) {
        test::Document document =
            test::texturedTriangle(test::encodeImage("png", 1, 1, 3, onePixel()));
        document.material()["normalTexture"] = {
            {"index", 0}, {"extensions", {{"KHR_texture_transform", c.transform}}}};
        document.attributes() = {
            {"POSITION",
             document.values<float>({0, 0, 0, 2, 0, 0, 0, 2, 0}, test::kFloat, "VEC3", 3)},
            {"NORMAL",
             document.values<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, test::kFloat, "VEC3", 3)},
            {"TEXCOORD_0", document.values<float>({0, 1, 1, 1, 0, 0}, test::kFloat, "VEC2", 2)}};
        for (const shared::VertexAttributes& a : onlyMesh(document).attributes) {
            const glm::vec4 t = shared::unpackTangent(a.tangent);
            EXPECT_NEAR(glm::distance(glm::vec3(t), c.tangent), 0, 1e-4) << c.transform;
            EXPECT_EQ(t.w, c.handedness);
        }
    }
}

TEST(GltfGeometry, MirroredHalvesShareNoTangent)
{
    // Two squares side by side; u grows towards the edge in the middle from both sides.
    test::Document document = test::texturedTriangle(test::encodeImage("png", 1, 1, 3, onePixel()));
    document.material()["normalTexture"]["index"] = 0;
    document.attributes() = {
        {"POSITION", document.values<float>({0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0},
                                            test::kFloat, "VEC3", 3)},
        {"NORMAL", document.values<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1},
                                          test::kFloat, "VEC3", 3)},
        {"TEXCOORD_0",
         document.values<float>({0, 1, 1, 1, 0, 1, 0, 0, 1, 0, 0, 0}, test::kFloat, "VEC2", 2)}};
    document.primitive()["indices"] = document.values<uint16_t>(
        {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4}, test::kUnsignedShort, "SCALAR", 1);
    const core::Mesh mesh = onlyMesh(document);
    EXPECT_EQ(mesh.positions.size(), 8u) << "the two vertices of the edge are doubled";
    ASSERT_EQ(mesh.attributes.size(), 8u);
    ASSERT_EQ(mesh.triangles.size(), 4u);
    for (size_t i = 0; i < 4; ++i) {
        const bool left = i < 2;
        for (int k = 0; k < 3; ++k) {
            const uint32_t v = mesh.triangles[i][k];
            const glm::vec4 t = shared::unpackTangent(mesh.attributes[v].tangent);
            EXPECT_NEAR(t.x, left ? 1 : -1, 1e-4);
            EXPECT_EQ(t.w, left ? 1.0f : -1.0f);
            EXPECT_EQ(mesh.positions[v].x <= 1, left || mesh.positions[v].x == 1);
        }
    }
}

TEST(GltfGeometry, MorphTargetsApplyTheirDefaultWeights)
{
    test::Document document = test::triangle();
    document.primitive()["targets"] = Json::array(
        {{{"POSITION",
           document.values<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, test::kFloat, "VEC3", 3)}},
         {{"POSITION",
           document.values<float>({0, 8, 0, 0, 8, 0, 0, 8, 0}, test::kFloat, "VEC3", 3)}}});
    EXPECT_EQ(onlyMesh(document).positions[1], glm::vec3(1, 0, 0)) << "weights are zero by default";
    document.json["meshes"][0]["weights"] = {0.5, 0.25};
    EXPECT_EQ(onlyMesh(document).positions[1], glm::vec3(1, 2, 0.5f));
    document.json["nodes"][0]["weights"] = {1, 0};
    document.json["nodes"].push_back({{"mesh", 0}});
    document.json["scenes"][0]["nodes"] = {0, 1};
    const auto scene = test::load(document);
    ASSERT_EQ(scene->meshes.size(), 2u) << "the node's own weights make another mesh";
    EXPECT_EQ(scene->meshes[scene->nodes[0].meshes.begin].positions[1], glm::vec3(1, 0, 1));
    EXPECT_EQ(scene->meshes[scene->nodes[1].meshes.begin].positions[1], glm::vec3(1, 2, 0.5f));
}

TEST(GltfGeometry, MeshesAreSharedAndUnusedOnesAreNotLoaded)
{
    test::Document document = test::triangle();
    document.json["meshes"].push_back(document.json["meshes"][0]);
    document.json["materials"] = Json::array({{{"name", "unused"}}, {{"name", "used"}}});
    document.primitive()["material"] = 1;
    document.json["nodes"] =
        Json::parse(R"([{"mesh":0},{"mesh":0},{"mesh":1,"name":"of another scene"}])");
    document.json["scenes"][0]["nodes"] = {0, 1};
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    EXPECT_EQ(scene->meshes.size(), 1u);
    EXPECT_EQ(scene->nodes.size(), 2u);
    EXPECT_EQ(scene->nodes[0].meshes, (core::IndexRange{0, 1}));
    EXPECT_EQ(scene->nodes[1].meshes, (core::IndexRange{0, 1}));
    ASSERT_EQ(scene->materials.size(), 1u);
    EXPECT_EQ(scene->materials[0].name, "used");
}

TEST(GltfNodes, HierarchyTransformsCamerasAndLights)
{
    test::Document document = test::triangle();
    document.json["cameras"] = Json::parse(
        R"([{"name":"wide","type":"perspective","perspective":{"yfov":1.25,"aspectRatio":1.5,"znear":0.1},
        "extras":{"apertureRadius":0.02,"focusDistance":3}},{"type":"orthographic","orthographic":{"xmag":4,"ymag":2,"znear":0,"zfar":10}}])");
    document.json["extensions"]["KHR_lights_punctual"]["lights"] =
        Json::parse(R"([{"type":"point","color":[1,0.5,0],"intensity":10},
        {"type":"directional"},{"name":"beam","type":"spot","range":7,"spot":{"innerConeAngle":0.1,"outerConeAngle":0.3}}])");
    document.json["nodes"] = Json::parse(
        R"([{"name":"root","children":[2,1],"translation":[1,2,3],"rotation":[0,1,0,0],"scale":[2,2,2]},
        {"name":"ortho","camera":1,"extensions":{"KHR_lights_punctual":{"light":2}}},
        {"mesh":0,"camera":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,7,8,9,1]}])");
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    ASSERT_EQ(scene->nodes.size(), 3u);
    EXPECT_EQ(scene->nodes[0].parent, -1);
    EXPECT_EQ(scene->nodes[1].parent, 0) << "in the file's order of children, parents first";
    EXPECT_EQ(scene->nodes[2].parent, 0);
    const core::Transform& local = std::get<core::Transform>(scene->nodes[0].local);
    EXPECT_EQ(local.translation, glm::dvec3(1, 2, 3));
    EXPECT_EQ(local.rotation, glm::dquat(0, 0, 1, 0));
    EXPECT_EQ(local.scale, glm::dvec3(2));
    EXPECT_EQ(std::get<glm::dmat4x3>(scene->nodes[1].local)[3], glm::dvec3(7, 8, 9));

    ASSERT_EQ(scene->cameras.size(), 2u);
    EXPECT_EQ(scene->cameras[0].name, "wide");
    EXPECT_EQ(scene->cameras[0].node, 1);
    EXPECT_EQ(scene->cameras[0].yfov, 1.25);
    EXPECT_EQ(scene->cameras[0].aspect, 1.5);
    EXPECT_EQ(scene->cameras[0].apertureRadius, 0.02);
    EXPECT_EQ(scene->cameras[0].focusDistance, 3.0);
    EXPECT_EQ(scene->cameras[1].name, "ortho") << "an unnamed camera is called after its node";
    EXPECT_TRUE(scene->cameras[1].orthographic);
    EXPECT_EQ(scene->cameras[1].ymag, 2.0);
    EXPECT_EQ(scene->cameras[1].aspect, 2.0);

    ASSERT_EQ(scene->lights.size(), 3u);
    EXPECT_EQ(scene->lights[0].kind, shared::kEmitterPoint);
    EXPECT_EQ(scene->lights[0].color, glm::vec3(1, 0.5f, 0));
    EXPECT_EQ(scene->lights[0].intensity, 10.0f);
    EXPECT_EQ(scene->lights[1].kind, shared::kEmitterDirectional);
    const core::PunctualLight& spot = scene->lights[static_cast<size_t>(scene->nodes[2].light)];
    EXPECT_EQ(spot.kind, shared::kEmitterSpot);
    EXPECT_EQ(spot.innerCone, 0.1f);
    EXPECT_EQ(spot.outerCone, 0.3f);
    EXPECT_EQ(spot.range, 7.0f);
}

/// The triangle with an animation of its node. `width`: components of a value.
test::Document animated(const char* path, const char* interpolation,
                        const std::vector<float>& times, const std::vector<float>& values,
                        size_t width)
{
    test::Document document = test::triangle();
    const int input = document.values(times, test::kFloat, "SCALAR", 1);
    const int output = document.values(values, test::kFloat, width == 4 ? "VEC4" : "VEC3", width);
    document.json["animations"] = Json::array(
        {{{"name", "move"},
          {"channels", Json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}})},
          {"samplers",
           Json::array(
               {{{"input", input}, {"output", output}, {"interpolation", interpolation}}})}}});
    return document;
}

/// Exporters write one for each object.
TEST(GltfAnimations, ThoseOfDifferentNodesArePlayedTogether)
{
    test::Document document = animated("translation", "STEP", {0, 2.5f}, {1, 2, 3, 4, 5, 6}, 3);
    Json& animations = document.json["animations"];
    Json other = animations[0];
    other["channels"][0]["target"]["path"] = "scale";
    animations.push_back(other);
    animations.push_back(other);  // the same once more
    EXPECT_REPAIRED(scene, document, "ANIMATION_IGNORED", "/animations/2");
    ASSERT_EQ(scene->animations.size(), 2u);
    EXPECT_EQ(scene->animations[0].channels.size(), 2u);
}

TEST(GltfAnimations, ChannelsKeepKeysAndInterpolation)
{
    using Channel = core::AnimationChannel;
    const auto step = test::load(animated("translation", "STEP", {0, 2.5f}, {1, 2, 3, 4, 5, 6}, 3));
    ASSERT_EQ(step->animations.size(), 1u);
    EXPECT_EQ(step->warnings.total(), 0u);
    EXPECT_EQ(step->animations[0].name, "move");
    EXPECT_EQ(step->animations[0].duration, 2.5);
    const Channel& channel = step->animations[0].channels.at(0);
    EXPECT_EQ(channel.node, 0);
    EXPECT_EQ(channel.path, Channel::Path::translation);
    EXPECT_EQ(channel.interpolation, Channel::Interpolation::step);
    EXPECT_EQ(channel.keys->times, (std::vector<float>{0, 2.5f}));
    EXPECT_EQ(channel.keys->values.at(1), glm::vec4(4, 5, 6, 0));
    const auto linear =
        test::load(animated("rotation", "LINEAR", {0, 1}, {0, 0, 0, 2, 0, 1, 0, 0}, 4));
    EXPECT_EQ(linear->animations.at(0).channels.at(0).interpolation,
              Channel::Interpolation::linear);
    EXPECT_EQ(linear->animations[0].channels[0].keys->values[0], glm::vec4(0, 0, 0, 1))
        << "unit length";
    const auto cubic =
        test::load(animated("scale", "CUBICSPLINE", {0, 1}, std::vector<float>(18, 3), 3));
    EXPECT_EQ(cubic->animations.at(0).channels.at(0).interpolation,
              Channel::Interpolation::cubicSpline);
    EXPECT_EQ(cubic->animations[0].channels[0].keys->values.size(), 6u);
}

TEST(GltfAnimations, FaultyChannelsAreIgnoredAndTold)
{
    EXPECT_REPAIRED(backwards, animated("translation", "LINEAR", {1, 0}, {1, 2, 3, 4, 5, 6}, 3),
                    "ANIMATION_SAMPLER_INVALID", "/animations/0/samplers/0");
    EXPECT_TRUE(backwards->animations.empty());
    EXPECT_REPAIRED(counts, animated("translation", "CUBICSPLINE", {0, 1}, {1, 2, 3, 4, 5, 6}, 3),
                    "ANIMATION_SAMPLER_INVALID", "/animations/0/samplers/0");
    EXPECT_REPAIRED(width, animated("rotation", "LINEAR", {0, 1}, {1, 2, 3, 4, 5, 6}, 3),
                    "ANIMATION_SAMPLER_INVALID", "/animations/0/samplers/0");
    EXPECT_REPAIRED(zero, animated("rotation", "LINEAR", {0, 1}, {0, 0, 0, 0, 0, 0, 0, 1}, 4),
                    "ANIMATION_SAMPLER_INVALID", "/animations/0/samplers/0");
    EXPECT_REPAIRED(infinite, animated("scale", "LINEAR", {0, 1}, {1, 1, 1, HUGE_VALF, 1, 1}, 3),
                    "ANIMATION_SAMPLER_INVALID", "/animations/0/samplers/0");
    EXPECT_REPAIRED(unknown, animated("translation", "WOBBLE", {0, 1}, {1, 2, 3, 4, 5, 6}, 3),
                    "VALUE_NOT_IN_LIST", "/animations/0/samplers/0/interpolation");
    EXPECT_REPAIRED(morph, animated("weights", "LINEAR", {0, 1}, {1, 2, 3, 4, 5, 6}, 3),
                    "ANIMATION_CHANNEL_TARGET_NODE_WEIGHTS_NO_MORPHS",
                    "/animations/0/channels/0/target/path");
    test::Document matrix = animated("translation", "LINEAR", {0, 1}, {1, 2, 3, 4, 5, 6}, 3);
    matrix.json["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    EXPECT_REPAIRED(fixed, matrix, "ANIMATION_CHANNEL_TARGET_NODE_MATRIX",
                    "/animations/0/channels/0/target/node");
    test::Document broken = animated("translation", "LINEAR", {0, 1}, {1, 2, 3, 4, 5, 6}, 3);
    broken.json["animations"][0]["channels"][0]["sampler"] = 4;
    EXPECT_REFUSED(broken.text(), "UNRESOLVED_REFERENCE", "/animations/0/channels/0/sampler");
}

}  // namespace
