// Damaged structure is refused: buffers, views, accessors, primitives, nodes (B13-B27, B50-B56,
// B59, B60, B62, B63, B65, B69-B71, B75, B76, B79, B80).
#include "tests/support/scenes/gltf_fixture.h"

namespace {

using test::Json;

/// The triangle with one value changed, given by JSON pointer.
std::string changed(const char* pointer, const Json& value)
{
    test::Document document = test::triangle();
    document.json[Json::json_pointer(pointer)] = value;
    return document.text();
}

const Json kWrapping = uint64_t{0} - 8;

TEST(GltfAccessors, ExtentsAreCheckedIn64Bits)
{
    EXPECT_REFUSED(changed("/accessors/0/count", 4), "ACCESSOR_TOO_LONG", "/accessors/0");
    EXPECT_REFUSED(changed("/accessors/0/count", 2147483648u), "ACCESSOR_TOO_LONG", "/accessors/0");
    EXPECT_REFUSED(changed("/accessors/0/count", uint64_t{1} << 63), "ACCESSOR_TOO_LONG",
                   "/accessors/0");
    EXPECT_REFUSED(changed("/accessors/0/byteOffset", kWrapping), "ACCESSOR_TOO_LONG",
                   "/accessors/0");
    EXPECT_REFUSED(changed("/accessors/0/byteOffset", 4), "ACCESSOR_TOO_LONG", "/accessors/0");
    EXPECT_REFUSED(changed("/bufferViews/0/byteOffset", kWrapping), "BUFFER_VIEW_TOO_LONG",
                   "/bufferViews/0");
    EXPECT_REFUSED(changed("/bufferViews/0/byteLength", 1200), "BUFFER_VIEW_TOO_LONG",
                   "/bufferViews/0");
    EXPECT_REFUSED(changed("/bufferViews/0/byteStride", 252), "ACCESSOR_TOO_LONG", "/accessors/0");
    EXPECT_EQ(
        test::refusal(changed("/accessors/0/count", 4)).message,
        "test.gltf: /accessors/0: needs 48 bytes at offset 0, bufferView 0 has 36 — file refused");
}

TEST(GltfAccessors, CountsMustBeWholeAndPositive)
{
    for (const Json& value : {Json(-1), Json(3.5), Json("3"), Json(nullptr), Json(1e300)})
        EXPECT_REFUSED(changed("/accessors/0/count", value), "TYPE_MISMATCH", "/accessors/0/count");
    EXPECT_REFUSED(changed("/accessors/0/count", 0), "VALUE_NOT_IN_RANGE", "/accessors/0/count");
    EXPECT_REFUSED(changed("/accessors/0/byteOffset", -4), "TYPE_MISMATCH",
                   "/accessors/0/byteOffset");
    EXPECT_TRUE(test::loadText(changed("/accessors/0/count", 3.0))) << "3.0 is a whole number";
}

TEST(GltfAccessors, ReferencesMustResolve)
{
    EXPECT_REFUSED(changed("/accessors/0/bufferView", 99), "UNRESOLVED_REFERENCE",
                   "/accessors/0/bufferView");
    EXPECT_REFUSED(changed("/accessors/0/bufferView", -1), "TYPE_MISMATCH",
                   "/accessors/0/bufferView");
    EXPECT_REFUSED(changed("/bufferViews/0/buffer", 7), "UNRESOLVED_REFERENCE",
                   "/bufferViews/0/buffer");
}

TEST(GltfAccessors, TypesAndStridesMustBeKnown)
{
    for (const Json& value : {Json(5124), Json(5130), Json(0)})
        EXPECT_REFUSED(changed("/accessors/0/componentType", value), "VALUE_NOT_IN_LIST",
                       "/accessors/0/componentType");
    EXPECT_REFUSED(changed("/accessors/0/type", "VEC5"), "VALUE_NOT_IN_LIST", "/accessors/0/type");
    for (const Json& value : {Json(1), Json(2147483648u), Json(256)})
        EXPECT_REFUSED(changed("/bufferViews/0/byteStride", value), "VALUE_NOT_IN_RANGE",
                       "/bufferViews/0/byteStride");
    EXPECT_REFUSED(changed("/bufferViews/0/byteStride", 8), "ACCESSOR_SMALL_BYTESTRIDE",
                   "/accessors/0");
}

TEST(GltfAccessors, ZerosWithoutAViewAreBounded)
{
    test::Document document = test::triangle();
    document.json["accessors"][0].erase("bufferView");
    EXPECT_TRUE(test::load(document)) << "zeros are allowed";
    document.json["accessors"][0]["count"] = 2147483648u;
    EXPECT_REFUSED(document.text(), "ACCESSOR_TOO_LONG", "/accessors/0");
}

TEST(GltfAccessors, SparseIsCheckedCompletely)
{
    test::Document good = test::triangle();
    const std::vector<uint16_t> indices{1, 2};
    const std::vector<float> values{2, 0, 0, 0, 2, 0};
    const int indexView = good.view(indices.data(), 4), valueView = good.view(values.data(), 24);
    good.json["accessors"][0]["sparse"] = {
        {"count", 2},
        {"indices", {{"bufferView", indexView}, {"componentType", 5123}}},
        {"values", {{"bufferView", valueView}}}};
    const auto scene = test::load(good);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->meshes[0].positions[0], glm::vec3(0));
    EXPECT_EQ(scene->meshes[0].positions[1], glm::vec3(2, 0, 0));
    EXPECT_EQ(scene->meshes[0].positions[2], glm::vec3(0, 2, 0));

