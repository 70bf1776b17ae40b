// KHR_draco_mesh_compression (B11, B102): files made with Draco's encoder load as uncompressed ones
// do; streams that lie, are damaged or do not fit their accessors are refused.
#include "tests/support/scenes/bumpy_grid.h"

#include <random>

#include <draco/compression/expert_encode.h>
#include <draco/point_cloud/point_cloud_builder.h>

#include "shared/warp.h"

namespace {

using test::Document;
using test::Json;
using Stream = std::vector<std::byte>;

constexpr const char* kExtension = "KHR_draco_mesh_compression";
constexpr const char* kAt = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";

struct Encoding {
    int method = draco::MESH_EDGEBREAKER_ENCODING;
    int speed = 5;
    bool quantized = true;
    bool metadata = false;
    bool skinned = false;
};

/// Vertices to the right of the middle follow joint 1, the others joint 0.
uint8_t jointAt(float x)
{
    return x > 0.5f ? 1 : 0;
}

void addJoints(draco::Mesh& mesh, const test::BumpyGrid& grid)
{
    draco::GeometryAttribute joints, weights;
    joints.Init(draco::GeometryAttribute::GENERIC, nullptr, 4, draco::DT_UINT8, false, 4, 0);
    weights.Init(draco::GeometryAttribute::GENERIC, nullptr, 4, draco::DT_FLOAT32, false, 16, 0);
    draco::PointAttribute& j = *mesh.attribute(mesh.AddAttribute(joints, true, mesh.num_points()));
    draco::PointAttribute& w = *mesh.attribute(mesh.AddAttribute(weights, true, mesh.num_points()));
    j.set_unique_id(20);
    w.set_unique_id(21);
    for (uint32_t i = 0; i < mesh.num_points(); ++i) {
        const std::array<uint8_t, 4> joint{jointAt(grid.positions[3 * size_t(i)]), 0, 0, 0};
        const std::array<float, 4> weight{1, 0, 0, 0};
        j.SetAttributeValue(draco::AttributeValueIndex(i), joint.data());
        w.SetAttributeValue(draco::AttributeValueIndex(i), weight.data());
    }
}

void addAttribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, int components,
                  const std::vector<float>& values, uint32_t id)
{
    draco::GeometryAttribute description;
    const auto stride = static_cast<int64_t>(sizeof(float)) * components;
    description.Init(type, nullptr, static_cast<uint8_t>(components), draco::DT_FLOAT32, false,
                     stride, 0);
    const int index = mesh.AddAttribute(description, true, mesh.num_points());
    draco::PointAttribute& attribute = *mesh.attribute(index);
    attribute.set_unique_id(id);
    for (uint32_t i = 0; i < mesh.num_points(); ++i)
        attribute.SetAttributeValue(draco::AttributeValueIndex(i),
                                    &values[i * static_cast<size_t>(components)]);
}

Stream encodedBytes(const draco::EncoderBuffer& buffer)
{
    const auto bytes = std::as_bytes(std::span(buffer.data(), buffer.size()));
    return {bytes.begin(), bytes.end()};
}

/// Unique ids: 7 positions, 3 normals, 11 coordinates, 20 joints, 21 their weights.
Stream encode(const test::BumpyGrid& grid, const Encoding& encoding = {})
{
    draco::Mesh mesh;
    mesh.set_num_points(static_cast<uint32_t>(grid.vertices()));
    for (size_t i = 0; i < grid.indices.size(); i += 3)
        mesh.AddFace({draco::PointIndex(grid.indices[i]), draco::PointIndex(grid.indices[i + 1]),
                      draco::PointIndex(grid.indices[i + 2])});
    addAttribute(mesh, draco::GeometryAttribute::POSITION, 3, grid.positions, 7);
    addAttribute(mesh, draco::GeometryAttribute::NORMAL, 3, grid.normals, 3);
    addAttribute(mesh, draco::GeometryAttribute::TEX_COORD, 2, grid.coordinates, 11);
    if (encoding.skinned) addJoints(mesh, grid);
    if (encoding.metadata) {
        auto metadata = std::make_unique<draco::GeometryMetadata>();
        metadata->AddEntryString("name", "grid");
        mesh.AddMetadata(std::move(metadata));
    }
    draco::ExpertEncoder encoder(mesh);
    encoder.SetSpeedOptions(encoding.speed, encoding.speed);
    encoder.SetEncodingMethod(encoding.method);
    if (encoding.quantized)
        for (int i = 0; i < 3; ++i) encoder.SetAttributeQuantization(i, i == 1 ? 10 : 14);
    draco::EncoderBuffer buffer;
    const draco::Status status = encoder.EncodeToBuffer(&buffer);
    EXPECT_TRUE(status.ok()) << status.error_msg_string();
    return encodedBytes(buffer);
}

