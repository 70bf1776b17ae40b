// A million of something must not take more than half a gigabyte, the program's own 140 MiB
// included: what a tenth of that takes, from the tree of the text to the world. Memory that runs
// out all the same is told apart from bad files (B80).
#include "tests/support/scenes/gltf_fixture.h"

#include <new>
#include <string>
#include <string_view>

#include "core/scene/world.h"
#include "tests/support/process/allocation_count.h"

namespace {

using test::Json;

constexpr size_t kManyNodes = 100'000;
// 512 MiB without the program, by a million. Blocks of the JSON tree count as a whole here, though
// the last one is not filled.
constexpr uint64_t kBytesEach = 390;

/// The triangle and so many nodes; `node` gives the text of each. All are roots unless the first is
/// above all.
template <class Text> std::string repeatedNodes(test::Document document, bool one, const Text& node)
{
    document.json["nodes"] = Json::array({"NODES"});
    document.json["scenes"] = Json::parse(R"([{"nodes":"ROOTS"}])");
    std::string nodes, roots = "[0";
    for (size_t i = 0; i < kManyNodes; ++i) nodes += std::string(i > 0 ? "," : "") + node(i);
    for (size_t i = 1; i < kManyNodes && !one; ++i) roots += ',' + std::to_string(i);
    std::string text = document.text();
    text.replace(text.find("\"NODES\""), 7, nodes);
    text.replace(text.find("\"ROOTS\""), 7, roots + "]");
    return text;
}

/// As `repeatedNodes`, with channels that move them along the same way.
std::string withChannels(std::string text, const std::string& channels)
{
    text.replace(text.find("\"CHANNELS\""), 10, channels);
    return text;
}

test::Document withSampler()
{
    test::Document document = test::triangle();
    const auto input = document.values(std::vector<float>{0, 1}, test::kFloat, "SCALAR", 1);
    const auto output =
        document.values(std::vector<float>{0, 0, 0, 1, 2, 3}, test::kFloat, "VEC3", 3);
    document.json["animations"] =
        Json::array({{{"samplers", Json::array({{{"input", input}, {"output", output}}})},
                      {"channels", Json::array({"CHANNELS"})}}});
    return document;
}

std::string channelText(size_t node)
{
    return R"({"sampler":0,"target":{"path":"translation","node":)" + std::to_string(node) + "}}";
}

std::string place(size_t i)
{
    return std::to_string(i % 317) + ".5," + std::to_string(i / 317) + ".25,0";
}

/// Loads the text, makes a world of it and asserts what both took.
void expectFew(const std::string& text, size_t shown)
{
    tests::watchPeak();
    std::shared_ptr<const core::Scene> scene = test::loadText(text);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->nodes.size(), kManyNodes);
    EXPECT_EQ(scene->warnings.total(), 0u);
    const auto world = core::makeWorld(scene);
    EXPECT_EQ(world->triangles.size(), shown);
    if (!tests::allocationsAreCounted()) return;
    EXPECT_LT(tests::peakBytes(), kManyNodes * kBytesEach);
}

TEST(GltfMemory, NodesThatShowOneMesh)
{
    expectFew(repeatedNodes(test::triangle(), false,
                            [](size_t i) {
                                return R"({"name":"node )" + std::to_string(i) +
                                       R"(","mesh":0,"translation":[)" + place(i) +
                                       R"(],"rotation":[0,0,0,1],"scale":[1,1,1]})";
                            }),
              kManyNodes);
}

TEST(GltfMemory, NodesWithMatrices)
{
    expectFew(repeatedNodes(test::triangle(), false,
                            [](size_t i) {
                                return R"({"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,)" +
                                       place(i) + R"(,1],"name":"node )" + std::to_string(i) +
                                       "\"}";
                            }),
              kManyNodes);
}

TEST(GltfMemory, NodesBelowOneThatMoves)
{
    std::string children = "[1";
    for (size_t i = 2; i < kManyNodes; ++i) children += ',' + std::to_string(i);
    const std::string text = repeatedNodes(withSampler(), true, [&](size_t i) {
        return i == 0 ? R"({"children":)" + children + "]}"
                      : R"({"name":"node","mesh":0,"translation":[)" + place(i) + "]}";
    });
    expectFew(withChannels(text, channelText(0)), kManyNodes - 1);
}

TEST(GltfMemory, NodesThatEachMove)
{
    std::string channels = channelText(0);
    for (size_t i = 1; i < kManyNodes; ++i) channels += ',' + channelText(i);
    const std::string text =
        repeatedNodes(withSampler(), false, [](size_t) { return R"({"mesh":0})"; });
    expectFew(withChannels(text, channels), kManyNodes);
}

/// Memory that runs out while a scene is read is no fault of the file (exit code 5, not 3).
TEST(GltfMemory, RunningOutIsARefusalWithACodeOfItsOwn)
{
    const test::TemporaryFolder folder;
    const auto file = folder.write("scene.gltf", test::triangle().text());
    const auto runOut = [](const char* stage, double) {
        if (std::string_view(stage) == "meshes") throw std::bad_alloc();
    };
    try {
        core::loadGltf(file, {}, runOut);
        FAIL() << "loaded without memory";
    } catch (const core::LoadError& error) {
        EXPECT_EQ(error.code(), "OUT_OF_MEMORY");
        EXPECT_EQ(static_cast<const core::Error&>(error).code(), core::ExitCode::deviceLost);
        EXPECT_NE(std::string(error.what()).find("scene.gltf: "), std::string::npos);
    }
}

}  // namespace