    // Of a range of vertices those entries that lie in it, wherever it begins
    for (uint16_t first = 0; first < 3; ++first) {
        test::Document range = good;
        range.primitive()["indices"] = range.values<uint16_t>(
            {first, uint16_t(std::min(first + 1, 2)), 2}, test::kUnsignedShort, "SCALAR", 1);
        const auto part = test::load(range);
        ASSERT_TRUE(part);
        for (size_t v = 0; v + first < 3; ++v)
            EXPECT_EQ(part->meshes[0].positions.at(v), scene->meshes[0].positions[v + first]);
    }

    const auto damaged = [&](const char* pointer, const Json& value) {
        test::Document document = good;
        document.json["accessors"][0]["sparse"][Json::json_pointer(pointer)] = value;
        return document.text();
    };
    const std::string sparse = "/accessors/0/sparse";
    EXPECT_REFUSED(damaged("/count", 1000000000), "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE",
                   sparse + "/count");
    EXPECT_REFUSED(damaged("/count", 0), "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE", sparse + "/count");
    EXPECT_REFUSED(damaged("/count", 3), "ACCESSOR_TOO_LONG", sparse + "/indices");
    EXPECT_REFUSED(damaged("/indices/bufferView", 99), "UNRESOLVED_REFERENCE",
                   sparse + "/indices/bufferView");
    EXPECT_REFUSED(damaged("/values/bufferView", 99), "UNRESOLVED_REFERENCE",
                   sparse + "/values/bufferView");
    EXPECT_REFUSED(damaged("/indices/componentType", 5126), "VALUE_NOT_IN_LIST",
                   sparse + "/indices/componentType");
    EXPECT_REFUSED(damaged("/values/byteOffset", 4), "ACCESSOR_TOO_LONG", sparse + "/values");
    EXPECT_REFUSED(damaged("/values", Json::array()), "TYPE_MISMATCH", sparse + "/values");

    const auto withIndices = [&](uint16_t a, uint16_t b) {
        test::Document document = good;
        const uint16_t pair[2] = {a, b};
        std::memcpy(document.bin.data() +
                        document.json["bufferViews"][static_cast<size_t>(indexView)]["byteOffset"]
                            .get<size_t>(),
                    pair, 4);
        return document.text();
    };
    EXPECT_REFUSED(withIndices(2, 1), "ACCESSOR_SPARSE_INDICES_NON_INCREASING",
                   sparse + "/indices");
    EXPECT_REFUSED(withIndices(1, 1), "ACCESSOR_SPARSE_INDICES_NON_INCREASING",
                   sparse + "/indices");
    EXPECT_REFUSED(withIndices(1, 3), "ACCESSOR_SPARSE_INDEX_OOB", sparse + "/indices");
}

