// The program as a person or a script meets it: the real binary, its files, its exit codes, its
// streams.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <optional>
#include <thread>

#include <unistd.h>

#include "core/image/metrics.h"
#include "tests/support/pattern.h"
#include "tests/support/program.h"

namespace {

using namespace tests;

Strings smallRender(const std::string& device, const std::string& output)
{
    return {"render", kScene, "-o", output, "--device", device, "--size", "40x32", "--spp", "4"};
}

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
    expectRefused({"missing.gltf"}, 3, "missing.gltf");
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
                             "OpenImageIO", "GLFW", "GLM", "system", "processor", "memory"})
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
    for (const char* name : {"Vulkan", "Embree", "oneTBB", "OpenImageIO", "GLFW", "Dear ImGui"}) {
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

void expectStats(const Json& stats, const std::string& device)
{
    EXPECT_EQ(stats.at("schema"), 1);
    EXPECT_EQ(stats.at("command"), "render");
    EXPECT_EQ(stats.at("scene"), kScene);
    EXPECT_EQ(stats.at("scene_hash").get<std::string>().size(), 16u);
    EXPECT_FALSE(stats.at("version").get<std::string>().empty());
    EXPECT_TRUE(stats.at("commit").is_string());
    EXPECT_FALSE(stats.at("device").get<std::string>().empty());
    EXPECT_TRUE(stats.at("driver").is_string());
    EXPECT_EQ(stats.at("method"), "path");
    EXPECT_EQ(stats.at("reuse"), "none");
    EXPECT_EQ(stats.at("size"), (Json{40, 32}));
    EXPECT_EQ(stats.at("spp"), 4);
    EXPECT_EQ(stats.at("seed"), 1);
    EXPECT_EQ(stats.at("max_depth"), 8);
    EXPECT_FALSE(stats.at("features").at("used").empty());
    EXPECT_FALSE(stats.at("features").at("skipped").empty());
    double parts = 0;
    for (const char* name : {"load", "build", "compile", "prepare", "render", "readback"}) {
        EXPECT_GE(stats.at("seconds").at(name).get<double>(), 0) << name;
        parts += stats["seconds"][name].get<double>();
    }
    EXPECT_GT(stats["seconds"]["render"].get<double>(), 0);
    EXPECT_LE(parts, 1.05 * stats.at("seconds").at("total").get<double>() + 0.05);
    const double paths = 40 * 32 * 4;
    EXPECT_EQ(stats.at("paths").get<double>(), paths);
    // Every path traces its camera ray; most bounce, and every bounce asks for light.
    EXPECT_GT(stats.at("rays").get<double>(), 3 * paths);
    EXPECT_LT(stats["rays"].get<double>(), 20 * paths);
    EXPECT_NEAR(stats.at("rays_per_second").get<double>() *
                    stats["seconds"]["render"].get<double>(),
                stats["rays"].get<double>(), 1);
    EXPECT_NEAR(stats.at("samples_per_second").get<double>() *
                    stats["seconds"]["render"].get<double>(),
                paths, 1);
    EXPECT_GT(stats.at("peak_host_mb").get<double>(), 5);
    EXPECT_LT(stats["peak_host_mb"].get<double>(), 2000);
    EXPECT_EQ(stats.at("peak_device_mb").get<double>() > 0, device == "vulkan");
    for (const char* name : {"nan", "inf", "negative", "stack_overflow"})
        EXPECT_EQ(stats.at("counters").at(name), 0) << name;
    ASSERT_EQ(stats.at("frames").size(), 1u);
    EXPECT_EQ(stats["frames"][0].at("index"), 0);
    EXPECT_EQ(stats["frames"][0].at("spp"), 4);
    EXPECT_EQ(stats["frames"][0].at("rays"), stats["rays"]);
    EXPECT_NEAR(stats["frames"][0].at("seconds").get<double>(),
                stats["seconds"]["render"].get<double>(), 1e-9);
    EXPECT_TRUE(stats.at("method_stats").is_object());
}

TEST_F(Cli, RenderWithEverything)
{
    for (const std::string& device : kDevices) {
        SCOPED_TRACE(device);
        const Result result =
            run(smallRender(device, "x.exr") +
                Strings{"--stats", "stats.json", "--aov", "depth,normal,albedo,ids"});
        ASSERT_EQ(result.code, 0) << result.err;
        EXPECT_EQ(result.out, "");  // the result is the file
        EXPECT_EQ(files(), (std::set<std::string>{"x.exr", "stats.json"}));
        expectStats(stats(), device);

        const core::ImageFile file = exr("x.exr");
        std::set<std::string> layers;
        for (const core::Layer& layer : file.layers) {
            layers.insert(layer.name);
            EXPECT_EQ(layer.image.width, 40u);
            EXPECT_EQ(layer.image.height, 32u);
            EXPECT_EQ(layer.image.channels, layer.name == "depth" ? 1u : 3u) << layer.name;
        }
        EXPECT_EQ(layers,
                  (std::set<std::string>{"", "variance", "depth", "normal", "albedo", "ids"}));
        double sum = 0;
        for (const float value : file.layer("").pixels) sum += static_cast<double>(value);
        EXPECT_GT(sum / (40 * 32 * 3), 0.02);
        for (const float value : file.layer("variance").pixels) ASSERT_GE(value, 0.0f);
        const core::Metadata& m = file.metadata;
        EXPECT_EQ(m.at("scene"), kScene);
        EXPECT_EQ(m.at("scene_hash"), stats()["scene_hash"].get<std::string>());
        EXPECT_EQ(m.at("spp"), "4");
        EXPECT_EQ(m.at("seed"), "1");
        EXPECT_EQ(m.at("method"), "path");
        EXPECT_EQ(m.at("width") + 'x' + m.at("height"), "40x32");
        EXPECT_EQ(m.at("device"), stats()["device"].get<std::string>());
        EXPECT_EQ(Json::parse(m.at("params")), stats()["params"]);
        EXPECT_EQ(Json::parse(m.at("camera")), stats()["camera"]);
        EXPECT_TRUE(m.count("commit") && m.count("seconds"));
    }
}

TEST_F(Cli, SameSeedSamePixelsAndAnotherSeedOthers)
{
    for (const std::string& device : kDevices) {
        SCOPED_TRACE(device);
        ASSERT_EQ(run(smallRender(device, "a.exr")).code, 0);
        ASSERT_EQ(run(smallRender(device, "b.exr")).code, 0);
        ASSERT_EQ(run(smallRender(device, "c.exr") + Strings{"--seed", "2"}).code, 0);
        const core::ImageFile a = exr("a.exr"), b = exr("b.exr"), c = exr("c.exr");
        EXPECT_EQ(a.layer("").pixels, b.layer("").pixels);
        EXPECT_EQ(a.layer("variance").pixels, b.layer("variance").pixels);
        EXPECT_NE(a.layer("").pixels, c.layer("").pixels);
    }
}

TEST_F(Cli, MetadataRendersTheImageAgain)
{
    writeFile("view.json", R"({"position": [0.1, 1.2, 2.2], "target": [0, 0.9, 0], "yfov": 50})");
    ASSERT_EQ(
        run(smallRender("cpu", "a.exr") + Strings{"--camera", "view.json", "--seed", "7",
                                                  "--max-depth", "3", "--sampler", "independent"})
            .code,
        0);
    const core::Metadata m = exr("a.exr").metadata;
    writeFile("again.json", m.at("camera"));
    Strings again{"render",   m.at("scene"),
                  "-o",       "b.exr",
                  "--device", "cpu",
                  "--camera", "again.json",
                  "--method", m.at("method"),
                  "--spp",    m.at("spp"),
                  "--size",   m.at("width") + 'x' + m.at("height")};
    const Json params = Json::parse(m.at("params"));
    for (const auto& [name, value] : params.items())
        again.insert(again.end(),
                     {"--" + name, value.is_string() ? value.get<std::string>() : value.dump()});
    ASSERT_EQ(run(again).code, 0);
    EXPECT_EQ(exr("a.exr").layer("").pixels, exr("b.exr").layer("").pixels);
    EXPECT_EQ(exr("b.exr").metadata.at("camera"), m.at("camera"));
}

TEST_F(Cli, BiasIsNamed)
{
    ASSERT_EQ(
        run(smallRender("cpu", "a.exr") + Strings{"--clamp-indirect", "1", "--stats", "stats.json"})
            .code,
        0);
    EXPECT_EQ(stats().at("biased"), Json{"clamp-indirect"});
    EXPECT_TRUE(contains(exr("a.exr").metadata.at("biased"), "clamp-indirect"));
    ASSERT_EQ(run(smallRender("cpu", "b.exr") + Strings{"--stats", "stats.json"}).code, 0);
    EXPECT_TRUE(stats().at("biased").empty());
    EXPECT_FALSE(exr("b.exr").metadata.count("biased"));
}

TEST_F(Cli, InterruptSavesWhatThereIs)
{
    for (const std::string& device : kDevices) {
        SCOPED_TRACE(device);
        const pid_t pid = start({"render", kScene, "-o", "x.exr", "--device", device, "--size",
                                 "64x64", "--spp", "2000000000", "--stats", "stats.json"});
        waitForError("render: ");
        kill(pid, SIGINT);
        const auto asked = std::chrono::steady_clock::now();
        const Result result = finish(pid);
        EXPECT_EQ(result.code, 130) << result.err;
        EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - asked).count(),
                  5);
        EXPECT_EQ(files(), (std::set<std::string>{"x.exr", "stats.json"}));
        const core::ImageFile file = exr("x.exr");
        EXPECT_GE(std::stoull(file.metadata.at("spp")), 1u);
        EXPECT_EQ(file.metadata.at("ended"), "interrupted");
        EXPECT_EQ(stats().at("ended"), "interrupted");
        EXPECT_EQ(stats().at("spp").dump(), file.metadata.at("spp"));
        fs::remove(work("x.exr"));
        fs::remove(work("stats.json"));
    }
}

