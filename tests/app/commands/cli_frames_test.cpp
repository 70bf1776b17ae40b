// `rekindle render --frames` as a person or a script meets it: the real binary, and a file for
// every frame.
#include "app/commands/render_words.h"
#include "core/methods/method.h"
#include "tests/support/process/program.h"
#include "tests/support/scenes/gltf_fixture.h"

namespace {

using namespace tests;

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
    const Json whole = stats();
    for (const Json& frame : whole.at("frames")) {
        const double rays = frame.at("rays").get<double>(), spp = frame.at("spp").get<double>();
        EXPECT_LE(rays, 1.05 * 40 * pixels);
        EXPECT_GE(rays * (spp + 1) / spp, 0.9 * 40 * pixels);
        EXPECT_GT(spp, 1);
    }
    EXPECT_EQ(whole.at("ended"), "budget");
    EXPECT_EQ(whole.at("budget_rays"), 40);
    EXPECT_EQ(whole.at("over_budget"), 0);
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
    const Json little = stats();
    for (const Json& frame : little.at("frames")) EXPECT_EQ(frame.at("spp"), 1);
    EXPECT_EQ(little.at("over_budget"), 4);
    ASSERT_EQ(run(render + Strings{"400"}).code, 0);
    const Json enough = stats();
    for (const Json& frame : enough.at("frames")) EXPECT_GT(frame.at("spp"), 1);
    EXPECT_EQ(enough.at("ended"), "budget");
}

/// The last frame looks past the scene, where nothing is noisy; the first has missed the target.
TEST_F(Cli, FramesThatMissTheirTargetAreNamed)
{
    writeFile("path.json", R"({"keys": [{"frame": 0}, {"frame": 1, "position": [50, 1, 50],
                                                       "target": [99, 1, 99]}]})");
    const Result result =
        run({"render",        kScene,  "-o",     "f-%d.exr",  "--device",  "cpu",
             "--size",        "16x12", "--spp",  "9",         "--sampler", "independent",
             "--environment", "none",  "--path", "path.json", "--frames",  "0-1",
             "--until-noise", "1e-9",  "--quiet"});
    EXPECT_EQ(result.code, 6) << result.err;
    EXPECT_TRUE(contains(result.err, "frame 0: noise ")) << result.err;
    EXPECT_TRUE(contains(result.err, "1 of 2 frames missed it")) << result.err;
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

