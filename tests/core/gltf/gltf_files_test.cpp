// What the loader may read from the file system (B28-B38, B85, B86), and cancelling it (B88).
#include "core/base/progress.h"
#include "tests/support/scenes/gltf_fixture.h"

#include <chrono>
#include <semaphore>
#include <thread>

#include <sys/stat.h>
#include <unistd.h>

namespace {

using test::Json;

/// The triangle with its buffer in another file, called by `uri`.
std::string withBuffer(const std::string& uri)
{
    test::Document document = test::triangle();
    document.json["buffers"] = Json::array({{{"byteLength", document.bin.size()}, {"uri", uri}}});
    return document.text();
}

/// The triangle with an image as base colour, called by `uri`.
test::Document withImage(const std::string& uri)
{
    test::Document document = test::texturedTriangle(test::bytesOf("unused"));
    document.json["images"][0] = {{"uri", uri}};
    return document;
}

/// Loads `scene.gltf` with that image from `folder`; the warning about the image.
core::Warning imageWarning(const test::TemporaryFolder& folder, const std::string& uri)
{
    const auto scene = core::loadGltf(folder.write("scene/scene.gltf", withImage(uri).text()));
    EXPECT_EQ(scene->textures.at(0).width, 8u) << "the checker";
    return test::warning(*scene, "IMAGE_UNUSABLE");
}

TEST(GltfFiles, BuffersAreReadFromTheFolder)
{
    const test::TemporaryFolder folder;
    const std::vector<std::byte> bin = test::triangle().bin;
    for (const auto& [name, uri] : {std::pair<std::string, std::string>{"a.bin", "a.bin"},
                                    {"with space.bin", "with%20space.bin"},
                                    {"with space.bin", "with space.bin"},
                                    {"sub/\xc3\xa4.bin", "sub/%C3%A4.bin"},
                                    {"sub/\xc3\xa4.bin", "sub/\xc3\xa4.bin"},
                                    {"a.bin", "./sub/../a.bin"}}) {
        folder.write(name, bin);
        const auto scene = core::loadGltf(folder.write("scene.gltf", withBuffer(uri)));
        EXPECT_EQ(scene->warnings.total(), 0u);
        EXPECT_EQ(scene->meshes.at(0).triangles.size(), 1u);
        EXPECT_EQ(scene->fileBytes,
                  bin.size() + std::filesystem::file_size(folder.path() / "scene.gltf"));
    }
    std::vector<std::byte> longer = bin;
    longer.resize(bin.size() + 1000);
    folder.write("a.bin", longer);
    EXPECT_EQ(core::loadGltf(folder.write("scene.gltf", withBuffer("a.bin")))->warnings.total(), 0u)
        << "a file longer than byteLength is valid";
}

TEST(GltfFiles, MissingAndShortBuffersAreRefused)
{
    const test::TemporaryFolder folder;
    const test::Refusal missing =
        test::fileRefusal(folder.write("scene.gltf", withBuffer("gone.bin")));
    EXPECT_EQ(missing.code, "IO_ERROR");
    EXPECT_EQ(missing.pointer, "/buffers/0/uri");
    EXPECT_NE(missing.message.find("scene.gltf: /buffers/0/uri: missing buffer file"),
              std::string::npos)
        << missing.message;
    folder.write("short.bin", std::string("xyz"));
    EXPECT_EQ(test::fileRefusal(folder.write("scene.gltf", withBuffer("short.bin"))).code,
              "BUFFER_BYTE_LENGTH_MISMATCH");
}

TEST(GltfFiles, NothingOutsideTheFolderIsRead)
{
    const test::TemporaryFolder folder;
    const std::vector<std::byte> bin = test::triangle().bin;
    folder.write("outside.bin", bin);
    folder.write("scene2/outside.bin", bin);
    std::filesystem::create_directories(folder.path() / "scene");
    std::filesystem::create_symlink(folder.path() / "outside.bin",
                                    folder.path() / "scene/link.bin");
    const std::string absolute = (folder.path() / "outside.bin").string();
    for (const std::string& uri :
         {std::string("../outside.bin"), std::string("..%2foutside.bin"),
          std::string("%2e%2e/outside.bin"), std::string("../scene2/outside.bin"), absolute,
          std::string("link.bin")}) {
        const auto file = folder.write("scene/scene.gltf", withBuffer(uri));
        const test::Refusal refused = test::fileRefusal(file);
        EXPECT_EQ(refused.code, "IO_ERROR") << uri;
        EXPECT_NE(refused.message.find("outside the scene's folder"), std::string::npos)
            << refused.message;
        core::LoadOptions trusting;
        trusting.allowOutside = true;
        EXPECT_EQ(core::loadGltf(file, trusting)->meshes.size(), 1u) << uri;
    }
    EXPECT_NE(imageWarning(folder, "../../../../etc/passwd").message.find("outside"),
              std::string::npos);
    EXPECT_NE(imageWarning(folder, "/etc/passwd").message.find("outside"), std::string::npos);
}

TEST(GltfFiles, TheCurrentFolderIsNotSearched)
{
    const test::TemporaryFolder folder;
    folder.write("elsewhere/a.bin", test::triangle().bin);
    const auto file = folder.write("scene/scene.gltf", withBuffer("a.bin"));
    const std::filesystem::path before = std::filesystem::current_path();
    std::filesystem::current_path(folder.path() / "elsewhere");
    const test::Refusal refused = test::fileRefusal(file);
    std::filesystem::current_path(before);
    EXPECT_EQ(refused.code, "IO_ERROR");
}

TEST(GltfFiles, RemoteSchemesAreNotFollowed)
{
    const test::TemporaryFolder folder;
    for (const char* uri :
         {"http://example.org/a.bin", "file:///etc/passwd", "ftp:a", "C:/a.bin"}) {
        const test::Refusal refused =
            test::fileRefusal(folder.write("scene.gltf", withBuffer(uri)));
        EXPECT_EQ(refused.code, "IO_ERROR");
        EXPECT_NE(refused.message.find("not supported"), std::string::npos) << refused.message;
        EXPECT_NE(imageWarning(folder, uri).message.find("not supported"), std::string::npos);
    }
}

TEST(GltfFiles, OnlyRegularFilesAreRead)
{
    const test::TemporaryFolder folder;
    std::filesystem::create_directories(folder.path() / "scene/sub");
    ASSERT_EQ(mkfifo((folder.path() / "scene/pipe").c_str(), 0600), 0);
    for (const char* uri : {"sub", "pipe"}) {
        EXPECT_EQ(test::fileRefusal(folder.write("scene/scene.gltf", withBuffer(uri))).code,
                  "IO_ERROR");
        EXPECT_NE(imageWarning(folder, uri).message.find("not a"), std::string::npos);
    }
    core::LoadOptions trusting;
    trusting.allowOutside = true;
    const test::Refusal device =
        test::fileRefusal(folder.write("scene/scene.gltf", withBuffer("/dev/zero")), trusting);
    EXPECT_NE(device.message.find("not a regular file"), std::string::npos) << device.message;
    EXPECT_EQ(test::fileRefusal(folder.path() / "scene").code, "IO_ERROR") << "a folder is dropped";
    EXPECT_EQ(test::fileRefusal(folder.path() / "scene/pipe").code, "IO_ERROR");
    EXPECT_NE(test::fileRefusal(folder.path() / "none.gltf").message.find("No such file"),
              std::string::npos);
}

TEST(GltfFiles, ImageNamesRunNoCommands)
{
    const test::TemporaryFolder folder;
    const std::string marker = (folder.path() / "ran").string();
    for (const std::string& uri : {"`touch " + marker + "`", "$(touch " + marker + ")",
                                   std::string("a%00b.png"), std::string("%zz")})
        EXPECT_EQ(imageWarning(folder, uri).pointer, "/images/0");
    EXPECT_FALSE(std::filesystem::exists(marker));
}

TEST(GltfFiles, LargeFilesAreRefusedWithTheNumbers)
{
    const test::TemporaryFolder folder;
    const auto file = folder.write("scene.gltf", withBuffer("big.bin"));
    const auto big = folder.write("big.bin", std::string("x"));
    std::filesystem::resize_file(big, (uint64_t{1} << 20) + 1);
    core::LoadOptions small;
    small.maxFileMb = 1;
    EXPECT_NE(test::fileRefusal(file, small).message.find("--max-file-mb"), std::string::npos);
    EXPECT_EQ(test::fileRefusal(big, small).code, "IO_ERROR");
}

TEST(GltfFiles, UnreadableFilesSayWhy)
{
    if (geteuid() == 0) GTEST_SKIP() << "root may read everything";
    const test::TemporaryFolder folder;
    const auto file = folder.write("scene.gltf", test::triangle().text());
    std::filesystem::permissions(file, std::filesystem::perms::none);
    EXPECT_NE(test::fileRefusal(file).message.find("Permission denied"), std::string::npos);
}

TEST(GltfFiles, StrangePathsWork)
{
    const test::TemporaryFolder folder;
    const auto file = folder.write("a b/\xc3\xbc \xe2\x82\xac.gltf", test::triangle().text());
    EXPECT_EQ(core::loadGltf(file)->meshes.size(), 1u);
    EXPECT_EQ(test::fileRefusal(folder.path() / std::string(4096, 'x')).code, "IO_ERROR");
}

TEST(GltfFiles, HashFollowsContentAlone)
{
    const test::TemporaryFolder folder;
    std::vector<std::byte> bin = test::triangle().bin;
    folder.write("one/a.bin", bin);
    const std::string one = core::loadGltf(folder.write("one/x.gltf", withBuffer("a.bin")))->hash;
    folder.write("two/a.bin", bin);
    EXPECT_EQ(core::loadGltf(folder.write("two/y.gltf", withBuffer("a.bin")))->hash, one);
    EXPECT_EQ(one.size(), 16u);
    EXPECT_EQ(one.find_first_not_of("0123456789abcdef"), std::string::npos);
    bin[12] = std::byte{1};
    folder.write("two/a.bin", bin);
    EXPECT_NE(core::loadGltf(folder.path() / "two/y.gltf")->hash, one);
    EXPECT_NE(core::loadGltf(folder.write("one/x.gltf", withBuffer("a.bin") + " "))->hash, one);
}

TEST(GltfFiles, ImageContentIsHashedToo)
{
    const test::TemporaryFolder folder;
    const auto file = folder.write("scene.gltf", withImage("a.png").text());
    folder.write("a.png", test::encodeImage("png", 1, 1, 3, std::vector<uint8_t>{1, 2, 3}));
    const std::string before = core::loadGltf(file)->hash;
    EXPECT_EQ(core::loadGltf(file)->hash, before);
    folder.write("a.png", test::encodeImage("png", 1, 1, 3, std::vector<uint8_t>{1, 2, 4}));
    EXPECT_NE(core::loadGltf(file)->hash, before);
}

TEST(GltfFiles, StoppingLeavesAtOnce)
{
    std::stop_source source;
    source.request_stop();
    try {
        core::loadGltfFromMemory(test::bytesOf(test::triangle().text()), "test.gltf", {},
                                 source.get_token());
        FAIL() << "loaded although asked to stop";
    } catch (const core::Error& error) {
        EXPECT_EQ(error.code(), core::ExitCode::interrupted);
    }
}

TEST(GltfFiles, StoppingIsNoticedInEveryStage)
{
    const test::TemporaryFolder folder;
    test::Document document = withImage("a.png");
    folder.write("a.png", test::encodeImage("png", 1, 1, 3, std::vector<uint8_t>{1, 2, 3}));
    const auto file = folder.write("scene.gltf", document.text());
    size_t stages = 0;
    core::loadGltf(file, {}, [&](const char*, double fraction) {
        ++stages;
        EXPECT_TRUE(fraction == core::kUnknownShare || (fraction >= 0 && fraction <= 1))
            << fraction;
    });
    ASSERT_GE(stages, 5u);
    for (size_t last = 1; last < stages; ++last) {
        std::stop_source source;
        size_t seen = 0;
        const auto stopHere = [&](const char*, double) {
            if (++seen == last) source.request_stop();
        };
        EXPECT_THROW(core::loadGltf(file, {}, stopHere, source.get_token()), core::Error);
        EXPECT_EQ(seen, last) << "no stage begins after the one that stopped";
    }
}

/// The stop comes while targets are added; the last of them would refuse the file.
TEST(GltfFiles, StoppingIsNoticedBetweenMorphTargets)
{
    constexpr size_t kVertices = 99'999, kTargets = 30'000;
    test::Document document = test::triangle();
    const uint16_t index = 0;
    const float value[] = {0, 0, 1};
    const int indexView = document.view(&index, sizeof index);
    const int valueView = document.view(value, sizeof value);
    Json& accessors = document.json["accessors"];
    accessors.push_back(
        {{"componentType", test::kFloat},
         {"count", kVertices},
         {"type", "VEC3"},
         {"sparse",
          {{"count", 1},
           {"indices", {{"bufferView", indexView}, {"componentType", test::kUnsignedShort}}},
           {"values", {{"bufferView", valueView}}}}}});
    const size_t stored = accessors.size() - 1;
    accessors.push_back({{"componentType", 5124}, {"count", 1}, {"type", "VEC3"}});
    std::vector<Json> targets(kTargets, {{"POSITION", stored}});
    targets.back()["POSITION"] = accessors.size() - 1;
    document.primitive() = {{"attributes", {{"POSITION", stored}}}, {"targets", targets}};
    document.json["meshes"][0]["weights"] = std::vector<int>(kTargets, 1);
    const test::TemporaryFolder folder;
    const auto file = folder.write("scene.gltf", document.text());

    std::binary_semaphore begun(0);
    std::stop_source source;
    std::jthread stopper([&] {
        begun.acquire();
        std::this_thread::sleep_for(
            std::chrono::milliseconds(20));  // past the mesh's own beginning
        source.request_stop();
    });
    const auto progress = [&](const char* stage, double) {
        if (std::string_view(stage) == "meshes") begun.release();
    };
    try {
        core::loadGltf(file, {}, progress, source.get_token());
        FAIL() << "loaded although asked to stop";
    } catch (const core::Error& error) {
        EXPECT_EQ(error.code(), core::ExitCode::interrupted) << error.what();
    }
}

}  // namespace