TEST_F(Cli, ProgressIsAtMostOneLineASecond)
{
    const auto begin = std::chrono::steady_clock::now();
    const Result result = run(
        {"render", kScene, "-o", "x.exr", "--device", "cpu", "--size", "64x64", "--time", "2.5"});
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    EXPECT_EQ(result.code, 0);
    EXPECT_TRUE(contains(result.err, "render: "));
    EXPECT_LE(static_cast<double>(lineCount(result.err)),
              seconds + 3);  // and one each for the scene and the file
    EXPECT_TRUE(contains(exr("x.exr").metadata.at("ended"), "time"));
    const Result quiet = run(smallRender("cpu", "x.exr") + Strings{"--quiet"});
    EXPECT_EQ(quiet.code, 0);
    EXPECT_EQ(quiet.err, "");
}

TEST_F(Cli, UntilTheErrorIsSmallEnough)
{
    ASSERT_EQ(run({"render", kScene, "-o", "ref.exr", "--device", "cpu", "--size", "24x24", "--spp",
                   "1024", "--seed", "9"})
                  .code,
              0);
    const Strings small{"render", kScene,  "-o",      "x.exr",      "--device",    "cpu",
                        "--size", "24x24", "--stats", "stats.json", "--reference", "ref.exr"};
    Result result = run(small + Strings{"--until-rmse", "0.05"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(stats().at("ended"), "target");
    EXPECT_LE(stats().at("rmse").get<double>(), 0.05);
    EXPECT_LT(stats().at("spp").get<int>(), 1024);
    // The messages agree with the files.
    const Json compared = Json::parse(run({"compare", "x.exr", "ref.exr"}).out);
    EXPECT_NEAR(compared.at("rmse").get<double>(), stats().at("rmse").get<double>(), 1e-6);

    result = run(small + Strings{"--until-rmse", "1e-9", "--spp", "3"});
    EXPECT_EQ(result.code, 6) << result.err;
    EXPECT_EQ(exr("x.exr").metadata.at("spp"), "3");  // the picture is saved nevertheless
    EXPECT_EQ(stats().at("ended"), "spp");
    EXPECT_GT(stats().at("rmse").get<double>(), 1e-9);

    expectRefused({"render", kScene, "-o", "y.exr", "--device", "cpu", "--size", "25x24",
                   "--reference", "ref.exr", "--until-rmse", "1"},
                  3, "24x24");
}

TEST_F(Cli, FramesOfAPath)
{
    writeFile("path.json",
              R"({"keys": [{"frame": 0}, {"frame": 10, "position": [0.3, 1.2, 2.5]}]})");
    const Result result =
        run({"render", kScene, "-o", "f-%04d.exr", "--device", "cpu", "--size", "24x20", "--spp",
             "2", "--path", "path.json", "--frames", "4-6", "--stats", "stats.json"});
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(files(), (std::set<std::string>{"f-0004.exr", "f-0005.exr", "f-0006.exr", "path.json",
                                              "stats.json"}));
    const Json frames = stats().at("frames");
    ASSERT_EQ(frames.size(), 3u);
    uint64_t rays = 0;
    for (size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(frames[i].at("index"), 4 + i);
        EXPECT_EQ(frames[i].at("spp"), 2);
        rays += frames[i].at("rays").get<uint64_t>();
    }
    EXPECT_EQ(stats().at("rays"), rays);
    EXPECT_NE(exr("f-0004.exr").layer("").pixels, exr("f-0006.exr").layer("").pixels);
    EXPECT_NE(exr("f-0004.exr").metadata.at("camera"), exr("f-0006.exr").metadata.at("camera"));
}

TEST_F(Cli, FramesWithABudgetOfRays)
{
    writeFile("path.json",
              R"({"keys": [{"frame": 0}, {"frame": 30, "position": [0.1, 1.1, 3.5]}]})");
    const Strings render{"render",  kScene,       "-o",       "f-%d.exr", "--device",
                         "cpu",     "--size",     "24x20",    "--path",   "path.json",
                         "--stats", "stats.json", "--frames", "0-29",     "--budget-rays"};
    const double pixels = 24 * 20;
    // Whole samples: as many as fit, and not one more.
    Result result = run(render + Strings{"40", "--method", "path"});
    ASSERT_EQ(result.code, 0) << result.err;
    for (const Json& frame : stats().at("frames")) {
        const double rays = frame.at("rays").get<double>(), spp = frame.at("spp").get<double>();
        EXPECT_LE(rays, 1.05 * 40 * pixels);
        EXPECT_GE(rays * (spp + 1) / spp, 0.9 * 40 * pixels);
        EXPECT_GT(spp, 1);
    }
    EXPECT_EQ(stats().at("ended"), "budget");
    EXPECT_EQ(stats().at("budget_rays"), 40);
    EXPECT_EQ(stats().at("over_budget"), 0);
    // Less than a sample: pixels take turns once they have a history.
    result = run(render + Strings{"3", "--method", "reuse"});
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_NE(result.err.find("--budget-rays 3"), std::string::npos) << result.err;
    EXPECT_EQ(result.err.find("the least there is"), std::string::npos) << result.err;
    const double rays = stats().at("params").at("rays").get<double>();
    EXPECT_GT(rays, 0.1);
    EXPECT_LT(rays, 0.6);
    const Json frames = stats().at("frames");
    EXPECT_GT(frames[0].at("rays").get<double>(), 3.5 * pixels) << "nothing is known yet";
    double last = 0;
    for (size_t i = 20; i < 30; ++i) last += frames[i].at("rays").get<double>() / (10 * pixels);
    EXPECT_LE(last, 3 * 1.1);
    EXPECT_GE(last, 3 * 0.6);
    // What the statistics say of each frame.
    for (const char* name : {"history", "alpha", "c", "residual", "ess", "rays"})
        EXPECT_TRUE(frames[29].at("map_means").contains(name)) << name;
    EXPECT_GT(frames[29].at("map_means").at("ess"), frames[0].at("map_means").at("ess"));
    for (const char* name : {"history", "c", "n", "weights"})
        EXPECT_TRUE(frames[29].at("method_stats").contains(name)) << name;
}

TEST_F(Cli, FramesWithABudgetOfTime)
{
    writeFile("path.json",
              R"({"keys": [{"frame": 0}, {"frame": 3, "position": [0.1, 1.1, 3.5]}]})");
    const Strings render{"render",  kScene,       "-o",       "f-%d.exr", "--device",
                         "cpu",     "--size",     "24x20",    "--path",   "path.json",
                         "--stats", "stats.json", "--frames", "0-3",      "--budget-ms"};
    ASSERT_EQ(run(render + Strings{"0.001"}).code, 0);
    for (const Json& frame : stats().at("frames")) EXPECT_EQ(frame.at("spp"), 1);
    EXPECT_EQ(stats().at("over_budget"), 4);
    ASSERT_EQ(run(render + Strings{"400"}).code, 0);
    for (const Json& frame : stats().at("frames")) EXPECT_GT(frame.at("spp"), 1);
    EXPECT_EQ(stats().at("ended"), "budget");
}

TEST_F(Cli, FramesOfAnAnimation)
{
    const std::string scene = (kAssets / "animated.gltf").string();
    const Strings render{"render", scene, "--device", "cpu", "--size", "24x20", "--spp", "2"};
    const Result result = run(render + Strings{"-o", "f-%d.exr", "--frames", "0-6", "--fps", "4"});
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(files().size(), 7u);
    EXPECT_NE(exr("f-0.exr").layer("").pixels, exr("f-6.exr").layer("").pixels);
    // A frame is the scene at that instant, whatever was rendered before.
    EXPECT_EQ(exr("f-6.exr").metadata.at("at"), "1.5");
    ASSERT_EQ(run(render + Strings{"-o", "x.exr", "--at", "1.5"}).code, 0);
    EXPECT_EQ(exr("f-6.exr").layer("").pixels, exr("x.exr").layer("").pixels);

    expectRefused({"render", kScene, "-o", "g-%d.exr", "--device", "cpu", "--frames", "0-1"}, 2,
                  "no animation");
}

TEST_F(Cli, PngIsBrighterWithExposure)
{
    const std::string signature = "\x89PNG\r\n\x1a\n";
    uint64_t previous = 0;
    for (const char* stops : {"-3", "0", "2"}) {
        ASSERT_EQ(run(smallRender("cpu", "x.png") + Strings{"--exposure", stops}).code, 0);
        EXPECT_EQ(readAll(work("x.png")).substr(0, 8), signature);
        const uint64_t size = fs::file_size(work("x.png"));
        EXPECT_NE(size, previous);
        previous = size;
    }
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

TEST_F(Cli, ValidationFindsNothing)
{
    const Result result = run(smallRender("vulkan", "x.exr") +
                              Strings{"--validation", "--aov", "depth", "--stats", "stats.json"});
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(stats().at("validation_messages"), 0) << result.err;
}

/// Names of the features that a scene does not need, as --no-skip takes them.
std::string listWithout(const Json& names, const std::set<std::string>& left)
{
    std::string all;
    for (const auto& name : names) {
        if (left.count(name.get<std::string>())) continue;
        if (!all.empty()) all += ',';
        all += name.get<std::string>();
    }
    return all;
}

TEST_F(Cli, CodeThatASceneDoesNotNeedChangesNothing)
{
    const Json skipped =
        Json::parse(run({"info", kScene, "--json"}).out).at("features").at("skipped");
    // These store normals per vertex, whose rounding turns the frames in which directions are
    // drawn.
    const std::set<std::string> other{"shading-normals", "textures", "normal-maps", "vertex-extra"};
    for (const std::string& device : kDevices) {
        SCOPED_TRACE(device);
        ASSERT_EQ(run(smallRender(device, "a.exr")).code, 0);
        const Result result =
            run(smallRender(device, "b.exr") + Strings{"--no-skip", listWithout(skipped, other)});
        ASSERT_EQ(result.code, 0) << result.err;
        EXPECT_EQ(exr("a.exr").layer("").pixels, exr("b.exr").layer("").pixels);
    }
}

TEST_F(Cli, SlowKernelsThatLeaveNothingOutAgree)
{
    const Json skipped =
        Json::parse(run({"info", kScene, "--json"}).out).at("features").at("skipped");
    constexpr uint64_t kSpp = 2400;
    for (const std::string& device : kDevices) {
        SCOPED_TRACE(device);
        const Strings render{
            "render",      kScene,    "-q",        "--device",           device,
            "--size",      "48x48",   "--spp",     std::to_string(kSpp), "--sampler",
            "independent", "--stats", "stats.json"};
        ASSERT_EQ(finish(start(render + Strings{"-o", "a.exr"}), 600).code, 0);
        const Strings whole{"-o", "b.exr", "--seed", "2", "--no-skip", listWithout(skipped, {})};
        ASSERT_EQ(finish(start(render + whole), 600).code, 0);
        EXPECT_TRUE(stats().at("features").at("skipped").empty());
        const core::ImageFile a = exr("a.exr"), b = exr("b.exr");
        const core::WelchResult welch = core::welchTest({a.layer(""), a.layer("variance"), kSpp},
                                                        {b.layer(""), b.layer("variance"), kSpp});
        for (size_t c = 0; c < 3; ++c) {
            EXPECT_LT(std::abs(welch.image[c].z), 4.21);
            EXPECT_LT(welch.detectableBias[c], 0.02) << "underpowered";
        }
        EXPECT_GT(welch.smallestP, 1e-3);
    }
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
