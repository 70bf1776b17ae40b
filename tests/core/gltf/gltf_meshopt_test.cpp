// EXT_meshopt_compression and KHR_meshopt_compression (B100, B101): files made with meshoptimizer's
// encoders load as uncompressed ones do, and what breaks the extension's rules is refused.
#include "tests/support/scenes/bumpy_grid.h"

#include <cmath>
#include <random>

#include <meshoptimizer.h>

namespace {

using test::Document;
using test::Json;
using MeshoptStream = std::vector<unsigned char>;

MeshoptStream encodeAttributes(const void* values, size_t count, size_t stride)
{
    MeshoptStream stream(meshopt_encodeVertexBufferBound(count, stride));
    stream.resize(meshopt_encodeVertexBuffer(stream.data(), stream.size(), values, count, stride));
    return stream;
}

MeshoptStream encodeTriangles(const std::vector<uint32_t>& indices, size_t vertices)
{
    MeshoptStream stream(meshopt_encodeIndexBufferBound(indices.size(), vertices));
    stream.resize(
        meshopt_encodeIndexBuffer(stream.data(), stream.size(), indices.data(), indices.size()));
    return stream;
}

MeshoptStream encodeSequence(const std::vector<uint32_t>& indices, size_t vertices)
{
    MeshoptStream stream(meshopt_encodeIndexSequenceBound(indices.size(), vertices));
    stream.resize(
        meshopt_encodeIndexSequence(stream.data(), stream.size(), indices.data(), indices.size()));
    return stream;
}

/// A document whose buffer 0 holds streams and whose buffer 1 is a placeholder.
struct Compressed {
    Document document = test::texturedPrimitive();
    std::string extension = "EXT_meshopt_compression";
    size_t placeholder = 0;

    /// Appends a view; returns its index.
    int view(const MeshoptStream& stream, size_t count, size_t stride, const char* mode,
             const char* filter = nullptr)
    {
        const int index = document.view(stream.data(), stream.size());
        Json& view = document.json["bufferViews"][static_cast<size_t>(index)];
        Json description{{"buffer", 0},
                         {"byteOffset", view["byteOffset"]},
                         {"byteLength", stream.size()},
                         {"byteStride", stride},
                         {"count", count},
                         {"mode", mode}};
        if (filter) description["filter"] = filter;
        view = {{"buffer", 1},
                {"byteOffset", placeholder},
                {"byteLength", stride * count},
                {"extensions", {{extension, description}}}};
        if (std::string(mode) == "ATTRIBUTES") view["byteStride"] = stride;
        placeholder += stride * count;
        return index;
    }

    Json& description(size_t view)
    {
        return document.json["bufferViews"][view]["extensions"][extension];
    }

    std::string text() const
    {
        Json complete = document.json;
        complete["extensionsUsed"] = complete["extensionsRequired"] = {extension};
        complete["buffers"] = Json::array(
            {{{"byteLength", document.bin.size()},
              {"uri", "data:application/octet-stream;base64," + test::base64(document.bin)}},
             {{"byteLength", placeholder}, {"extensions", {{extension, {{"fallback", true}}}}}}});
        return complete.dump();
    }
};

/// Views: 0 the image, 1 positions, 2 normals, 3 coordinates, 4 indices.
Compressed compressedGrid(const test::BumpyGrid& grid, size_t indexBytes = 4, bool list = true,
                          const char* extension = "EXT_meshopt_compression")
{
    Compressed result;
    result.extension = extension;
    const size_t count = grid.vertices();
    Json& attributes = result.document.attributes();
    attributes["POSITION"] = result.document.accessor(
        result.view(encodeAttributes(grid.positions.data(), count, 12), count, 12, "ATTRIBUTES"),
        test::kFloat, count, "VEC3");
    attributes["NORMAL"] =
        result.document.accessor(result.view(encodeAttributes(grid.normals.data(), count, 12),
                                             count, 12, "ATTRIBUTES", "NONE"),
                                 test::kFloat, count, "VEC3");
    attributes["TEXCOORD_0"] = result.document.accessor(
        result.view(encodeAttributes(grid.coordinates.data(), count, 8), count, 8, "ATTRIBUTES"),
        test::kFloat, count, "VEC2");
    const MeshoptStream stream =
        list ? encodeTriangles(grid.indices, count) : encodeSequence(grid.indices, count);
    result.document.primitive()["indices"] = result.document.accessor(
        result.view(stream, grid.indices.size(), indexBytes, list ? "TRIANGLES" : "INDICES"),
        indexBytes == 2 ? test::kUnsignedShort : test::kUnsignedInt, grid.indices.size(), "SCALAR");
    return result;
}

TEST(GltfMeshopt, GridsAreThoseThatWereCompressed)
{
    const test::BumpyGrid grid = test::bumpyGrid(20);
    for (const size_t indexBytes : {2u, 4u})
        for (const bool list : {true, false})
            for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
                const auto scene =
                    test::loadText(compressedGrid(grid, indexBytes, list, extension).text());
                ASSERT_TRUE(scene);
                EXPECT_EQ(scene->warnings.total(), 0u);
                test::expectGrid(scene->meshes[0], grid, 0, 1e-4f, 0);
            }
}

