// The program as a person or a script meets it: the real binary, its exit codes, its streams, what
// it refuses and what it tells of itself.
#include "tests/support/files/pattern.h"
#include "tests/support/process/program.h"
#include "tests/support/scenes/gltf_fixture.h"

namespace {

using namespace tests;

TEST_F(Cli, ScenesThatAreNone)
{
    writeFile("words.gltf", "these are words");
    writeFile("empty.glb", "");
    writeFile("array.gltf", "[]");
    fs::create_directory(work("folder.gltf"));
    for (const Strings& command :
         {Strings{"render", "-o", "x.exr"}, {"info"}, {"bench", "throughput"}}) {
        expectRefused(command + Strings{"missing.gltf"}, 3, "missing.gltf");
        expectRefused(command + Strings{"words.gltf"}, 3, "words.gltf");
        expectRefused(command + Strings{"empty.glb"}, 3, "empty.glb");
        expectRefused(command + Strings{"array.gltf"}, 3, "array.gltf");
        expectRefused(command + Strings{"folder.gltf"}, 3, "folder.gltf");
        expectRefused(command, 2, "scene");
        expectRefused(command + Strings{kScene, "--strickt"}, 2, "did you mean --strict?");
    }
    expectRefused({"missing.gltf"}, 3, "missing.gltf", kNoDisplay);
}

TEST_F(Cli, NonsenseToRender)
{
    const auto refused = [this](const Strings& more, int code, const std::string& text) {
        expectRefused(Strings{"render", kScene} + more, code, text);
    };
    refused({}, 2, "-o FILE");
    refused({"-o", "x.exr", "--spp", "0"}, 2, "--spp");
    refused({"-o", "x.exr", "--spp", "-3"}, 2, "--spp");
    refused({"-o", "x.exr", "--spp", "many"}, 2, "--spp");
    refused({"-o", "x.exr", "--size", "0x0"}, 2, "--size");
    refused({"-o", "x.exr", "--size", "64x0"}, 2, "--size");
    refused({"-o", "x.exr", "--size", "-64x64"}, 2, "--size");
    refused({"-o", "x.exr", "--time", "-1"}, 2, "--time");
    refused({"-o", "x.exr", "--max-depth", "-1"}, 2, "--max-depth");
    refused({"-o", "x.exr", "--method", "magic"}, 2, "is not one of path");
    refused({"-o", "x.exr", "--device", "abacus"}, 2, "--device");
    refused({"-o", "x.exr", "--no-skip", "textuers", "--device", "cpu"}, 2, "textuers");
    refused({"-o", "x.exr", "--sppp", "4"}, 2, "did you mean --spp?");
    refused({"-o", "x.jpg"}, 2, "x.jpg");
    refused({"-o", "x"}, 2, ".exr");
    refused({"-o", "nowhere/x.exr"}, 3, "nowhere");
    refused({"-o", "x.exr", "--stats", "nowhere/s.json"}, 3, "nowhere/s.json");
    refused({"-o", "x.exr", "--camera", "nobody", "--device", "cpu"}, 2, "nobody");
    refused({"-o", "x.exr", "--camera", "99", "--device", "cpu"}, 2, "99");
    refused({"-o", "x.exr", "--camera", "missing.json", "--device", "cpu"}, 3, "missing.json");
    refused({"-o", "x.exr", "--reference", "missing.exr"}, 3, "missing.exr");
    refused({"-o", "f.png", "--path", "missing.json", "--frames", "0-1", "--device", "cpu"}, 2,
            "%04d");
    refused({"-o", "%04d.png", "--path", "missing.json", "--frames", "0-1", "--device", "cpu"}, 3,
            "missing.json");
    refused({"-o", "x.exr", "--size", "65536x65536", "--device", "cpu"}, 2, "GiB");
    writeFile("camera.json", R"({"position": [0, 0, "zero"]})");
    refused({"-o", "x.exr", "--camera", "camera.json", "--device", "cpu"}, 3,
            "camera.json: /position");
    writeFile("picture.exr", "no picture");
    refused({"-o", "x.exr", "--reference", "picture.exr"}, 3, "picture.exr");
}

TEST_F(Cli, NonsenseToTheOthers)
{
    expectRefused({"compare", "a.exr"}, 2, "reference");
    expectRefused({"compare", "a.exr", "b.exr"}, 3, "a.exr");
    expectRefused({"compare", "a.exr", "b.exr", "--jsno"}, 2, "--jsno");
    expectRefused({"devices", "--jsno"}, 2, "did you mean --json?");
    expectRefused({"devices", "first"}, 2, "first");
    expectRefused({"bench"}, 2, "throughput");
    expectRefused({"bench", "everything", kScene}, 2, "everything");
    expectRefused({"rendre", kScene}, 2, "did you mean render?");
    expectRefused({"--what"}, 2, "--what");
}

TEST_F(Cli, OutputThatIsAFolder)
{
    fs::create_directory(work("x.exr"));
    expectRefused({"render", kScene, "-o", "x.exr"}, 3, "x.exr");
    expectRefused({"render", kScene, "-o", "y.exr", "--stats", "x.exr"}, 3, "x.exr");
}

TEST_F(Cli, WithoutVulkan)
{
    const Strings none{"VK_ICD_FILENAMES=/nonexistent.json", "VK_DRIVER_FILES=/nonexistent.json"};
    expectRefused(smallRender("vulkan", "x.exr"), 4, "--device cpu", none);
    expectRefused({"devices"}, 4, "Vulkan", none);
    expectRefused(smallRender("vulkan", "x.exr") + Strings{"--device-index", "99"}, 4, "99");
    EXPECT_EQ(run(smallRender("cpu", "x.exr"), none).code, 0);
}

TEST_F(Cli, HelpAndVersion)
{
    for (const Strings& arguments :
         {Strings{"--help"}, {"render", "--help"}, {"bench", "throughput", "-h"}}) {
        const Result result = run(arguments);
        EXPECT_EQ(result.code, 0);
        EXPECT_EQ(result.err, "");
        EXPECT_TRUE(contains(result.out, "Example: rekindle"));
    }
    EXPECT_TRUE(contains(run({"--help"}).out, "window"));
    const Result version = run({"--version"});
    EXPECT_EQ(version.code, 0);
    for (const char* name : {"rekindle", "compiler", "build", "Embree", "Vulkan", "oneTBB",
                             "OpenEXR", "GLFW", "GLM", "system", "processor", "memory"})
        EXPECT_TRUE(contains(version.out, name)) << name;
}

TEST_F(Cli, VersionAsJsonHoldsWhatAReportNeeds)
{
    const Json json = Json::parse(run({"--version", "--json"}).out);
    EXPECT_EQ(json.at("schema"), 1);
    for (const char* name : {"version", "compiler", "build_type"})
        EXPECT_FALSE(json.at(name).get<std::string>().empty()) << name;
    for (const char* name : {"commit", "sanitizers"}) EXPECT_TRUE(json.at(name).is_string());
    EXPECT_TRUE(json.at("native").is_boolean());
    const Pattern number("[0-9]+\\.[0-9]+.*");
    for (const char* name : {"Vulkan", "Embree", "oneTBB", "OpenEXR", "GLFW", "Dear ImGui"}) {
        const Json library = json.at("libraries").at(name);
        for (const char* which : {"built", "running"})
            EXPECT_TRUE(number.match(library.at(which).get<std::string>()))
                << name << ' ' << library.dump();
    }
    const Json system = json.at("system");
    EXPECT_FALSE(system.at("kernel").get<std::string>().empty());
    EXPECT_FALSE(system.at("processor").get<std::string>().empty());
    EXPECT_GE(system.at("cores").get<int>(), 1);
    EXPECT_GT(system.at("memory_mb").get<int>(), 100);
    expectRefused({"--json"}, 2, "--version --json");
}

TEST_F(Cli, Devices)
{
    const Result text = run({"devices"});
    EXPECT_EQ(text.code, 0);
    EXPECT_TRUE(contains(text.out, "suitable")) << text.out;
    const Json json = Json::parse(run({"devices", "--json"}).out);
    ASSERT_FALSE(json.at("devices").empty());
    EXPECT_TRUE(contains(text.out, json["devices"][0].at("name").get<std::string>()));
    EXPECT_GT(json["devices"][0].at("max_storage_range").get<uint64_t>(), 1u << 20);
}

TEST_F(Cli, Info)
{
    const Result text = run({"info", kScene});
    EXPECT_EQ(text.code, 0) << text.err;
    for (const char* word : {"triangles", "materials", "cameras", "needs", "left out", "warnings"})
        EXPECT_TRUE(contains(text.out, word)) << word;
    const Json json = Json::parse(run({"info", kScene, "--json"}).out);
    EXPECT_EQ(json.at("schema"), 1);
    EXPECT_GT(json.at("counts").at("triangles").get<int>(), 10);
    EXPECT_GE(json.at("lights").at("triangles").get<int>(), 1);
    EXPECT_EQ(json.at("warnings").at("total"), 0);
    const auto used = json.at("features").at("used").get<std::set<std::string>>();
    const auto skipped = json.at("features").at("skipped").get<std::set<std::string>>();
    EXPECT_TRUE(used.count("emissive-triangles"));
    for (const char* name : {"textures", "transmission", "environment", "alpha"})
        EXPECT_TRUE(skipped.count(name));
}

TEST_F(Cli, BenchThroughputSaysWhatItMeasured)
{
    const Result result =
        run({"bench", "throughput", kScene, "--width", "48", "--seconds", "0.05"});
    ASSERT_EQ(result.code, 0) << result.err;
    const Json json = Json::parse(result.out);
    for (const char* set : {"primary", "bounce", "any"}) {
        EXPECT_GT(json.at("ratios").at(set).get<double>(), 0) << set;
        EXPECT_GT(json.at("rays_per_second").at(set).get<double>(), 0) << set;
    }
    for (const std::string& device : kDevices)
        EXPECT_GT(json.at("samples_per_second").at(device).get<double>(), 0) << device;
    EXPECT_TRUE(files().empty());
}

/// No ray leaves a flat lamp for a point of it: what can be measured is.
TEST_F(Cli, BenchThroughputMeasuresAViewOfLampsAlone)
{
    test::Document lamp = test::triangle();
    lamp.material()["emissiveFactor"] = {1, 1, 1};
    lamp.json["cameras"] =
        Json::parse(R"([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}])");
    lamp.json["scenes"][0]["nodes"].push_back(lamp.json["nodes"].size());
    lamp.json["nodes"].push_back(Json::parse(R"({"camera": 0, "translation": [0.3, 0.3, 1]})"));
    writeFile("lamp.gltf", lamp.text());
    const Strings bench{"bench", "throughput", "lamp.gltf", "--width", "32", "--seconds", "0.05"};
    const Result result = run(bench);
    ASSERT_EQ(result.code, 0) << result.err;
    const Json json = Json::parse(result.out);
    for (const char* key : {"sets", "ratios", "rays_per_second"}) {
        EXPECT_TRUE(json.at(key).at("any").is_null()) << key;
        EXPECT_FALSE(json.at(key).at("bounce").is_null()) << key;
    }
    lamp.json["nodes"].back()["translation"] = {9, 9, 1};
    writeFile("lamp.gltf", lamp.text());
    expectRefused(bench, 3, "no ray of the first camera's view hits anything");
}

TEST_F(Cli, DefaultSizeIsTheCamerasOwn)
{
    ASSERT_EQ(run({"render", kScene, "-o", "x.exr", "--device", "cpu", "--spp", "1", "--width",
                   "48", "--stats", "stats.json"})
                  .code,
              0);
    const double aspect = stats().at("camera").at("aspect").get<double>();
    EXPECT_EQ(stats().at("size")[0], 48);
    EXPECT_NEAR(stats().at("size")[1].get<double>(), 48 / (aspect > 0 ? aspect : 16.0 / 9), 0.51);
    EXPECT_FALSE(exr("x.exr").hasLayer("variance"));  // one sample has no spread
}

/// A crash tells from where, and is a crash to whoever has started the program.
TEST_F(Cli, ACrashIsReported)
{
#ifdef REKINDLE_SANITIZED
    GTEST_SKIP() << "sanitizers report crashes themselves";
#endif
    for (const int signal : {SIGSEGV, SIGABRT}) {
        const pid_t pid = start({"render", kScene, "-o", "x.exr", "--device", "cpu", "--size",
                                 "64x64", "--spp", "2000000000"});
        waitForError("render: ");
        kill(pid, signal);
        const Result result = finish(pid);
        EXPECT_EQ(result.code, -1);
        EXPECT_EQ(result.signal, signal);
        EXPECT_TRUE(contains(result.err, "rekindle: error: crashed by " + std::string("SIG") +
                                             sigabbrev_np(signal)))
            << result.err;
        EXPECT_TRUE(contains(result.err, "in thread \"rekindle\"")) << result.err;
        EXPECT_GE(lineCount(result.err), 5u) << "the calls are listed: " << result.err;
    }
}

/// What cannot be shown leaves nothing behind, and what is there stays.
TEST_F(Cli, FlyThroughsHaveAFolderEach)
{
    expectRefused({"nosuch.glb"}, 3, "nosuch.glb", kNoDisplay);
    EXPECT_FALSE(fs::exists(work("rekindle-frames")));
    fs::create_directory(work("rekindle-frames"));
    writeFile("rekindle-frames/frame-0000.png", "mine");
    const pid_t pid = start({kScene, "--device", "cpu"}, kNoDisplay);
    for (int i = 0; i < 1500 && !fs::exists(work("rekindle-frames-2/frame-0000.png")); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    kill(pid, SIGINT);
    const Result result = finish(pid);
    EXPECT_TRUE(contains(result.out, "rekindle-frames-2")) << result.out;
    EXPECT_GT(fs::file_size(work("rekindle-frames-2/frame-0000.png")), 50u);
    EXPECT_EQ(readAll(work("rekindle-frames/frame-0000.png")), "mine");
}

TEST_F(Cli, SlowFlyThroughWithoutACommand)
{
    const Result result = finish(start({}), 300);
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_TRUE(contains(result.out, "rekindle-frames"));
    EXPECT_EQ(files().size(), 24u);
    EXPECT_TRUE(files().count("rekindle-frames/frame-0000.png"));
}

}  // namespace
