// What exporters write and readers stumble over: allowed, or forgiven where the meaning is plain;
// and what one file asks for many times, which counts many times or is read once (B92-B94).
#include <cstdint>
#include <limits>

#include "tests/support/scenes/gltf_fixture.h"

namespace {

using test::Document;
using test::Json;

std::span<const std::byte> asBytes(const std::vector<std::byte>& bytes)
{
    return bytes;
}

/// The triangle with its buffer in a file of that name, which the document calls `uri`.
size_t trianglesOf(const std::string& name, const std::string& uri)
{
    const test::TemporaryFolder folder;
    Document document = test::triangle();
    Json json = Json::parse(document.text());
    json["buffers"][0]["uri"] = uri;
    std::filesystem::create_directories((folder.path() / name).parent_path());
    folder.write(name, asBytes(document.bin));
    const auto file = folder.write("scene.gltf", json.dump());
    const auto scene = core::loadGltf(file);
    return scene->meshes.at(0).triangles.size();
}

TEST(GltfExporters, NamesAsTheyAreMeant)
{
    EXPECT_EQ(trianglesOf("a b.bin", "a%20b.bin"), 1u);
    EXPECT_EQ(trianglesOf("a b.bin", "a b.bin"), 1u);
    EXPECT_EQ(trianglesOf("100%.bin", "100%.bin"), 1u);
    EXPECT_EQ(trianglesOf("100%25.bin", "100%25.bin"), 1u);
    EXPECT_EQ(trianglesOf("sub/a.bin", "sub\\a.bin"), 1u);
    EXPECT_EQ(trianglesOf("sub/a b.bin", "sub\\a%20b.bin"), 1u);
    EXPECT_EQ(trianglesOf("sub/a.bin", ".\\sub\\..\\sub\\a.bin"), 1u);
    for (const char* outside : {"..\\outside.bin", "%2e%2e\\outside.bin", "sub\\..\\..\\x.bin"})
        EXPECT_THROW(trianglesOf("a.bin", outside), core::LoadError) << outside;
    EXPECT_THROW(trianglesOf("a.bin", std::string("a.bin\0.png", 10)), core::LoadError);
}

TEST(GltfExporters, DataInAnyCaseAndWithLineBreaks)
{
    Json json = Json::parse(test::triangle().text());
    const auto uri = json["buffers"][0]["uri"].get<std::string>();
    const size_t comma = uri.find(',');
    const auto loads = [&](const std::string& other) {
        json["buffers"][0]["uri"] = other;
        return test::loadText(json.dump())->meshes.size() == 1;
    };
    EXPECT_TRUE(loads("DATA" + uri.substr(4)));
    EXPECT_TRUE(loads("Data:application/octet-stream;BASE64" + uri.substr(comma)));
    std::string broken = uri.substr(0, comma + 1);
    for (size_t i = comma + 1; i < uri.size(); ++i) {
        broken += uri[i];
        if (i % 5 == 0) broken += i % 2 == 0 ? "\r\n" : " \t";
    }
    EXPECT_TRUE(loads(broken));
    json["buffers"][0]["uri"] = uri.substr(0, comma + 1) + "!" + uri.substr(comma + 1);
    EXPECT_EQ(test::refusal(json.dump()).code, "IO_ERROR");
}

TEST(GltfExporters, WhatNothingUsesMayBeStrange)
{
    Document document = test::triangle();
    Json json = Json::parse(document.text());
    json["buffers"].push_back({{"byteLength", 100}});
    json["accessors"].push_back({{"componentType", 5130}, {"type", "SCALAR"}, {"count", 1}});
    json["accessors"].push_back({{"componentType", 5126}, {"type", "QUAT"}, {"count", 1}});
    EXPECT_EQ(test::loadText(json.dump())->meshes.size(), 1u);
    Json used = json;
    used["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 4}});
    EXPECT_EQ(test::refusal(used.dump()).code, "UNDEFINED_PROPERTY");
    EXPECT_EQ(test::refusal(used.dump()).pointer, "/buffers/1");
    const test::TemporaryFolder folder;  // an empty file is no absent one
    folder.write("empty.bin", std::string());
    used["buffers"][1]["uri"] = "empty.bin";
    EXPECT_EQ(test::fileRefusal(folder.write("scene.gltf", used.dump())).code,
              "BUFFER_BYTE_LENGTH_MISMATCH");
    for (const auto& [index, pointer] : std::vector<std::pair<int, std::string>>{
             {2, "/accessors/2/componentType"}, {3, "/accessors/3/type"}})
        for (const char* place : {"attributes", "indices"}) {
            used = json;
            Json& primitive = used["meshes"][0]["primitives"][0];
            if (std::string(place) == "indices")
                primitive["indices"] = index;
            else
                primitive["attributes"]["POSITION"] = index;
            const test::Refusal refused = test::refusal(used.dump());
            EXPECT_EQ(refused.code, "VALUE_NOT_IN_LIST");
            EXPECT_EQ(refused.pointer, pointer);
        }
}

template <class T> std::string restartCode(int componentType)
{
    Document document = test::triangle();
    const size_t vertices = size_t{1} << (8 * std::min<size_t>(sizeof(T), 2));
    const std::vector<float> positions(3 * vertices, 0.5f);
    document.attributes()["POSITION"] = document.values(positions, test::kFloat, "VEC3", 3);
    const std::vector<T> indices{0, 1, 2, 0, 1, std::numeric_limits<T>::max()};
    document.primitive()["indices"] = document.values(indices, componentType, "SCALAR", 1);
    return test::refusal(document.text()).code;
}

TEST(GltfExporters, RestartsAreNoIndices)
{
    EXPECT_EQ(restartCode<uint8_t>(test::kUnsignedByte), "ACCESSOR_INDEX_PRIMITIVE_RESTART");
    EXPECT_EQ(restartCode<uint16_t>(test::kUnsignedShort), "ACCESSOR_INDEX_PRIMITIVE_RESTART");
    EXPECT_EQ(restartCode<uint32_t>(test::kUnsignedInt), "ACCESSOR_INDEX_OOB");
}

// --- memory

core::LoadOptions withMemory(uint64_t mb)
{
    core::LoadOptions options;
    options.maxMemoryMb = mb;
    return options;
}

void expectTooLarge(const std::string& text, uint64_t mb)
{
    const test::Refusal refused = test::refusal(text, withMemory(mb));
    EXPECT_EQ(refused.code, "TOO_LARGE") << refused.message;
}

/// 200 channels of 20,000 keys of 20 bytes, of one sampler or of a sampler each whose values are an
/// accessor of its own.
std::string manyChannels(bool ofOneSampler)
{
    Document document = test::triangle();
    constexpr size_t kKeys = 20000;
    std::vector<float> times(kKeys), values(3 * kKeys, 1.0f);
    for (size_t i = 0; i < kKeys; ++i) times[i] = static_cast<float>(i);
    const auto input = document.values(times, test::kFloat, "SCALAR", 1);
    const auto output = document.values(values, test::kFloat, "VEC3", 3);
    Json channels = Json::array(), samplers = Json::array();
    for (int i = 0; i < 200; ++i) {
        channels.push_back(
            {{"sampler", ofOneSampler ? 0 : i}, {"target", {{"node", 0}, {"path", "scale"}}}});
        if (i > 0) document.json["accessors"].push_back(document.json["accessors"][size_t(output)]);
        const size_t last = document.json["accessors"].size() - 1;
        samplers.push_back({{"input", input}, {"output", last}});
    }
    document.json["animations"] = Json::array({{{"samplers", samplers}, {"channels", channels}}});
    return document.text();
}

TEST(GltfExporters, ChannelsOfOneSamplerShareItsKeys)
{
    const auto scene = test::loadText(manyChannels(true), withMemory(40));
    const auto& channels = scene->animations.at(0).channels;
    ASSERT_EQ(channels.size(), 200u);
    EXPECT_EQ(channels.front().keys->times.size(), 20000u);
    EXPECT_EQ(channels.front().keys, channels.back().keys);
}

TEST(GltfExporters, ChannelsWithKeysOfTheirOwnCountEach)
{
    const std::string text = manyChannels(false);  // 76 MiB of keys
    expectTooLarge(text, 40);
    const auto scene = test::loadText(text, withMemory(200));
    const auto& channels = scene->animations.at(0).channels;
    ASSERT_EQ(channels.size(), 200u);
    EXPECT_NE(channels.front().keys, channels.back().keys);
}

TEST(GltfExporters, InstancesCountBeforeTheyAreMade)
{
    Document document = test::triangle();
    std::vector<uint16_t> indices;
    for (int i = 0; i < 10000; ++i) indices.insert(indices.end(), {0, 1, 2});
    document.primitive()["indices"] = document.values(indices, test::kUnsignedShort, "SCALAR", 1);
    Json nodes = Json::array(), roots = Json::array();
    for (int i = 0; i < 1000; ++i) {
        nodes.push_back({{"mesh", 0}});
        roots.push_back(i);
    }
    document.json["nodes"] = nodes;
    document.json["scenes"] = Json::array({{{"nodes", roots}}});
    // Ten million triangles when they are written out
    core::LoadOptions options = withMemory(500);
    options.instancing = core::Instancing::flat;
    EXPECT_EQ(test::refusal(document.text(), options).code, "TOO_LARGE");
    EXPECT_TRUE(test::load(document, withMemory(500)));
}

TEST(GltfExporters, WeightsOfManyNodesCount)
{
    Document document = test::triangle();
    Json targets = Json::array(), weights = Json::array();
    for (int i = 0; i < 1000; ++i) {
        targets.push_back(Json::object());
        weights.push_back(0.5);
    }
    document.primitive()["targets"] = targets;
    document.json["meshes"][0]["weights"] = weights;
    Json nodes = Json::array(), roots = Json::array();
    for (int i = 0; i < 2000; ++i) {
        nodes.push_back({{"mesh", 0}});
        roots.push_back(i);
    }
    document.json["nodes"] = nodes;
    document.json["scenes"] = Json::array({{{"nodes", roots}}});
    expectTooLarge(document.text(), 20);  // two million weights, twice
}

TEST(GltfExporters, OneFileOfManyBuffersIsReadOnce)
{
    const test::TemporaryFolder folder;
    Document document = test::triangle();
    Json json = Json::parse(document.text());
    std::vector<std::byte> bin = document.bin;
    bin.resize(1 << 20);
    folder.write("a.bin", asBytes(bin));
    json["buffers"][0]["uri"] = "a.bin";
    for (int i = 0; i < 200; ++i) json["buffers"].push_back(json["buffers"][0]);
    const auto file = folder.write("scene.gltf", json.dump());
    const auto scene = core::loadGltf(file, withMemory(16));
    EXPECT_EQ(scene->fileBytes, std::filesystem::file_size(file) + bin.size());
    for (size_t i = 0; i < json["buffers"].size(); ++i) {  // other spellings are other files
        std::string name;
        for (size_t k = 0; k < i; ++k) name += "./";
        json["buffers"][i]["uri"] = name + "a.bin";
    }
    folder.write("scene.gltf", json.dump());
    EXPECT_EQ(test::fileRefusal(file, withMemory(16)).code, "TOO_LARGE");
}

}  // namespace