/// The triangle of the fixture, whose node moves from `from` to `to` within a second.
test::Document movingTriangle(const char* path, const std::vector<float>& from,
                              const std::vector<float>& to)
{
    test::Document document = test::triangle();
    const int times = document.values<float>({0, 1}, test::kFloat, "SCALAR", 1);
    document.json["accessors"][static_cast<size_t>(times)]["min"] = {0};
    document.json["accessors"][static_cast<size_t>(times)]["max"] = {1};
    std::vector<float> values = from;
    values.insert(values.end(), to.begin(), to.end());
    const int keys = document.values<float>(values, test::kFloat, "VEC3", 3);
    document.json["animations"] = {
        {{"samplers", {{{"input", times}, {"output", keys}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}}}};
    return document;
}

/// A scene without a camera has one that frames it: that of the first pose, for the whole flight.
TEST_F(Cli, TheDefaultCameraDoesNotFollowWhatMoves)
{
    writeFile("moving.gltf", movingTriangle("translation", {0, 0, 0}, {3, 0, 0}).text());
    const Strings render{"render",   "moving.gltf", "--device", "cpu", "--size",
                         "16x12",    "--spp",       "1",        "-o",  "f-%d.exr",
                         "--frames", "0-1",         "--fps",    "1"};
    for (const Strings& camera : {Strings{}, Strings{"--camera", "0"}}) {
        const Result result = run(render + camera);
        ASSERT_EQ(result.code, 0) << result.err;
        EXPECT_EQ(exr("f-1.exr").metadata.at("at"), "1.0");
        EXPECT_EQ(exr("f-0.exr").metadata.at("camera"), exr("f-1.exr").metadata.at("camera"));
    }
}

/// Once for all poses in which they arise, in what is printed and in the count.
TEST_F(Cli, WarningsOfLaterPosesAreTold)
{
    writeFile("vanishing.gltf", movingTriangle("scale", {1, 1, 1}, {0, 0, 0}).text());
    const Strings render{
        "render", "vanishing.gltf", "--device", "cpu", "--size",  "16x12",     "--spp", "1",
        "-o",     "f-%d.exr",       "--fps",    "1",   "--stats", "stats.json"};
    const Result result = run(render + Strings{"--frames", "0-3"});
    ASSERT_EQ(result.code, 0) << result.err;
    const size_t told = result.err.find("vanishing.gltf: at 1 s: /nodes/0: scale is zero");
    ASSERT_NE(told, std::string::npos) << result.err;
    EXPECT_EQ(result.err.find("NODE_SCALE_ZERO", result.err.find("NODE_SCALE_ZERO") + 1),
              std::string::npos)
        << result.err;
    EXPECT_EQ(stats().at("warnings"), 1);

    EXPECT_EQ(run(render + Strings{"--strict", "--frames", "0-0"}).code, 0);
    const Result strict = run(render + Strings{"--strict", "--frames", "0-3"});
    EXPECT_NE(strict.code, 0);
    EXPECT_NE(strict.err.find("(NODE_SCALE_ZERO) — refused because of --strict"), std::string::npos)
        << strict.err;
}

TEST(ToldWarnings, PlacesAreToldOnceAndCountedOnce)
{
    app::ToldWarnings told;
    core::Warnings pose;
    pose.add("RANGE", "/nodes/1", "a range");
    pose.add("AREA", "/nodes/2", "3 triangles");
    pose.add("AREA", "/nodes/2", "4 triangles of another mesh");
    EXPECT_EQ(told.add(pose).size(), 3u);
    EXPECT_EQ(told.add(pose).size(), 0u);
    core::Warnings later;
    later.add("RANGE", "/nodes/1", "a range");
    later.add("AREA", "/nodes/2", "5 triangles");
    EXPECT_EQ(told.add(later).size(), 0u);
    EXPECT_EQ(told.total(), 3u);
    later.add("AREA", "/nodes/7", "1 triangles");
    EXPECT_EQ(told.add(later), Strings{"/nodes/7: 1 triangles (AREA)"});
    EXPECT_EQ(told.total(), 3u) << "two places, as many as once were told of one";
    for (int pass = 0; pass < 2; ++pass)
        for (int node = 10; node < 40; ++node) {
            core::Warnings one;
            one.add("AREA", "/nodes/" + std::to_string(node), "1 triangles");
            EXPECT_EQ(told.add(one).size(), pass == 0 && node < 18 ? 1u : 0u) << node;
        }
    EXPECT_EQ(told.total(), 1u + 32u);
}

/// What a frame begins with that follows on another is in no file; it says so.
TEST_F(Cli, FramesThatKeepSamplesSayThatTheyFollow)
{
    writeFile("path.json", R"({"keys": [{"frame": 0}, {"frame": 2, "yfov": 50}]})");
    for (const char* method : {"path", "reuse", "guided"}) {
        SCOPED_TRACE(method);
        ASSERT_EQ(run({"render", kScene, "-o", "f-%d.exr", "--device", "cpu", "--size", "12x8",
                       "--spp", "1", "--path", "path.json", "--frames", "0-2", "--method", method})
                      .code,
                  0);
        EXPECT_FALSE(exr("f-0.exr").metadata.contains("follows"));
        const bool keeps = core::methodNamed(method).traits.keepsOnMove;
        EXPECT_EQ(keeps, std::string(method) != "path");
        for (const char* frame : {"f-1.exr", "f-2.exr"})
            EXPECT_EQ(exr(frame).metadata.contains("follows"), keeps) << frame;
    }
}

TEST_F(Cli, NumbersAndSpeedsBelongToFrames)
{
    const Strings render{"render", kScene, "--device", "cpu", "--size", "8x8", "--spp", "1"};
    expectRefused(render + Strings{"-o", "f-%04d.png"}, 2, "give --frames A-B");
    writeFile("path.json", R"({"keys": [{"frame": 0}, {"frame": 2, "yfov": 50}]})");
    expectRefused(
        render + Strings{"-o", "f-%d.png", "--path", "path.json", "--frames", "0-1", "--fps", "24"},
        2, "stands as it is at --at");
}

TEST_F(Cli, AnOrthographicCameraHasNoLens)
{
    const Strings render{"render", kScene, "-o",    "x.exr", "--device", "cpu",
                         "--size", "8x8",  "--spp", "1",     "--camera", "camera.json"};
    writeFile("camera.json", R"({"ymag": 1, "aperture_radius": 0.1})");
    Result result = run(render);
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_TRUE(contains(result.err, "aperture_radius is ignored")) << result.err;
    for (const char* camera : {R"({"ymag": 1})", R"({"yfov": 40, "aperture_radius": 0.1})"}) {
        writeFile("camera.json", camera);
        result = run(render);
        EXPECT_EQ(result.code, 0) << result.err;
        EXPECT_FALSE(contains(result.err, "ignored")) << result.err;
    }
}

}  // namespace
