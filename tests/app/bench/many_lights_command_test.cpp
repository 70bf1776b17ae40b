// `rekindle bench manylights` as a person or a script meets it: what it refuses, what it writes,
// what it keeps, how it stops.
#include <cmath>
#include <csignal>
#include <map>
#include <set>

#include "tests/support/files/markup.h"
#include "tests/support/process/program.h"

namespace {

using namespace tests;

const Strings kManyLights{"bench", "manylights"};

/// Small enough for a test.
const Strings kFewLights{"--size",  "32x24", "--lights",     "300", "--clusters", "10,40",
                         "--share", "0.4",   "--slice-size", "200", "--quick"};

class ManyLightsCommand : public Cli {
protected:
    Json results(const std::string& folder) const
    {
        return Json::parse(readAll(work(folder + "/manylights.json")));
    }
};

TEST_F(ManyLightsCommand, NonsenseIsRefused)
{
    expectRefused(kManyLights, 2, "scene is missing");
    expectRefused(kManyLights + Strings{kScene}, 2, "-o DIR");
    const Strings bench = kManyLights + Strings{kScene, "-o", "x"};
    expectRefused(bench + Strings{"--clusters", "10,many"}, 2, "'many'");
    expectRefused(bench + Strings{"--clusters", "0"}, 2, "--clusters");
    expectRefused(bench + Strings{"--clusters", ","}, 2, "empty");
    expectRefused(bench + Strings{"--errors", "0"}, 2, "--errors");
    expectRefused(bench + Strings{"--errors", ".02,none"}, 2, "'none'");
    expectRefused(bench + Strings{"--share", "2"}, 2, "--share");
    expectRefused(bench + Strings{"--repetitions", "0"}, 2, "--repetitions");
    expectRefused(bench + Strings{"--methods", "matchin"}, 2, "did you mean matching?");
    expectRefused(bench + Strings{"--receivers", "99"}, 2, "--receivers");
    expectRefused(bench + Strings{"--lihgts", "9"}, 2, "did you mean --lights?");
    EXPECT_FALSE(fs::exists(work("x")));
}

TEST_F(ManyLightsCommand, InputAndFoldersThatCannotBeAreRefused)
{
    const Strings bench = kManyLights + kFewLights;
    expectRefused(bench + Strings{kScene, "none.gltf", "-o", "x"}, 3, "none.gltf");
    expectRefused(bench + Strings{kScene, "-o", "x", "--camera", "nobody"}, 2, "nobody");
    writeFile("dark.gltf",
              R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
              R"("nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
              R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",)"
              R"("min":[0,0,0],"max":[1,1,0]}],"bufferViews":[{"buffer":0,"byteLength":36}],)"
              R"("buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)"
              R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
    expectRefused(bench + Strings{"dark.gltf", "-o", "x", "-q", "--environment", "none"}, 3,
                  "no virtual lights");
    EXPECT_FALSE(fs::exists(work("x")));
    writeFile("file", "mine");
    expectRefused(bench + Strings{kScene, "-o", "file"}, 3, "file: is a file");
    expectRefused(bench + Strings{kScene, "-o", "/proc/nowhere"}, 3, "cannot be made");
    EXPECT_EQ(readAll(work("file")), "mine");
}

/// Rows of the errors that were asked for; the one nearest to the thesis's stands beside others.
TEST_F(ManyLightsCommand, MeasuresTheErrorsThatAreGiven)
{
    const Result result = finish(
        start(kManyLights + kFewLights +
              Strings{kScene, "-o", "errors", "--errors", ".3,.05", "--methods", "illumination-cut",
                      "--no-sweeps", "--no-pictures", "--repetitions", "1"}),
        180);
    ASSERT_EQ(result.code, 0) << result.err;
    const Json json = results("errors");
    std::map<double, uint32_t> clusters;
    for (const Json& row : json.at("rows"))
        if (row.at("method") == "illumination-cut")
            clusters[std::round(100 * row.at("error_allowed").get<double>())] = row.at("clusters");
    EXPECT_EQ(clusters, (std::map<double, uint32_t>{{5, 40}, {30, 0}}));
}

TEST_F(ManyLightsCommand, WritesAPageAndItsNumbers)
{
    const Result result =
        finish(start(kManyLights + kFewLights + Strings{kScene, "-o", "new/lights"}), 180);
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_TRUE(contains(result.err, "new/lights/index.html"));
    const Json json = results("new/lights");
    EXPECT_EQ(json.at("schema"), 1);
    EXPECT_EQ(json.at("command"), "bench manylights");
    EXPECT_EQ(json.at("interrupted"), false);
    EXPECT_EQ(json.at("main_clusters"), 40);

    std::set<std::string> methods;
    for (const Json& row : json.at("rows")) {
        for (const char* key :
             {"lights", "clusters", "seconds", "visibility_seconds", "rays", "visibility_percent",
              "rmse_8bit", "rmse_hdr", "relmse_hdr", "author_visibility_percent"}) {
            ASSERT_TRUE(row.at(key).is_number()) << key << ": " << row.dump();
            EXPECT_TRUE(std::isfinite(row.at(key).get<double>()));
        }
        EXPECT_EQ(row.at("scene"), "cornell-diffuse");
        EXPECT_EQ(row.at("repetitions"), 3);
        EXPECT_GT(row.at("seconds"), 0);
        EXPECT_GT(row.at("rays"), 0);
        EXPECT_GT(row.at("rmse_hdr"), 0);
        double split = 0;
        for (const Json& part : row.at("split_seconds")) split += part.get<double>();
        EXPECT_NEAR(split, row.at("seconds"), 1e-6 * row.at("seconds").get<double>());
        const std::string method = row.at("method");
        methods.insert(method);
        if (method != "full" && method != "full-2000") {
            EXPECT_TRUE(row.at("clusters") != 40 || row.at("rmse_8bit_to_full").is_number());
        }
        if (method == "full-single") {
            // The same bits, found one by one.
            EXPECT_EQ(row.at("rmse_8bit_to_full"), 0);
        }
    }
    for (const char* method : {"full", "full-single", "matching", "matching-whole", "thesis",
                               "fixed-amc", "lightslice", "lightcuts", "illumination-cut"})
        EXPECT_TRUE(methods.contains(method)) << method;
    EXPECT_FALSE(json.at("claims").empty());

    const Json& scene = json.at("scenes")[0];
    EXPECT_GT(scene.at("lights"), 100);
    EXPECT_LT(scene.at("lit_receivers"), scene.at("receivers"));
    EXPECT_GT(scene.at("rays_per_thread_second").at("rtcOccluded16"), 0);
    const std::string page = readAll(work("new/lights/index.html"));
    EXPECT_EQ(readMarkup(page).problem, "");
    EXPECT_FALSE(contains(page, "http://") || contains(page, "https://"));
    EXPECT_FALSE(contains(withoutPictures(page), "nan"));
    for (const Json& shot : scene.at("pictures")) {
        EXPECT_TRUE(fs::exists(work("new/lights/" + shot.at("file").get<std::string>())));
        EXPECT_TRUE(contains(page, shot.at("name").get<std::string>()));
    }
    EXPECT_GE(scene.at("pictures").size(), 5u);
    EXPECT_TRUE(contains(result.out, "cornell-diffuse, 40 clusters"));
}

TEST_F(ManyLightsCommand, ReferencesAreMadeOnceAndErrorsRepeat)
{
    const Strings bench =
        kManyLights + kFewLights + Strings{kScene,          "-o",       "lights",
                                           "--methods",     "matching", "--no-pictures",
                                           "--repetitions", "1",        "-q"};
    const auto scene = [&](const Strings& more) {
        const Result result = run(bench + more);
        EXPECT_EQ(result.code, 0) << result.err;
        return results("lights");
    };
    const Json first = scene({}), again = scene({});
    EXPECT_EQ(first.at("scenes")[0].at("reference_kept"), false);
    EXPECT_EQ(again.at("scenes")[0].at("reference_kept"), true);
    ASSERT_EQ(first.at("rows").size(), 4u);  // full and matching, two numbers of clusters
    for (size_t i = 0; i < first.at("rows").size(); ++i)
        for (const char* key : {"rmse_8bit", "rmse_hdr", "rays"})
            EXPECT_EQ(first.at("rows")[i].at(key), again.at("rows")[i].at(key)) << i << key;
    EXPECT_EQ(scene({"--seed", "7"}).at("scenes")[0].at("reference_kept"), false);
    EXPECT_EQ(scene({"--clamp", ".5"}).at("scenes")[0].at("reference_kept"), false);
    // As many clusters as lights: the reference itself.
    const Json exact = scene({"--clusters", "4000"});
    EXPECT_LT(exact.at("rows")[0].at("rmse_hdr"), 1e-5);
}

TEST_F(ManyLightsCommand, CtrlCKeepsWhatIsThere)
{
    const Strings bench = kManyLights + kFewLights + Strings{kScene, "-o", "new/lights"};
    pid_t pid = start(bench + Strings{"--lights", "4000000", "--share", "1"});
    waitForError("lights and receivers");
    kill(pid, SIGINT);
    Result result = finish(pid, 60);
    EXPECT_EQ(result.code, 130) << result.err;
    EXPECT_TRUE(contains(result.err, "nothing measured"));
    EXPECT_FALSE(fs::exists(work("new")));

    // So many repetitions that only a signal ends them.
    pid = start(bench + Strings{"--repetitions", "100", "--share", "1", "--methods", "matching",
                                "--size", "128x96"});
    waitForError("repetition");
    kill(pid, SIGINT);
    result = finish(pid, 60);
    EXPECT_EQ(result.code, 130) << result.err;
    EXPECT_TRUE(contains(result.err, "what was measured so far is written"));
    const Json json = results("new/lights");
    EXPECT_EQ(json.at("interrupted"), true);
    ASSERT_FALSE(json.at("rows").empty());
    EXPECT_GE(json.at("rows")[0].at("repetitions"), 1);
    EXPECT_TRUE(contains(readAll(work("new/lights/index.html")), "Interrupted"));
}

}  // namespace
