// `rekindle render` as a person or a script meets it: the real binary, its files, statistics,
// interrupts and limits.
#include <chrono>
#include <cmath>
#include <csignal>

#include "core/image/metrics.h"
#include "tests/support/process/program.h"

namespace {

using namespace tests;

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
#ifndef REKINDLE_SANITIZED  // whose own memory counts, too
    EXPECT_LT(stats["peak_host_mb"].get<double>(), 2000);
#endif
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
    for (const char* technique : {"row-column", "lightcuts", "illumination-cut", "matsep"}) {
        ASSERT_EQ(run(smallRender("cpu", "c.exr") + Strings{"--method", "manylights", "--lights",
                                                            "100", "--technique", technique,
                                                            "--stats", "stats.json"})
                      .code,
                  0);
        const Json expected =
            technique == std::string("row-column") ? Json::array() : Json{"technique"};
        EXPECT_EQ(stats().at("biased"), expected) << technique;
    }
}

TEST_F(Cli, InterruptSavesWhatThereIs)
{
    for (const auto& [device, signal] :
         {std::pair(kDevices[0], SIGINT), std::pair(kDevices[1], SIGINT),
          std::pair(kDevices[0], SIGHUP)}) {
        SCOPED_TRACE(device + ", signal " + std::to_string(signal));
        const pid_t pid = start({"render", kScene, "-o", "x.exr", "--device", device, "--size",
                                 "64x64", "--spp", "2000000000", "--stats", "stats.json"});
        waitForError("render: ");
        kill(pid, signal);  // SIGHUP: the terminal is closed
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

TEST_F(Cli, UntilTheNoiseIsSmallEnough)
{
    const Strings small{"render", kScene,  "-o",        "x.exr",       "--device", "cpu",
                        "--size", "24x24", "--sampler", "independent", "--stats",  "stats.json"};
    Result result = run(small + Strings{"--until-noise", "0.05"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(stats().at("ended"), "target");
    EXPECT_LE(stats().at("noise").get<double>(), 0.05);
    EXPECT_EQ(stats().at("until_noise"), 0.05);
    // What was said is what the file's own variance says.
    const core::ImageFile file = exr("x.exr");
    EXPECT_NEAR(core::noiseOf(file.layer("variance")), stats().at("noise").get<double>(), 1e-6);

    result = run(small + Strings{"--until-noise", "1e-9", "--spp", "3"});
    EXPECT_EQ(result.code, 6) << result.err;
    EXPECT_NE(result.err.find("too few samples"), std::string::npos) << result.err;
    result = run(small + Strings{"--until-noise", "1e-9", "--spp", "9"});
    EXPECT_EQ(result.code, 6) << result.err;
    EXPECT_NE(result.err.find("is above --until-noise"), std::string::npos) << result.err;
}

/// No error falls below the noise of what it is measured against.
TEST_F(Cli, AReferenceHasNoiseOfItsOwn)
{
    const Strings render{"render", kScene, "--device", "cpu", "--size", "24x24"};
    ASSERT_EQ(run(render + Strings{"-o", "ref.exr", "--spp", "4", "--seed", "9"}).code, 0);
    const double noise = core::noiseOf(exr("ref.exr").layer("variance"));
    ASSERT_GT(noise, 0.01);
    const Strings measured = render + Strings{"-o",          "x.exr",   "--spp",   "3",
                                              "--reference", "ref.exr", "--stats", "stats.json"};
    Result result = run(measured + Strings{"--until-rmse", std::to_string(0.9 * noise)});
    EXPECT_EQ(result.code, 6) << result.err;
    EXPECT_TRUE(contains(result.err, "ref.exr: its own noise is ")) << result.err;
    EXPECT_TRUE(contains(result.err, "may never be reached")) << result.err;
    EXPECT_TRUE(contains(result.err, "(the noise of the reference is ")) << result.err;
    EXPECT_NEAR(stats().at("reference_noise").get<double>(), noise, 1e-9);
    result = run(measured + Strings{"--until-rmse", std::to_string(1.1 * noise)});
    EXPECT_FALSE(contains(result.err, "may never be reached")) << result.err;
    const Json compared = Json::parse(run({"compare", "x.exr", "ref.exr"}).out);
    EXPECT_NEAR(compared.at("reference_noise").get<double>(), noise, 1e-9);
}

TEST_F(Cli, AReferenceWithoutColorsIsRefusedByName)
{
    core::writeExr(work("depth.exr"), {{{"depth", core::Image(24, 24, 1)}}, {}});
    expectRefused({"render", kScene, "-o", "y.exr", "--device", "cpu", "--size", "24x24",
                   "--reference", "depth.exr"},
                  3, "depth.exr: has no channels R, G, B");
}

/// Samples of a Sobol sequence have less noise than their spread tells.
TEST_F(Cli, NoiseIsABoundWhereSamplesAreOfASequence)
{
    for (const bool sobol : {true, false}) {
        const Result result = run({"render", kScene, "-o", "x.exr", "--device", "cpu", "--size",
                                   "24x24", "--stats", "stats.json", "--until-noise", "0.1",
                                   "--sampler", sobol ? "sobol" : "independent"});
        EXPECT_EQ(result.code, 0) << result.err;
        EXPECT_EQ(stats().at("noise_is_bound"), sobol);
        EXPECT_EQ(contains(result.err, ", noise at most 0."), sobol) << result.err;
        EXPECT_EQ(contains(result.err, ", noise 0."), !sobol) << result.err;
    }
    ASSERT_EQ(run(smallRender("cpu", "x.exr") + Strings{"--stats", "stats.json"}).code, 0);
    EXPECT_FALSE(stats().contains("noise_is_bound"));
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

}  // namespace