/// A document with nothing but the stream: accessors 0 positions, 1 normals, 2 coordinates, 3
/// indices; views 0 image, 1 stream.
Document compressed(const test::BumpyGrid& grid, const Stream& stream)
{
    Document document = test::texturedPrimitive();
    const int view = document.view(stream.data(), stream.size());
    const auto accessor = [&](const char* type, int componentType, size_t count) {
        document.json["accessors"].push_back(
            {{"componentType", componentType}, {"count", count}, {"type", type}});
        return document.json["accessors"].size() - 1;
    };
    document.attributes()["POSITION"] = accessor("VEC3", test::kFloat, grid.vertices());
    document.attributes()["NORMAL"] = accessor("VEC3", test::kFloat, grid.vertices());
    document.attributes()["TEXCOORD_0"] = accessor("VEC2", test::kFloat, grid.vertices());
    document.primitive()["indices"] = accessor("SCALAR", test::kUnsignedShort, grid.indices.size());
    document.primitive()["extensions"][kExtension] = {
        {"bufferView", view}, {"attributes", {{"POSITION", 7}, {"NORMAL", 3}, {"TEXCOORD_0", 11}}}};
    document.json["extensionsUsed"] = document.json["extensionsRequired"] = {kExtension};
    return document;
}

Json& extensionOf(Document& document)
{
    return document.primitive()["extensions"][kExtension];
}

TEST(GltfDraco, GridsAreThoseThatWereCompressed)
{
    const test::BumpyGrid grid = test::bumpyGrid(20);
    for (const int method : {draco::MESH_EDGEBREAKER_ENCODING, draco::MESH_SEQUENTIAL_ENCODING})
        for (const int speed : {0, 5, 10})
            for (const bool quantized : {true, false}) {
                const Encoding encoding{method, speed, quantized, speed == 5};
                const auto scene = test::load(compressed(grid, encode(grid, encoding)));
                ASSERT_TRUE(scene);
                EXPECT_EQ(scene->warnings.total(), 0u);
                const float step = quantized ? 1e-4f : 0;
                test::expectGrid(scene->meshes[0], grid, step, quantized ? 4e-3f : 1e-4f, step);
            }
}

TEST(GltfDraco, TheCompressedGeometryComesBeforeAFallback)
{
    const test::BumpyGrid grid = test::bumpyGrid(6);
    const Stream stream = encode(grid);
    Document document = test::plainGrid(grid);
    const int view = document.view(stream.data(), stream.size());
    document.primitive()["extensions"][kExtension] = {
        {"bufferView", view}, {"attributes", {{"POSITION", 7}, {"TEXCOORD_0", 11}}}};
    document.json["extensionsUsed"] = {kExtension};
    // What is stored plainly is changed beyond recognition, so that it shows where it comes from.
    const size_t bytes = 12 * grid.vertices();
    const size_t first = document.json["bufferViews"][1]["byteOffset"];
    std::fill_n(document.bin.begin() + static_cast<std::ptrdiff_t>(first), bytes, std::byte{0});
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    const core::Mesh& mesh = scene->meshes[0];
    EXPECT_EQ(mesh.triangles.size(), grid.indices.size() / 3);
    // Normals are not in the stream: they come from their accessor, in its order.
    for (size_t i = 0; i < mesh.attributes.size(); ++i)
        EXPECT_EQ(mesh.attributes[i].normal,
                  shared::packOct(glm::vec3(grid.normals[3 * i], grid.normals[3 * i + 1],
                                            grid.normals[3 * i + 2])));
    EXPECT_GT(glm::distance(mesh.positions[0], mesh.positions[1]), 0.1f);
}