/// Vectors of three with an exponent each: what version 0.18 does, and newer ones on demand.
static void encodeExponential(std::byte* out, size_t count, const float* vectors)
{
#if MESHOPTIMIZER_VERSION >= 190
    meshopt_encodeFilterExp(out, count, 12, 15, vectors, meshopt_EncodeExpSharedVector);
#else
    meshopt_encodeFilterExp(out, count, 12, 15, vectors);
#endif
}

TEST(GltfMeshopt, FiltersAreUndone)
{
    const test::BumpyGrid grid = test::bumpyGrid(13);
    const size_t count = grid.vertices();
    std::vector<float> normals;  // four components each, as the encoder reads them
    for (size_t i = 0; i < count; ++i) {
        normals.insert(normals.end(), &grid.normals[3 * i], &grid.normals[3 * i] + 3);
        normals.push_back(0);
    }
    for (const size_t stride : {4u, 8u}) {
        Compressed compressed = compressedGrid(grid);
        Document& document = compressed.document;
        std::vector<std::byte> filtered(stride * count);
        meshopt_encodeFilterOct(filtered.data(), count, stride, stride == 4 ? 8 : 14,
                                normals.data());
        const int normal =
            document.accessor(compressed.view(encodeAttributes(filtered.data(), count, stride),
                                              count, stride, "ATTRIBUTES", "OCTAHEDRAL"),
                              stride == 4 ? 5120 : 5122, count, "VEC3");
        document.json["accessors"].back()["normalized"] = true;
        std::vector<std::byte> floats(12 * count);
        encodeExponential(floats.data(), count, grid.positions.data());
        const int position =
            document.accessor(compressed.view(encodeAttributes(floats.data(), count, 12), count, 12,
                                              "ATTRIBUTES", "EXPONENTIAL"),
                              test::kFloat, count, "VEC3");
        document.attributes()["NORMAL"] = normal;
        document.attributes()["POSITION"] = position;
        const auto scene = test::loadText(compressed.text());
        ASSERT_TRUE(scene);
        EXPECT_EQ(scene->warnings.total(), 0u);
        test::expectGrid(scene->meshes[0], grid, 1e-4f, stride == 4 ? 0.02f : 1e-3f, 0);
    }
}

TEST(GltfMeshopt, RotationsOfInstancesAreDecoded)
{
    Compressed compressed = compressedGrid(test::bumpyGrid(4));
    const float root = std::sqrt(0.5f);
    const std::vector<float> turns{0, 0, 0, 1, 0, 0, root, root, 0.5f, 0.5f, 0.5f, 0.5f};
    std::vector<std::byte> filtered(24);
    meshopt_encodeFilterQuat(filtered.data(), 3, 8, 16, turns.data());
    const int rotation = compressed.document.accessor(
        compressed.view(encodeAttributes(filtered.data(), 3, 8), 3, 8, "ATTRIBUTES", "QUATERNION"),
        5122, 3, "VEC4");
    compressed.document.json["accessors"].back()["normalized"] = true;
    compressed.document.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"ROTATION", rotation}};
    const auto scene = test::loadText(compressed.text());
    ASSERT_TRUE(scene);
    ASSERT_EQ(scene->placements.size(), 1u);
    for (size_t i = 0; i < 3; ++i) {
        const glm::quat q = scene->placements[0][i].rotation;
        const float* expected = &turns[4 * i];
        EXPECT_NEAR(
            std::abs(q.x * expected[0] + q.y * expected[1] + q.z * expected[2] + q.w * expected[3]),
            1, 1e-4f);
    }
}

