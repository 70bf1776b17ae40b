// Thousands of damaged documents, always the same ones: each must load or be refused, nothing else.
// Run under the address and undefined-behaviour sanitizers it is a small fuzzer; tests/fuzz has the
// unbounded one.
#include "tests/support/scenes/gltf_fixture.h"

#include <random>

namespace {

using test::Json;

/// A document with a little of everything, so that damage reaches every part of the loader.
test::Document rich()
{
    test::Document document =
        test::texturedTriangle(test::encodeImage("png", 4, 4, 4, std::vector<uint8_t>(64, 90)));
    document.attributes()["NORMAL"] =
        document.values<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, test::kFloat, "VEC3", 3);
    document.attributes()["COLOR_0"] =
        document.values<uint8_t>(std::vector<uint8_t>(12, 70), test::kUnsignedByte, "VEC4", 4);
    document.json["accessors"].back()["normalized"] = true;
    document.attributes()["TEXCOORD_1"] = document.attributes()["TEXCOORD_0"];
    document.primitive()["targets"] = Json::array({{{"POSITION", 0}}});
    document.json["meshes"][0]["weights"] = {0.5};
    const std::vector<uint16_t> sparse{0, 2};
    const std::vector<float> replaced{1, 1, 1, 2, 2, 2};
    document.json["accessors"][0]["sparse"] = {
        {"count", 2},
        {"indices", {{"bufferView", document.view(sparse.data(), 4)}, {"componentType", 5123}}},
        {"values", {{"bufferView", document.view(replaced.data(), 24)}}}};
    document.material() = Json::parse(
        R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}},"normalTexture":{"index":0,"texCoord":1},
        "emissiveFactor":[1,1,1],"alphaMode":"MASK","extensions":{"KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":2},
        "KHR_materials_transmission":{"transmissionFactor":1}}})");
    document.json["nodes"] = Json::parse(
        R"([{"children":[1,2],"rotation":[0,0,0,1]},{"mesh":0,"scale":[1,2,3]},{"camera":0,"extensions":{"KHR_lights_punctual":{"light":0}}}])");
    document.json["cameras"] =
        Json::parse(R"([{"type":"perspective","perspective":{"yfov":1,"znear":0.1}}])");
    document.json["extensions"]["KHR_lights_punctual"]["lights"] =
        Json::parse(R"([{"type":"spot","spot":{"outerConeAngle":0.5}}])");
    document.json["extensionsUsed"] = {"KHR_lights_punctual", "KHR_materials_volume"};
    const int times = document.values<float>({0, 1}, test::kFloat, "SCALAR", 1);
    const int values = document.values<float>({0, 0, 0, 1, 1, 1}, test::kFloat, "VEC3", 3);
    document.json["animations"] = Json::array(
        {{{"channels",
           Json::array({{{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}}})},
          {"samplers", Json::array({{{"input", times}, {"output", values}}})}}});
    document.json["scenes"][0]["extras"]["sun"] = {{"directionTowardsSun", {0, 1, 0}},
                                                   {"radiance", {1, 1, 1}}};
    return document;
}

/// Loads; true when it was refused. Anything but a scene or a LoadError fails the test.
bool refuses(const std::string& text)
{
    try {
        core::LoadOptions options;
        options.maxMemoryMb = 64;
        const auto scene = core::loadGltfFromMemory(test::bytesOf(text), "mutant.gltf", options);
        for (const core::Mesh& mesh : scene->meshes) {
            for (const glm::uvec3& t : mesh.triangles)
                if (std::max({t.x, t.y, t.z}) >= mesh.positions.size())
                    ADD_FAILURE() << "index out of range in a scene";
            if (static_cast<size_t>(mesh.material) >= scene->materials.size())
                ADD_FAILURE() << "no such material";
        }
        return false;
    } catch (const core::LoadError&) {
        return true;
    }
}