TEST(GltfBuffers, LengthsAndDataUrisAreChecked)
{
    const auto withBuffer = [](const Json& length, const std::string& uri) {
        test::Document document = test::triangle();
        document.json["buffers"] = Json::array({{{"byteLength", length}, {"uri", uri}}});
        return document.text();
    };
    const test::Document document = test::triangle();
    const std::string content = test::base64(document.bin);
    const std::string head = "data:application/octet-stream;base64,";
    EXPECT_TRUE(test::loadText(withBuffer(document.bin.size(), head + content)));
    EXPECT_REFUSED(withBuffer(1'000'000'000'000, head + content), "BUFFER_BYTE_LENGTH_MISMATCH",
                   "/buffers/0/byteLength");
    EXPECT_REFUSED(withBuffer(0, head + content), "VALUE_NOT_IN_RANGE", "/buffers/0/byteLength");
    EXPECT_REFUSED(withBuffer(44, head + "A***" + content.substr(4)), "IO_ERROR", "/buffers/0/uri");
    EXPECT_REFUSED(withBuffer(44, head + content.substr(0, 5)), "IO_ERROR", "/buffers/0/uri");
    EXPECT_REFUSED(withBuffer(44, "data:"), "IO_ERROR", "/buffers/0/uri");
    EXPECT_REFUSED(withBuffer(44, head), "IO_ERROR", "/buffers/0/uri");
    EXPECT_REFUSED(withBuffer(44, "other.bin"), "IO_ERROR", "/buffers/0/uri");
    test::Document without = test::triangle();
    without.json["buffers"] = Json::array({{{"byteLength", 44}}});
    EXPECT_REFUSED(without.text(), "UNDEFINED_PROPERTY", "/buffers/0");
}

TEST(GltfNodes, LoopsAreRefused)
{
    EXPECT_REFUSED(changed("/nodes/0/children", {0}), "NODE_LOOP", "/nodes/0/children/0");
    EXPECT_REFUSED(
        changed("/nodes", Json::parse(R"([{"children":[1]},{"children":[0],"mesh":0}])")),
        "NODE_LOOP", "/nodes/0");
    EXPECT_REFUSED(
        changed("/nodes",
                Json::parse(R"([{"mesh":0},{"children":[2]},{"children":[3]},{"children":[1]}])")),
        "NODE_LOOP", "/nodes/1");
}

TEST(GltfNodes, SecondParentsAreIgnored)
{
    test::Document document = test::triangle();
    document.json["nodes"] = Json::parse(R"([{"children":[1,1]},{"mesh":0}])");
    EXPECT_REPAIRED(twice, document, "NODE_PARENT_OVERRIDE", "/nodes/0/children/1");
    EXPECT_EQ(twice->nodes.size(), 2u);
    EXPECT_EQ(twice->nodes[1].parent, 0);

    document.json["nodes"] = Json::parse(R"([{"children":[2]},{"children":[2]},{"mesh":0}])");
    document.json["scenes"][0]["nodes"] = {0, 1};
    EXPECT_REPAIRED(two, document, "NODE_PARENT_OVERRIDE", "/nodes/1/children/0");
    EXPECT_EQ(two->nodes.size(), 3u);
}

TEST(GltfNodes, DoubledChildrenDoNotExplode)
{
    test::Document document = test::triangle();
    document.json["nodes"] = Json::array();
    for (int i = 0; i < 30; ++i) document.json["nodes"].push_back({{"children", {i + 1, i + 1}}});
    document.json["nodes"].push_back({{"mesh", 0}});
    EXPECT_REPAIRED(scene, document, "NODE_PARENT_OVERRIDE", "/nodes/0/children/1");
    EXPECT_EQ(scene->nodes.size(), 31u);
    ASSERT_EQ(scene->warnings.counts.size(), 1u);
    EXPECT_EQ(scene->warnings.counts[0].count, 30u);
    EXPECT_EQ(scene->warnings.listed.size(), 10u) << "the first ten are kept";
}