TEST(GltfDraco, StripsAreDecodedToLists)
{
    const test::BumpyGrid grid = test::bumpyGrid(5);
    Document document = compressed(grid, encode(grid));
    document.primitive()["mode"] = 5;
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    test::expectGrid(scene->meshes[0], grid, 1e-4f, 4e-3f, 1e-4f);
    document.primitive()["mode"] = 6;
    EXPECT_REFUSED(document.text(), "VALUE_NOT_IN_LIST", "/meshes/0/primitives/0/mode");
    document.primitive()["mode"] = 1;
    EXPECT_REPAIRED(lines, document, "PRIMITIVE_MODE_IGNORED", "/meshes/0/primitives/0");
}

TEST(GltfDraco, WithoutIndicesTheStreamsCount)
{
    const test::BumpyGrid grid = test::bumpyGrid(5);
    Document document = compressed(grid, encode(grid));
    document.primitive().erase("indices");
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    test::expectGrid(scene->meshes[0], grid, 1e-4f, 4e-3f, 1e-4f);
}

/// The order of vertices is the stream's own, and joints are in it.
TEST(GltfDraco, JointsAreCompressedToo)
{
    const test::BumpyGrid grid = test::bumpyGrid(8);
    Encoding encoding;
    encoding.skinned = true;
    Document document = compressed(grid, encode(grid, encoding));
    const auto accessor = [&](int componentType) {
        document.json["accessors"].push_back(
            {{"componentType", componentType}, {"count", grid.vertices()}, {"type", "VEC4"}});
        return document.json["accessors"].size() - 1;
    };
    document.attributes()["JOINTS_0"] = accessor(test::kUnsignedByte);
    document.attributes()["WEIGHTS_0"] = accessor(test::kFloat);
    extensionOf(document)["attributes"]["JOINTS_0"] = 20;
    extensionOf(document)["attributes"]["WEIGHTS_0"] = 21;
    document.json["nodes"] = Json::parse(R"([{"mesh":0,"skin":0},{},{}])");
    document.json["scenes"][0]["nodes"] = {0, 1, 2};
    document.json["skins"] = Json::array({{{"joints", {1, 2}}}});
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    const core::Mesh& mesh = scene->meshes[0];
    ASSERT_TRUE(mesh.deformation);
    const core::Deformation& shape = *mesh.deformation;
    ASSERT_EQ(shape.first.size(), mesh.positions.size() + 1);
    size_t right = 0;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        ASSERT_EQ(shape.first[v + 1], shape.first[v] + 1);
        const uint32_t joint = shape.influences[shape.first[v]].joint;
        EXPECT_EQ(shape.joints[joint], jointAt(mesh.positions[v].x)) << v;
        right += shape.joints[joint];
    }
    EXPECT_GT(right, 0u);
    EXPECT_LT(right, mesh.positions.size());
}

TEST(GltfDraco, MorphTargetsKeepTheirAccessors)
{
    const test::BumpyGrid grid = test::bumpyGrid(4);
    // Sequential encoding keeps the order of vertices, which targets need.
    Encoding encoding;
    encoding.method = draco::MESH_SEQUENTIAL_ENCODING;
    Document document = compressed(grid, encode(grid, encoding));
    std::vector<float> offsets(3 * grid.vertices(), 0.0f);
    for (size_t i = 2; i < offsets.size(); i += 3) offsets[i] = 1;
    const int target = document.values(offsets, test::kFloat, "VEC3", 3);
    document.primitive()["targets"] = Json::array({{{"POSITION", target}}});
    document.json["meshes"][0]["weights"] = {0.5};
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    for (const glm::vec3& p : scene->meshes[0].positions) {
        EXPECT_GE(p.z, 0.4999f);
        EXPECT_LE(p.z, 0.6f);
    }
}

