// Bad documents and containers (B1-B10, B12, B81-B83, B87).
#include "tests/support/scenes/gltf_fixture.h"

namespace {

using test::Json;

std::string withMember(const std::string& key, const Json& value)
{
    test::Document document = test::triangle();
    document.json[key] = value;
    return document.text();
}

TEST(GltfDocument, EmptyAndBlankFilesAreRefused)
{
    EXPECT_REFUSED("", "EMPTY_FILE", "");
    EXPECT_REFUSED(" \n\t ", "INVALID_JSON", "");
}

TEST(GltfDocument, SyntaxErrorsNameLineAndColumn)
{
    EXPECT_REFUSED("{\n\"asset\":", "INVALID_JSON", "");
    EXPECT_NE(test::refusal("{\n\"asset\":").message.find("line 2"), std::string::npos);
    EXPECT_REFUSED(std::string("{\"a\":\0\0}", 8), "INVALID_JSON", "");
    EXPECT_REFUSED(std::string("{\"asset\":{\"version\":\"2.0\"}}\0x", 28), "INVALID_JSON", "");
    EXPECT_REFUSED("{\"asset\":{\"version\":\"2.0\",\"x\":NaN}}", "INVALID_JSON", "");
    EXPECT_REFUSED("{\"asset\":{\"version\":\"2.0\",\"x\":1e999}}", "INVALID_JSON", "");
}

TEST(GltfDocument, WhatIsNoGltfIsSaidToBeNone)
{
    for (const std::string text :
         {"v 0 0 0\nf 1 1 1", "PK\x03\x04zip", "BLENDER-v300", "[]", "7"}) {
        EXPECT_REFUSED(text, "INVALID_JSON", "");
        EXPECT_NE(test::refusal(text).message.find("not glTF 2.0"), std::string::npos);
    }
}

TEST(GltfDocument, DeepNestingIsRefusedBeforeParsing)
{
    EXPECT_REFUSED(std::string(200'000, '['), "INVALID_JSON", "");
    std::string objects = "{\"extras\":";
    for (int i = 0; i < 200'000; ++i) objects += "{\"a\":";
    EXPECT_REFUSED(objects, "INVALID_JSON", "");
    EXPECT_NE(test::refusal(objects).message.find("deeper than 64"), std::string::npos);
    const auto withExtras = [](const std::string& extras) {
        std::string text = R"({"asset":{"version":"2.0"},"extras":)";
        return text.append(extras).append("}");
    };
    const std::string deep = std::string(63, '[').append(63, ']');
    EXPECT_TRUE(test::loadText(withExtras(deep))) << "64 levels are allowed";
    EXPECT_TRUE(test::loadText(withExtras(std::string("\"").append(100, '[').append("\""))))
        << "brackets inside strings do not nest";
}

TEST(GltfDocument, ByteOrderMarkIsAccepted)
{
    const auto scene = test::loadText("\xef\xbb\xbf" + test::triangle().text());
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
}

TEST(GltfDocument, InvalidUtf8IsRefused)
{
    EXPECT_REFUSED("{\"asset\":{\"version\":\"2.0\",\"generator\":\"\xff\xfe\"}}", "INVALID_JSON",
                   "");
}

TEST(GltfDocument, VersionMustBeTwo)
{
    test::Document document = test::triangle();
    document.json.erase("asset");
    EXPECT_REFUSED(document.text(), "UNDEFINED_PROPERTY", "");
    EXPECT_REFUSED(withMember("asset", Json::object()), "UNDEFINED_PROPERTY", "/asset");
    EXPECT_REFUSED(withMember("asset", 7), "TYPE_MISMATCH", "/asset");
    for (const char* version : {"1.0", "3.0", "", "two", "20"})
        EXPECT_REFUSED(withMember("asset", {{"version", version}}), "UNKNOWN_ASSET_MAJOR_VERSION",
                       "/asset/version");
    EXPECT_REFUSED(withMember("asset", {{"version", "2.0"}, {"minVersion", "3.0"}}),
                   "UNKNOWN_ASSET_MAJOR_VERSION", "/asset/minVersion");
    EXPECT_TRUE(test::loadText(withMember("asset", {{"version", "2.1"}, {"minVersion", "2.0"}})));
}

TEST(GltfDocument, RequiredExtensionsThatAreUnknownRefuse)
{
    for (const char* name : {"KHR_texture_basisu", "EXT_texture_webp", "ACME_magic"}) {
        const std::string text = withMember("extensionsRequired", {"KHR_materials_ior", name});
        EXPECT_REFUSED(text, "UNSUPPORTED_EXTENSION", "/extensionsRequired/1");
        EXPECT_NE(test::refusal(text).message.find(name), std::string::npos);
    }
    core::LoadOptions options;
    options.ignoreRequired = true;
    const auto scene = test::loadText(withMember("extensionsRequired", {"ACME_magic"}), options);
    ASSERT_TRUE(scene);
    EXPECT_EQ(test::warning(*scene, "UNSUPPORTED_EXTENSION").pointer, "/extensionsRequired/0");
}

TEST(GltfDocument, UsedExtensionsThatAreUnknownWarnOnce)
{
    const auto scene =
        test::loadText(withMember("extensionsUsed", {"ACME_magic", "KHR_materials_ior"}));
    ASSERT_TRUE(scene);
    EXPECT_EQ(test::warning(*scene, "UNSUPPORTED_EXTENSION").pointer, "/extensionsUsed/0");
    EXPECT_EQ(scene->warnings.total(), 1u);
}

TEST(GltfDocument, TopLevelArraysMustBeArrays)
{
    for (const char* key : {"buffers", "bufferViews", "accessors", "nodes", "meshes", "scenes",
                            "cameras", "animations"})
        EXPECT_REFUSED(withMember(key, 5), "TYPE_MISMATCH", std::string("/") + key);
    EXPECT_REFUSED(withMember("nodes", {3}), "TYPE_MISMATCH", "/nodes/0");
}

TEST(GltfDocument, StrictTurnsWarningsIntoRefusal)
{
    core::LoadOptions options;
    options.strict = true;
    EXPECT_TRUE(test::load(test::triangle(), options));
    const test::Refusal refused =
        test::refusal(withMember("extensionsUsed", {"ACME_magic"}), options);
    EXPECT_EQ(refused.code, "UNSUPPORTED_EXTENSION");
    EXPECT_EQ(refused.pointer, "/extensionsUsed/0");
}

// --- GLB

std::string glb()
{
    const std::vector<std::byte> bytes = test::triangle().glb();
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string withWord(std::string text, size_t offset, uint32_t value)
{
    std::memcpy(text.data() + offset, &value, 4);
    return text;
}

uint32_t wordAt(const std::string& text, size_t offset)
{
    uint32_t value = 0;
    std::memcpy(&value, text.data() + offset, 4);
    return value;
}

TEST(GltfContainer, WellFormedLoads)
{
    const auto scene = test::loadText(glb());
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    ASSERT_EQ(scene->meshes.size(), 1u);
    EXPECT_EQ(scene->meshes[0].positions[1], glm::vec3(1, 0, 0));
}

TEST(GltfContainer, DamagedHeadersAreRefused)
{
    const std::string good = glb();
    const uint32_t length = wordAt(good, 8), jsonLength = wordAt(good, 12);
    EXPECT_REFUSED(good.substr(0, 12), "GLB_UNEXPECTED_END_OF_HEADER", "");
    EXPECT_REFUSED(good.substr(0, 4), "GLB_UNEXPECTED_END_OF_HEADER", "");
    EXPECT_REFUSED("glTX" + good.substr(4), "INVALID_JSON", "");
    EXPECT_REFUSED(withWord(good, 4, 1), "GLB_UNKNOWN_VERSION", "");
    for (const uint32_t wrong : {0u, 11u, length + 1, 0xffffffffu})
        EXPECT_REFUSED(withWord(good, 8, wrong), "GLB_LENGTH_MISMATCH", "");
    EXPECT_REFUSED(good.substr(0, good.size() - 1), "GLB_LENGTH_MISMATCH", "");
    for (const uint32_t wrong : {length, 0xffffffffu, 0xfffffff0u})
        EXPECT_REFUSED(withWord(good, 12, wrong), "GLB_CHUNK_TOO_BIG", "");
    EXPECT_REFUSED(withWord(good, 12, 0), "GLB_EMPTY_CHUNK", "");
    EXPECT_REFUSED(withWord(good, 16, 0x004e4942), "GLB_UNEXPECTED_FIRST_CHUNK", "");
    EXPECT_REFUSED(withWord(good, 20 + jsonLength, 0xffffffffu), "GLB_CHUNK_TOO_BIG", "");
    const uint32_t jsonOnly = 20 + jsonLength;
    EXPECT_REFUSED(withWord(good.substr(0, jsonOnly), 8, jsonOnly), "UNDEFINED_PROPERTY",
                   "/buffers/0");
    EXPECT_REFUSED(withWord(good.substr(0, jsonOnly + 4), 8, jsonOnly + 4),
                   "GLB_UNEXPECTED_END_OF_CHUNK_HEADER", "");
}

TEST(GltfContainer, BinaryChunkShorterThanBufferIsRefused)
{
    test::Document document = test::triangle();
    document.json["buffers"] = Json::array({{{"byteLength", document.bin.size() + 100}}});
    const std::vector<std::byte> bytes = document.glb();
    EXPECT_REFUSED(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
                   "BUFFER_BYTE_LENGTH_MISMATCH", "/buffers/0/byteLength");
}

TEST(GltfContainer, TrailingBytesAreIgnoredWithAWarning)
{
    const auto scene = test::loadText(glb() + "rubbish");
    ASSERT_TRUE(scene);
    EXPECT_EQ(test::warning(*scene, "GLB_LENGTH_MISMATCH").message,
              "7 bytes after the end of the GLB — ignored");
}

}  // namespace