TEST(GltfNodes, DepthIsBounded)
{
    const auto chain = [](int length) {
        test::Document document = test::triangle();
        document.json["nodes"] = Json::array();
        for (int i = 0; i + 1 < length; ++i)
            document.json["nodes"].push_back({{"children", {i + 1}}});
        document.json["nodes"].push_back({{"mesh", 0}});
        return document.text();
    };
    EXPECT_TRUE(test::loadText(chain(4097)));
    EXPECT_REFUSED(chain(4098), "NODE_TOO_DEEP", "/nodes/4097");
    EXPECT_REFUSED(chain(200'000), "NODE_TOO_DEEP", "/nodes/4097");
}

TEST(GltfNodes, ReferencesMustResolve)
{
    EXPECT_REFUSED(changed("/nodes/0/children", {99}), "UNRESOLVED_REFERENCE",
                   "/nodes/0/children/0");
    EXPECT_REFUSED(changed("/nodes/0/children", {"a"}), "TYPE_MISMATCH", "/nodes/0/children/0");
    EXPECT_REFUSED(changed("/nodes/0/mesh", 42), "UNRESOLVED_REFERENCE", "/nodes/0/mesh");
    EXPECT_REFUSED(changed("/nodes/0/skin", 1), "UNRESOLVED_REFERENCE", "/nodes/0/skin");
    EXPECT_REFUSED(changed("/scene", 5), "UNRESOLVED_REFERENCE", "/scene");
    EXPECT_REFUSED(changed("/scenes/0/nodes", {77}), "UNRESOLVED_REFERENCE", "/scenes/0/nodes/0");
    EXPECT_REFUSED(changed("/scenes/0/nodes", 0), "TYPE_MISMATCH", "/scenes/0/nodes");
}

TEST(GltfNodes, MatricesHaveSixteenNumbersAndNoCompany)
{
    Json sixteen = Json::array(), three = {1, 0, 0};
    for (int i = 0; i < 16; ++i) sixteen.push_back(i % 5 == 0 ? 1 : 0);
    Json seventeen = sixteen;
    seventeen.push_back(0);
    EXPECT_TRUE(test::loadText(changed("/nodes/0/matrix", sixteen)));
    EXPECT_REFUSED(changed("/nodes/0/matrix", three), "ARRAY_LENGTH_NOT_IN_LIST",
                   "/nodes/0/matrix");
    EXPECT_REFUSED(changed("/nodes/0/matrix", seventeen), "ARRAY_LENGTH_NOT_IN_LIST",
                   "/nodes/0/matrix");
    EXPECT_REFUSED(changed("/nodes/0/rotation", three), "ARRAY_LENGTH_NOT_IN_LIST",
                   "/nodes/0/rotation");
    test::Document both = test::triangle();
    both.json["nodes"][0]["matrix"] = sixteen;
    both.json["nodes"][0]["scale"] = {1, 1, 1};
    EXPECT_REFUSED(both.text(), "NODE_MATRIX_TRS", "/nodes/0");
}

TEST(GltfNodes, AMillionNodesLoadOrAreRefusedByEstimate)
{
    std::string text = R"({"asset":{"version":"2.0"},"nodes":[{})";
    for (int i = 1; i < 1'000'000; ++i) text += ",{}";
    text += "]}";
    core::LoadOptions options;
    options.maxMemoryMb = 512;
    const auto scene = test::loadText(text, options);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->nodes.size(), 1'000'000u);
    options.maxMemoryMb = 32;
    const test::Refusal refused = test::refusal(text, options);
    EXPECT_EQ(refused.code, "TOO_LARGE");
    EXPECT_NE(refused.message.find("--max-memory-mb"), std::string::npos);
    options.maxMemoryMb = 128;  // enough for the text and its tree
    EXPECT_EQ(test::refusal(text, options).pointer, "/nodes");
}

/// So many nodes that show one mesh; the last of them is `last`.
std::string manyNodes(size_t count, const std::string& last)
{
    test::Document document = test::triangle();
    document.json["nodes"] = Json::array({"NODES"});
    document.json["scenes"] = Json::parse(R"([{"nodes":"ROOTS"}])");
    std::string nodes, roots = "[0";
    for (size_t i = 0; i + 1 < count; ++i)
        nodes += R"({"name":"leaf","mesh":0,"translation":[1,0.5,)" + std::to_string(i) + "]},";
    for (size_t i = 1; i < count; ++i) roots += ',' + std::to_string(i);
    std::string text = document.text();
    text.replace(text.find("\"NODES\""), 7, nodes + last);
    text.replace(text.find("\"ROOTS\""), 7, roots + "]");
    return text;
}

TEST(GltfNodes, AMillionShowOneMesh)
{
    constexpr size_t kCount = 1'000'000;
    const auto scene = test::loadText(manyNodes(kCount, R"({"mesh":0,"scale":[2,2,2]})"));
    ASSERT_TRUE(scene);
    ASSERT_EQ(scene->nodes.size(), kCount);
    EXPECT_EQ(scene->warnings.total(), 0u);
    EXPECT_EQ(std::get<core::Transform>(scene->nodes[kCount - 2].local).translation,
              glm::dvec3(1, 0.5, kCount - 2));
    EXPECT_EQ(std::get<core::Transform>(scene->nodes[kCount - 1].local).scale, glm::dvec3(2));
    EXPECT_EQ(scene->nodes[kCount - 1].meshes, scene->nodes[0].meshes);
}

TEST(GltfNodes, FaultsAmongManyHaveTheirPlace)
{
    EXPECT_REFUSED(manyNodes(100'000, R"({"mesh":1})"), "UNRESOLVED_REFERENCE",
                   "/nodes/99999/mesh");
    EXPECT_REFUSED(manyNodes(100'000, R"({"children":[7,100000]})"), "UNRESOLVED_REFERENCE",
                   "/nodes/99999/children/1");
    EXPECT_REFUSED(manyNodes(100'000, "[]"), "TYPE_MISMATCH", "/nodes/99999");
}

TEST(GltfPrimitives, IndicesMustBeUnsignedAndInRange)
{
    const auto withIndices = [](const std::vector<uint16_t>& indices) {
        test::Document document = test::triangle();
        document.primitive()["indices"] =
            document.values(indices, test::kUnsignedShort, "SCALAR", 1);
        return document.text();
    };
    EXPECT_TRUE(test::loadText(withIndices({2, 1, 0})));
    EXPECT_REFUSED(withIndices({0, 1, 3}), "ACCESSOR_INDEX_OOB", "/accessors/2");
    EXPECT_REFUSED(withIndices({0, 1, 65535}), "ACCESSOR_INDEX_OOB", "/accessors/2");
    EXPECT_REFUSED(changed("/meshes/0/primitives/0/indices", 1000000), "UNRESOLVED_REFERENCE",
                   "/meshes/0/primitives/0/indices");
    EXPECT_REFUSED(changed("/meshes/0/primitives/0/indices", 0),
                   "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT",
                   "/meshes/0/primitives/0/indices");
    EXPECT_REFUSED(changed("/accessors/1/componentType", 5122),
                   "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT",
                   "/meshes/0/primitives/0/indices");
}

TEST(GltfPrimitives, ModesAndAttributesMustBeKnown)
{
    EXPECT_REFUSED(changed("/meshes/0/primitives/0/mode", 99), "VALUE_NOT_IN_LIST",
                   "/meshes/0/primitives/0/mode");
    EXPECT_REFUSED(changed("/meshes/0/primitives/0/mode", 7), "VALUE_NOT_IN_LIST",
                   "/meshes/0/primitives/0/mode");
    const std::string position = "/meshes/0/primitives/0/attributes/POSITION";
    EXPECT_REFUSED(changed(position.c_str(), -5), "TYPE_MISMATCH", position);
    EXPECT_REFUSED(changed(position.c_str(), "zero"), "TYPE_MISMATCH", position);
    EXPECT_REFUSED(changed(position.c_str(), 9), "UNRESOLVED_REFERENCE", position);
    EXPECT_REFUSED(changed(position.c_str(), 1),
                   "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", position);
    EXPECT_REFUSED(changed("/meshes/0/primitives/0/attributes/_A", 9), "UNRESOLVED_REFERENCE",
                   "/meshes/0/primitives/0/attributes/_A");
}

TEST(GltfPrimitives, MemoryIsEstimatedBeforeItIsTaken)
{
    test::Document document = test::triangle();
    Json& primitives = document.json["meshes"][0]["primitives"];
    const std::vector<float> positions(3 * 10'000, 0.0f);
    const int accessor = document.values(positions, test::kFloat, "VEC3", 3);
    for (int i = 0; i < 2000; ++i) primitives.push_back({{"attributes", {{"POSITION", accessor}}}});
    core::LoadOptions options;
    options.maxMemoryMb = 64;
    const test::Refusal refused = test::refusal(document.text(), options);
    EXPECT_EQ(refused.code, "TOO_LARGE");
    EXPECT_EQ(refused.pointer.rfind("/meshes/0/primitives/", 0), 0u);
}

}  // namespace
