// The program beside files that mean it no good: where it writes, what it prints, what it reads
// (B95-B97, B103).
#include <sys/stat.h>

#include <thread>

#include "tests/support/files/picture_bytes.h"
#include "tests/support/process/program.h"
#include "tests/support/scenes/gltf_fixture.h"

namespace {

using namespace tests;

Strings small(const std::string& output)
{
    return {"render", kScene, "-o", output, "--device", "cpu", "--size", "16x12", "--spp", "1"};
}

// --- outputs

TEST_F(Cli, StatsIntoDevicesAndPipes)
{
    EXPECT_EQ(run(small("a.exr") + Strings{"--stats", "/dev/null"}).code, 0);
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
    const Result full = run(small("b.exr") + Strings{"--stats", "/dev/full"});
    EXPECT_EQ(full.code, 3);
    EXPECT_TRUE(contains(full.err, "/dev/full: cannot be written: ")) << full.err;
    EXPECT_TRUE(fs::is_character_file("/dev/full"));
    const Result standard = run(small("c.exr") + Strings{"--stats", "/dev/stdout", "--quiet"});
    EXPECT_EQ(standard.code, 0);
    EXPECT_EQ(Json::parse(standard.out).at("command"), "render");

    ASSERT_EQ(mkfifo(work("pipe").c_str(), 0600), 0);
    std::string got;
    std::thread reader([&] { got = readAll(work("pipe")); });
    EXPECT_EQ(run(small("d.exr") + Strings{"--stats", "pipe"}).code, 0);
    reader.join();
    EXPECT_EQ(Json::parse(got).at("command"), "render");
    EXPECT_TRUE(fs::is_fifo(work("pipe")));
}

TEST_F(Cli, PicturesBehindLinks)
{
    fs::create_directory(work("far"));
    fs::create_symlink("far/picture.exr", work("link.exr"));
    EXPECT_EQ(run(small("link.exr")).code, 0);
    EXPECT_TRUE(fs::is_symlink(work("link.exr")));
    EXPECT_EQ(exr("far/picture.exr").layers.front().image.width, 16u);
    EXPECT_EQ(files(), (std::set<std::string>{"link.exr", "far/picture.exr"}));
}

TEST_F(Cli, OneFileForTwoThings)
{
    expectRefused(small("x.exr") + Strings{"--stats", "x.exr"}, 2, "--stats x.exr");
    fs::create_symlink("x.exr", work("y.json"));
    expectRefused(small("x.exr") + Strings{"--stats", "y.json"}, 2, "--stats y.json");
}

/// Neither pictures nor statistics go into a file that the command reads, however it is named.
TEST_F(Cli, InputsAreNotWrittenOver)
{
    writeFile("room.gltf", test::triangle().text());
    fs::create_symlink("room.gltf", work("link.exr"));
    for (const char* name : {"ref.exr", "sky.exr", "f-3.png", "view.json", "path.json"})
        writeFile(name, "what is not to be lost");
    const Strings room{"render", "room.gltf", "--device", "cpu", "--size", "8x8", "--spp", "1"};
    const auto refused = [&](const Strings& more, const std::string& text) {
        expectRefused(room + more, 2, text);
    };
    const Strings picture{"-o", "new.exr"};
    refused({"-o", "ref.exr", "--reference", "./ref.exr"},
            "-o ref.exr: is the file of --reference");
    refused({"-o", "sky.exr", "--environment", "sky.exr"}, "--environment");
    refused({"-o", "link.exr"}, "the scene's file");
    refused(picture + Strings{"--stats", "room.gltf"}, "--stats room.gltf: is the scene's file");
    refused(picture + Strings{"--stats", "ref.exr", "--reference", "ref.exr"}, "--stats ref.exr");
    refused(picture + Strings{"--stats", "view.json", "--camera", "view.json"}, "--camera");
    const Strings frames{"-o", "f-%d.png", "--path", "path.json", "--frames", "0-5"};
    refused(frames + Strings{"--stats", "path.json"}, "--path");
    refused(frames + Strings{"--stats", "f-5.png"}, "--stats f-5.png: is the picture's file");
    refused(frames + Strings{"--environment", "f-3.png"}, "-o f-3.png: is the file of --env");
    for (const char* name : {"ref.exr", "sky.exr", "f-3.png", "view.json", "path.json"})
        EXPECT_EQ(readAll(work(name)), "what is not to be lost") << name;
    // A word for an environment is no file.
    EXPECT_EQ(run(room + picture + Strings{"--environment", "plain", "--stats", "plain"}).code, 0);
}

/// Nor into buffers and images, however the scene names them.
TEST_F(Cli, FilesOfTheSceneAreNotWrittenOver)
{
    const std::string json =
        R"({"asset":{"version":"2.0"},"buffers":[{"uri":"data.bin.exr","byteLength":4}],)"
        R"("images":[{"uri":"wall%20paper.png"},{"uri":"data:image/png;base64,AA=="}]})";
    std::string glb = "glTF";
    const auto add = [&glb](size_t number) {
        for (int i = 0; i < 4; ++i) glb += static_cast<char>(number >> (8 * i));
    };
    add(2);
    add(20 + json.size());
    add(json.size());
    writeFile("room.glb", glb + "JSON" + json);
    writeFile("room.gltf", json);
    for (const char* name : {"data.bin.exr", "wall paper.png"}) writeFile(name, "mine");
    for (const char* scene : {"room.gltf", "room.glb"}) {
        const Strings room{"render", scene, "--device", "cpu"};
        expectRefused(room + Strings{"-o", "wall paper.png"}, 2, "a file of the scene's");
        expectRefused(room + Strings{"-o", "./data.bin.exr"}, 2, "a file of the scene's");
        expectRefused(room + Strings{"-o", "x.exr", "--stats", "wall paper.png"}, 2, "--stats");
    }
}

/// The loader turns the slashes of Windows, trims what pads a GLB's text, and looks beside the file
/// that a link leads to: what is protected are the files that it finds.
TEST_F(Cli, FilesThatOnlyTheLoaderFindsAreNotWrittenOver)
{
    const auto naming = [](const std::string& uri) {
        return R"({"asset":{"version":"2.0"},"images":[{"uri":")" + uri + R"("}]})";
    };
    fs::create_directories(work("far/textures"));
    fs::create_directories(work("near"));
    writeFile("far/textures/a.png", "mine");
    writeFile("far/back.gltf", naming(R"(textures\\a.png)"));
    writeFile("far/s.gltf", naming("textures/a.png"));
    fs::create_symlink("../far/s.gltf", work("near/s.gltf"));
    std::string glb = "glTF", json = naming("textures/a.png");
    json.resize(json.size() + 4 - json.size() % 4, '\0');
    for (const size_t number : {size_t{2}, 20 + json.size(), json.size()})
        for (int i = 0; i < 4; ++i) glb += static_cast<char>(number >> (8 * i));
    writeFile("far/nul.glb", glb + "JSON" + json);
    for (const char* scene : {"far/back.gltf", "near/s.gltf", "far/nul.glb"}) {
        SCOPED_TRACE(scene);
        expectRefused({"render", scene, "--device", "cpu", "-o", "far/textures/a.png"}, 2,
                      "a file of the scene's");
    }
    EXPECT_EQ(readAll(work("far/textures/a.png")), "mine");
}

TEST_F(Cli, ALimitOnFileSizesIsAMessage)
{
    const std::string binary = program;
    program = "/bin/sh";
    const Result result = run(Strings{"-c", "ulimit -f 1; exec \"$0\" \"$@\"", binary} +
                              Strings{"render", kScene, "-o", "x.exr", "--device", "cpu", "--size",
                                      "128x128", "--spp", "1", "--quiet"});
    EXPECT_EQ(result.code, 3) << result.err;
    EXPECT_TRUE(contains(result.err, "x.exr: cannot be written: File too large")) << result.err;
    EXPECT_TRUE(files().empty());
}

// --- nesting

std::string nested(size_t depth)
{
    return std::string(depth, '[') + std::string(depth, ']');
}

TEST_F(Cli, DeepJsonIsRefusedEverywhere)
{
    writeFile("deep.json", nested(200000));
    writeFile("object.json", R"({"steps": )" + nested(200000) + "}");
    writeFile("deep.gltf", R"({"asset": {"version": "2.0"}, "extras": )" + nested(200000) + "}");
    const std::string deep = "nested deeper than 64 levels";
    expectRefused({"view", kScene, "--script", "deep.json"}, 3, deep);
    expectRefused({"view", kScene, "--script", "object.json"}, 3, deep);
    expectRefused({"info", "deep.gltf"}, 3, deep);
    expectRefused(small("x.exr") + Strings{"--camera", "deep.json"}, 3, deep);
    expectRefused({"render", kScene, "-o", "%d.png", "--path", "deep.json", "--frames", "0-1",
                   "--device", "cpu"},
                  3, deep);
    const Bytes png = test::encodeImage("png", 1, 1, 3, std::vector<uint8_t>{1, 2, 3});
    for (const char* key : {"camera", "params"}) {
        std::string metadata;
        Bytes chunks;
        for (const auto& [name, value] : std::map<std::string, std::string>{{"scene", kScene},
                                                                            {"scene_hash", "0"},
                                                                            {"camera", "{}"},
                                                                            {"width", "8"},
                                                                            {"height", "8"},
                                                                            {"method", "path"},
                                                                            {"params", "{}"},
                                                                            {"spp", "1"}})
            chunks = chunks + pngChunk("tEXt", bytesOf("rekindle:" + name) + Bytes(1) +
                                                   bytesOf(name == key ? nested(200000) : value));
        const Bytes bytes = behindHeader(png, chunks);
        writeFile("shot.png", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
        expectRefused({"view", "--replay", "shot.png"}, 3, deep, kNoDisplay);
    }
}

// --- work that grows faster than the file

void writeGlb(const fs::path& file, const test::Document& document)
{
    const std::vector<std::byte> bytes = document.glb();
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
}

/// One node a million times among the joints of a skin whose matrices are nearly all zeros: to walk
/// the others once for each joint would take minutes.
TEST_F(Cli, SkinsOfAMillionJointsAreReadAtOnce)
{
    constexpr size_t kJoints = 1'000'000, kStored = 400'000;
    test::Document document = test::triangle();
    document.json["nodes"] = Json::parse(R"([{"mesh":0,"skin":0},{}])");
    document.json["scenes"][0]["nodes"] = {0, 1};
    std::vector<uint32_t> indices(kStored);
    for (size_t i = 0; i < kStored; ++i) indices[i] = static_cast<uint32_t>(2 * i);
    const std::vector<float> matrices(16 * kStored, 0.0f);
    const int places = document.view(indices.data(), indices.size() * sizeof(uint32_t));
    const int values = document.view(matrices.data(), matrices.size() * sizeof(float));
    document.json["accessors"].push_back(
        {{"componentType", test::kFloat},
         {"count", kJoints},
         {"type", "MAT4"},
         {"sparse",
          {{"count", kStored},
           {"indices", {{"bufferView", places}, {"componentType", test::kUnsignedInt}}},
           {"values", {{"bufferView", values}}}}}});
    document.json["skins"] =
        Json::array({{{"joints", std::vector<int>(kJoints, 1)},
                      {"inverseBindMatrices", document.json["accessors"].size() - 1}}});
    writeGlb(work("joints.glb"), document);
    const Result result = run({"info", "joints.glb"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_TRUE(contains(result.out, "ACCESSOR_INVALID_IBM")) << result.out;
}

/// Morph targets of zeros that cost the file nothing, for as many vertices that cost nothing
/// either.
TEST_F(Cli, TargetsOfZerosAreNotAdded)
{
    constexpr size_t kVertices = 999'999, kTargets = 100'000;
    test::Document document = test::triangle();
    document.json["accessors"].push_back(
        {{"componentType", test::kFloat}, {"count", kVertices}, {"type", "VEC3"}});
    const size_t zeros = document.json["accessors"].size() - 1;
    Json& primitives = document.json["meshes"][0]["primitives"];
    primitives.push_back({{"attributes", {{"POSITION", zeros}}},
                          {"targets", std::vector<Json>(kTargets, {{"POSITION", zeros}})}});
    primitives[0]["targets"] = std::vector<Json>(kTargets, Json::object());
    document.json["meshes"][0]["weights"] = std::vector<int>(kTargets, 1);
    writeFile("targets.gltf", document.text());
    const Result result = run({"info", "targets.gltf"});
    EXPECT_EQ(result.code, 0) << result.err;
}

// --- what reaches the terminal

/// Nothing but letters, line breaks and what UTF-8 is made of.
void expectHarmless(const std::string& text)
{
    EXPECT_EQ(text.find('\x1b'), std::string::npos);
    EXPECT_EQ(text.find('\r'), std::string::npos);
    EXPECT_EQ(text.find("\nwarning: forged"), std::string::npos);
    EXPECT_NO_THROW((void)Json(text).dump());
}

TEST_F(Cli, NamesFromFilesForgeNothing)
{
    const std::string evil = "\x1b]0;title\a\r\nwarning: forged\x7f \xc2\x9b"
                             "2J \u202e";
    test::Document document = test::triangle();
    document.json["materials"] = Json::array({{{"name", evil}, {"alphaMode", evil}}});
    document.primitive()["material"] = 0;
    document.json["cameras"] = Json::array({{{"name", evil}, {"type", evil}}});
    document.json["nodes"][0]["name"] = evil;
    document.json["scenes"] = Json::array({{{"name", evil}, {"nodes", {0}}}});
    document.json["extensionsUsed"] = Json::array({evil});
    document.attributes()[evil] = 99999;
    document.attributes().erase(evil);
    writeFile("evil.gltf", document.text());
    const Result text = run({"info", "evil.gltf"}), json = run({"info", "evil.gltf", "--json"});
    EXPECT_EQ(text.code, 0) << text.err;
    expectHarmless(text.out + text.err);
    expectHarmless(json.out + json.err);
    EXPECT_TRUE(contains(text.out, "\\x1b]0;title")) << text.out;
    document.json["extensionsRequired"] = Json::array({evil});
    writeFile("evil.gltf", document.text());
    const Result refused = run({"info", "evil.gltf"});
    EXPECT_EQ(refused.code, 3);
    EXPECT_EQ(lineCount(refused.err), 1u);
    expectHarmless(refused.err);
}

TEST_F(Cli, InfoOfLongNamesAndNamesThatAreNoUtf8)
{
    test::Document document = test::triangle();
    std::string name = "x";
    for (int i = 0; i < 400; ++i) name += "木";
    document.json["extensionsUsed"] = Json::array({name});
    document.json["nodes"][0]["name"] = name;
    document.json["images"] = Json::array({{{"uri", name}}});
    document.json["textures"] = Json::array({{{"source", 0}}});
    document.json["samplers"] = Json::array({{{"name", name}}});
    document.material()["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
    writeFile("long.gltf", document.text());
    const Result result = run({"info", "long.gltf", "--json"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_TRUE(Json::accept(result.out));
    writeFile("na\xff"
              "me.gltf",
              test::triangle().text());
    const Result bytes = run({"info",
                              "na\xff"
                              "me.gltf",
                              "--json"});
    EXPECT_EQ(bytes.code, 0) << bytes.err;
    EXPECT_TRUE(Json::accept(bytes.out));
    EXPECT_EQ(
        run({"render",
             "na\xff"
             "me.gltf",
             "-o", "x.png", "--device", "cpu", "--size", "8x8", "--spp", "1", "--stats", "s.json"})
            .code,
        0);
    EXPECT_NO_THROW((void)stats("s.json"));
}

}  // namespace