TEST(GltfMeshopt, FallbacksAreNeitherReadNorMissed)
{
    const test::BumpyGrid grid = test::bumpyGrid(5);
    Compressed compressed = compressedGrid(grid);
    Json json = Json::parse(compressed.text());
    // A fallback with a file that is not there; and one without a mark.
    json["buffers"][1]["uri"] = "missing.bin";
    EXPECT_TRUE(test::loadText(json.dump()));
    json["buffers"][1] = {{"byteLength", compressed.placeholder}};
    EXPECT_TRUE(test::loadText(json.dump()));
    // Something that is stored there only
    json["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 4}});
    EXPECT_REFUSED(json.dump(), "UNDEFINED_PROPERTY", "/buffers/1");
    json["buffers"][1]["uri"] = "missing.bin";
    EXPECT_REFUSED(json.dump(), "IO_ERROR", "/buffers/1/uri");
}

/// The grid's document with one member of a view's extension changed.
std::string withViewMember(size_t view, const char* key, const Json& value)
{
    Compressed compressed = compressedGrid(test::bumpyGrid(4), 2);
    if (value.is_null())
        compressed.description(view).erase(key);
    else
        compressed.description(view)[key] = value;
    return compressed.text();
}

TEST(GltfMeshopt, RulesOfTheExtensionAreKept)
{
    const auto at = [](size_t view, const std::string& key) {
        return "/bufferViews/" + std::to_string(view) + "/extensions/EXT_meshopt_compression" +
               (key.empty() ? "" : "/" + key);
    };
    struct Case {
        size_t view;
        const char* key;
        Json value;
        const char* code;
    };
    for (const Case& c : std::vector<Case>{{1, "byteStride", 10, "VALUE_NOT_IN_RANGE"},
                                           {1, "byteStride", 0, "VALUE_NOT_IN_RANGE"},
                                           {1, "byteStride", 260, "VALUE_NOT_IN_RANGE"},
                                           {1, "byteStride", -4, "TYPE_MISMATCH"},
                                           {4, "byteStride", 8, "VALUE_NOT_IN_LIST"},
                                           {1, "count", 0, "VALUE_NOT_IN_RANGE"},
                                           {4, "count", 55, "VALUE_NOT_IN_RANGE"},
                                           {1, "mode", "LINES", "VALUE_NOT_IN_LIST"},
                                           {1, "mode", 0, "TYPE_MISMATCH"},
                                           {1, "filter", "BLUR", "VALUE_NOT_IN_LIST"},
                                           {1, "filter", "COLOR", "UNSUPPORTED_EXTENSION"},
                                           {4, "filter", "EXPONENTIAL", "VALUE_NOT_IN_LIST"},
                                           {1, "buffer", 7, "UNRESOLVED_REFERENCE"},
                                           {1, "byteLength", 0, "VALUE_NOT_IN_RANGE"}})
        EXPECT_REFUSED(withViewMember(c.view, c.key, c.value), c.code, at(c.view, c.key));
    for (const char* filter : {"OCTAHEDRAL", "QUATERNION"})
        EXPECT_REFUSED(withViewMember(1, "filter", filter), "VALUE_NOT_IN_LIST",
                       at(1, "byteStride"));
    for (const char* key : {"buffer", "byteLength", "byteStride", "count", "mode"})
        EXPECT_REFUSED(withViewMember(1, key, nullptr), "UNDEFINED_PROPERTY", at(1, ""));
    EXPECT_REFUSED(withViewMember(1, "byteOffset", 1u << 30), "BUFFER_VIEW_TOO_LONG", at(1, ""));
    EXPECT_REFUSED(withViewMember(1, "byteLength", 1u << 30), "BUFFER_VIEW_TOO_LONG", at(1, ""));
    // Sizes that do not match the view's
    EXPECT_REFUSED(withViewMember(1, "count", 15), "VALUE_NOT_IN_RANGE",
                   "/bufferViews/1/byteLength");
    EXPECT_REFUSED(withViewMember(1, "count", uint64_t{1} << 62), "VALUE_NOT_IN_RANGE",
                   "/bufferViews/1/byteLength");
    Compressed stride = compressedGrid(test::bumpyGrid(4));
    stride.document.json["bufferViews"][1]["byteStride"] = 16;
    EXPECT_REFUSED(stride.text(), "VALUE_NOT_IN_LIST", "/bufferViews/1/byteStride");
    Compressed noObject = compressedGrid(test::bumpyGrid(4));
    noObject.description(1) = 5;
    EXPECT_REFUSED(noObject.text(), "TYPE_MISMATCH", at(1, ""));
}

TEST(GltfMeshopt, StreamsThatCannotBeDecodedAreRefused)
{
    const std::string at = "/bufferViews/1/extensions/EXT_meshopt_compression";
    // Cut off; the bytes of another mode; a version that no library knows
    EXPECT_REFUSED(withViewMember(1, "byteLength", 20), "COMPRESSED_DATA_INVALID", at);
    EXPECT_REFUSED(withViewMember(1, "mode", "INDICES"), "VALUE_NOT_IN_LIST", at + "/byteStride");
    EXPECT_REFUSED(withViewMember(4, "mode", "INDICES"), "COMPRESSED_DATA_INVALID",
                   "/bufferViews/4/extensions/EXT_meshopt_compression");
    Compressed version = compressedGrid(test::bumpyGrid(4));
    version.document.bin[version.description(1)["byteOffset"].get<size_t>()] = std::byte{0xaf};
    EXPECT_REFUSED(version.text(), "COMPRESSED_DATA_INVALID", at);
    // A few bytes for a billion vertices: refused before memory is taken, with any limit.
    Compressed lie = compressedGrid(test::bumpyGrid(4));
    lie.description(1)["count"] = 1'000'000'000;
    lie.document.json["bufferViews"][1]["byteLength"] = 12'000'000'000;
    EXPECT_REFUSED(lie.text(), "COMPRESSED_DATA_INVALID", at + "/byteLength");
}

TEST(GltfMeshopt, MemoryIsJudgedBeforeDecoding)
{
    // A plane: the stream is a hundred times smaller than what it stands for.
    constexpr size_t kCount = 400'000;
    const std::vector<float> zeros(3 * kCount, 0.0f);
    Compressed compressed = compressedGrid(test::bumpyGrid(4));
    compressed.view(encodeAttributes(zeros.data(), kCount, 12), kCount, 12, "ATTRIBUTES");
    core::LoadOptions options;
    EXPECT_TRUE(test::loadText(compressed.text(), options));
    options.maxMemoryMb = 4;
    const test::Refusal refused = test::refusal(compressed.text(), options);
    EXPECT_EQ(refused.code, "TOO_LARGE");
    EXPECT_EQ(refused.pointer, "/bufferViews/5/extensions/EXT_meshopt_compression");
}

TEST(GltfMeshopt, DamagedStreamsLoadOrAreRefused)
{
    std::mt19937 random(3);
    size_t refused = 0;
    constexpr size_t kCount = 300;
    for (size_t i = 0; i < kCount; ++i) {
        Compressed compressed = compressedGrid(test::bumpyGrid(6), i % 2 ? 2 : 4, i % 4 < 2);
        const Json& hit = compressed.description(1 + random() % 4);
        const size_t first = hit["byteOffset"], size = hit["byteLength"];
        const size_t edits = 1 + random() % 4;
        for (size_t k = 0; k < edits; ++k)
            compressed.document.bin[first + random() % size] = static_cast<std::byte>(random());
        refused += test::refusesDamaged(compressed.text()) ? 1u : 0u;
    }
    EXPECT_GT(refused, kCount / 10);
    EXPECT_LT(refused, kCount * 19 / 20);
}

}  // namespace