TEST(GltfDraco, CountsThatAreTooSmallRefuseTooLargeWarn)
{
    const test::BumpyGrid grid = test::bumpyGrid(6);
    const Document whole = compressed(grid, encode(grid));
    Document document = whole;
    document.json["accessors"][3]["count"] = grid.indices.size() - 3;
    EXPECT_REFUSED(document.text(), "COMPRESSED_COUNT_MISMATCH", kAt);
    document = whole;
    document.json["accessors"][0]["count"] = grid.vertices() - 1;
    EXPECT_REFUSED(document.text(), "COMPRESSED_COUNT_MISMATCH", kAt);
    document = whole;
    document.json["accessors"][3]["count"] = grid.indices.size() + 3;
    EXPECT_REPAIRED(scene, document, "COMPRESSED_COUNT_MISMATCH", kAt);
    test::expectGrid(scene->meshes[0], grid, 1e-4f, 4e-3f, 1e-4f);
}

TEST(GltfDraco, TypesAreThoseOfTheStream)
{
    const test::BumpyGrid grid = test::bumpyGrid(4);
    Document document = compressed(grid, encode(grid));
    document.json["accessors"][2]["componentType"] = test::kUnsignedShort;
    EXPECT_REPAIRED(scene, document, "COMPRESSED_TYPE_MISMATCH",
                    std::string(kAt) + "/attributes/TEXCOORD_0");
    test::expectGrid(scene->meshes[0], grid, 1e-4f, 4e-3f, 1e-4f);
    extensionOf(document)["attributes"]["POSITION"] = 11;  // two components
    EXPECT_REFUSED(document.text(), "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT",
                   "/meshes/0/primitives/0/attributes/POSITION");
}

TEST(GltfDraco, ReferencesMustLeadSomewhere)
{
    const test::BumpyGrid grid = test::bumpyGrid(4);
    const Document whole = compressed(grid, encode(grid));
    const std::string at = kAt;
    const auto with = [&](const char* key, const Json& value) {
        Document document = whole;
        if (value.is_null())
            extensionOf(document).erase(key);
        else
            extensionOf(document)[key] = value;
        return document;
    };
    EXPECT_REFUSED(with("bufferView", nullptr).text(), "UNDEFINED_PROPERTY", at);
    EXPECT_REFUSED(with("bufferView", 9).text(), "UNRESOLVED_REFERENCE", at + "/bufferView");
    EXPECT_REFUSED(with("attributes", nullptr).text(), "UNDEFINED_PROPERTY", at);
    EXPECT_REFUSED(with("attributes", 5).text(), "TYPE_MISMATCH", at + "/attributes");
    EXPECT_REFUSED(with("attributes", {{"POSITION", 12}}).text(), "UNRESOLVED_REFERENCE",
                   at + "/attributes/POSITION");
    EXPECT_REFUSED(with("attributes", {{"POSITION", "x"}}).text(), "TYPE_MISMATCH",
                   at + "/attributes/POSITION");
    EXPECT_REFUSED(with("attributes", {{"POSITION", uint64_t{1} << 32}}).text(),
                   "VALUE_NOT_IN_RANGE", at + "/attributes/POSITION");
    const Document extra = with("attributes", {{"POSITION", 7}, {"COLOR_0", 3}});
    EXPECT_REPAIRED(scene, extra, "UNRESOLVED_REFERENCE", at + "/attributes/COLOR_0");
    // Also where nothing shows the mesh
    Document unused = with("bufferView", 9);
    unused.json["nodes"][0].erase("mesh");
    EXPECT_REFUSED(unused.text(), "UNRESOLVED_REFERENCE", at + "/bufferView");
}