/// Random bytes replaced, removed, doubled, or swapped for tokens that mean something.
std::string mutate(std::string text, std::mt19937& random)
{
    static const std::vector<std::string> tokens{
        "0",     "-1",   "1e999", "4294967296", "18446744073709551615",
        "1e18",  "null", "true",  "[]",         "{}",
        "\"x\"", "9",    "255",   "0.5",        "\"POSITION\"",
        ",",     "5126", "5121",  "\"VEC4\"",   "\"SCALAR\""};
    const auto below = [&](size_t n) {
        return std::uniform_int_distribution<size_t>(0, n - 1)(random);
    };
    const size_t edits = 1 + below(4);
    for (size_t i = 0; i < edits && !text.empty(); ++i) {
        const size_t at = below(text.size());
        switch (below(6)) {
        case 0:
            text[at] = static_cast<char>(below(256));
            break;
        case 1:
            text.erase(at, 1 + below(8));
            break;
        case 2:
            text.insert(at, text.substr(below(text.size()), 1 + below(32)));
            break;
        case 3:
            text[at] = static_cast<char>(static_cast<unsigned char>(text[at]) ^ (1u << below(7)));
            break;
        default: {
            // A whole number or word becomes a token: keeps the syntax valid, so that the damage
            // reaches deep.
            const size_t start = text.find_first_of("0123456789", at);
            if (start == std::string::npos) break;
            const size_t end = text.find_first_not_of("0123456789.", start);
            text.replace(start, end - start, tokens[below(tokens.size())]);
        }
        }
    }
    return text;
}

/// Both outcomes must be common, or the mutations test nothing but the parser.
void expectBothOutcomes(size_t refused, size_t count)
{
    EXPECT_GT(refused, count / 10);
    EXPECT_LT(refused, count * 19 / 20);
}

TEST(GltfMutation, DamagedTextLoadsOrIsRefused)
{
    // The buffer's content is put in afterwards: its base64 is most of the text, and damaging it
    // shows little.
    constexpr std::string_view kPlace = "@CONTENT@";
    constexpr size_t kCount = 12000;
    const test::Document document = rich();
    const std::string content =
        "data:application/octet-stream;base64," + test::base64(document.bin);
    Json json = document.json;
    json["buffers"] = Json::array({{{"byteLength", document.bin.size()}, {"uri", kPlace}}});
    const std::string text = json.dump();
    const auto complete = [&](std::string mutant) {
        const size_t place = mutant.find(kPlace);
        return place == std::string::npos ? mutant : mutant.replace(place, kPlace.size(), content);
    };
    ASSERT_FALSE(refuses(complete(text)));
    std::mt19937 random(1);
    size_t refused = 0;
    for (size_t i = 0; i < kCount; ++i)
        refused += refuses(complete(mutate(text, random))) ? 1u : 0u;
    expectBothOutcomes(refused, kCount);
}

TEST(GltfMutation, DamagedContainersLoadOrAreRefused)
{
    constexpr size_t kCount = 6000;
    const test::Document document = rich();
    const std::vector<std::byte> glb = document.glb();
    const std::string text(reinterpret_cast<const char*>(glb.data()), glb.size());
    ASSERT_FALSE(refuses(text));
    for (size_t keep = 0; keep < text.size(); keep += 1 + text.size() / 200)
        EXPECT_TRUE(refuses(text.substr(0, keep)));
    // Every byte of the binary chunk may be anything: pixels, positions, indices, times.
    std::mt19937 random(2);
    size_t refused = 0;
    for (size_t i = 0; i < kCount; ++i) {
        std::string mutant = text;
        for (size_t k = 0; k < 8; ++k)
            mutant[text.size() - 1 - random() % document.bin.size()] =
                static_cast<char>(random() & 0xffu);
        refused += refuses(mutant) ? 1u : 0u;
    }
    expectBothOutcomes(refused, kCount);
}

}  // namespace