TEST(GltfDraco, StreamsThatCannotBeDecodedAreRefused)
{
    const test::BumpyGrid grid = test::bumpyGrid(6);
    const Stream whole = encode(grid);
    const auto expectRefused = [&](Stream stream, const char* words) {
        const std::string text = compressed(grid, stream).text();
        EXPECT_REFUSED(text, "COMPRESSED_DATA_INVALID", kAt);
        EXPECT_NE(test::refusal(text).message.find(words), std::string::npos) << words;
    };
    for (size_t keep = 1; keep < whole.size(); keep += 7)
        expectRefused({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(keep)}, "");
    expectRefused(Stream(300, std::byte{0x41}), "no Draco stream");
    Stream old = whole;
    old[6] = std::byte{1};  // the minor version
    expectRefused(old, "version 2.1");
    Stream method = whole;
    method[8] = std::byte{9};
    expectRefused(method, "cannot be decoded");

    draco::PointCloudBuilder builder;
    builder.Start(20);
    const int positions =
        builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    for (uint32_t i = 0; i < 20; ++i)
        builder.SetAttributeValueForPoint(positions, draco::PointIndex(i),
                                          &grid.positions[size_t{3} * i]);
    const auto cloud = builder.Finalize(false);
    draco::EncoderBuffer buffer;
    ASSERT_TRUE(draco::ExpertEncoder(*cloud).EncodeToBuffer(&buffer).ok());
    expectRefused(encodedBytes(buffer), "point cloud");
}

TEST(GltfDraco, MemoryIsJudgedBeforeDecoding)
{
    // Streams of few bytes that speak of 2^20 triangles: what they would need is not taken.
    const auto varint = [](Stream& stream, uint64_t value) {
        for (; value >= 128; value >>= 7)
            stream.push_back(static_cast<std::byte>(value & 127) | std::byte{128});
        stream.push_back(static_cast<std::byte>(value));
    };
    const Stream grid = encode(test::bumpyGrid(4));
    Stream edgebreaker(grid.begin(), grid.begin() + 12);  // the head and the kind of traversal
    for (const uint64_t value : {1ull << 19, 1ull << 20}) varint(edgebreaker, value);
    edgebreaker.push_back(std::byte{0});
    for (const uint64_t value : {1ull << 20, 0ull}) varint(edgebreaker, value);
    edgebreaker.resize(200);
    Encoding encoding;
    encoding.method = draco::MESH_SEQUENTIAL_ENCODING;
    const Stream other = encode(test::bumpyGrid(4), encoding);
    Stream sequential(other.begin(), other.begin() + 11);
    for (const uint64_t value : {1ull << 20, 1ull << 19}) varint(sequential, value);
    sequential.resize(200);
    for (const Stream& stream : {edgebreaker, sequential}) {
        Document document = compressed(test::bumpyGrid(4), stream);
        EXPECT_REFUSED(document.text(), "COMPRESSED_COUNT_MISMATCH", kAt);
        for (Json& accessor : document.json["accessors"]) accessor["count"] = 1u << 20;
        document.json["accessors"][3]["count"] = 3u << 20;
        core::LoadOptions options;
        options.maxMemoryMb = 32;  // enough for the accessors, not for decoding
        const test::Refusal refused = test::refusal(document.text(), options);
        EXPECT_EQ(refused.code, "TOO_LARGE") << refused.message;
        EXPECT_EQ(refused.pointer, kAt);
    }
}

TEST(GltfDraco, DamagedStreamsLoadOrAreRefused)
{
    const test::BumpyGrid grid = test::bumpyGrid(8);
    std::mt19937 random(5);
    size_t refused = 0;
    constexpr size_t kCount = 300;
    core::LoadOptions options;
    options.maxMemoryMb = 64;
    std::vector<Stream> streams;
    for (const int method : {draco::MESH_EDGEBREAKER_ENCODING, draco::MESH_SEQUENTIAL_ENCODING})
        for (const int speed : {0, 5, 10}) streams.push_back(encode(grid, {method, speed, true}));
    for (size_t i = 0; i < kCount; ++i) {
        Stream stream = streams[i % streams.size()];
        const size_t edits = 1 + random() % 3;
        for (size_t k = 0; k < edits; ++k)
            stream[11 + random() % (stream.size() - 11)] = static_cast<std::byte>(random());
        refused += test::refusesDamaged(compressed(grid, stream).text(), options) ? 1u : 0u;
    }
    EXPECT_GT(refused, kCount / 10);
    EXPECT_LT(refused, kCount * 19 / 20);
}

}  // namespace
