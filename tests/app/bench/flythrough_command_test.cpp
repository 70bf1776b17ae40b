// `rekindle bench flythrough` as a person or a script meets it: what it refuses, what it writes,
// what it keeps, how it stops.
#include <csignal>
#include <map>

#include <unistd.h>

#include "core/methods/reuse_params.h"
#include "tests/support/files/text_search.h"
#include "tests/support/process/program.h"

namespace {

using namespace tests;

const Strings kFlythrough{"bench", "flythrough"};

/// Small enough for a test.
const Strings kTinyFlight{"--size",  "24x20", "--frames",        "3",  "--steps",  "1,4",
                          "--seeds", "2",     "--reference-spp", "16", "--device", "cpu"};

class FlythroughCommand : public Cli {
protected:
    Json results(const std::string& folder) const
    {
        return Json::parse(readAll(work(folder + "/flythrough.json")));
    }

    /// A copy of a scene, to be changed.
    std::string copyOf(const std::string& name)
    {
        for (const char* ending : {".gltf", ".bin"})
            fs::copy_file(kAssets / (name + ending), work(name + ending));
        return name + ".gltf";
    }
};

TEST_F(FlythroughCommand, NonsenseIsRefused)
{
    expectRefused(kFlythrough, 2, "scene is missing");
    expectRefused(kFlythrough + Strings{kScene}, 2, "-o DIR");
    const Strings bench = kFlythrough + Strings{kScene, "-o", "x"};
    expectRefused(bench + Strings{"--steps", "1,much"}, 2, "'much'");
    expectRefused(bench + Strings{"--steps", "0"}, 2, "--steps");
    expectRefused(bench + Strings{"--steps", ","}, 2, "empty");
    expectRefused(bench + Strings{"--frames", "1"}, 2, "--frames");
    expectRefused(bench + Strings{"--seeds", "1"}, 2, "--seeds");
    expectRefused(bench + Strings{"--strategies", "ra,magic"}, 2, "'magic' is not one of");
    expectRefused(bench + Strings{"--records", "999"}, 2, "--records");
    expectRefused(bench + Strings{"--reuse", "ra"}, 2, "--reuse");
    expectRefused(bench + Strings{"--device", "cpu", "--device-index", "0"}, 2, "--device-index");
    expectRefused(bench + Strings{"--stps", "1"}, 2, "did you mean --steps?");
    const Result help = run(kFlythrough + Strings{"--help"});
    EXPECT_EQ(help.code, 0);
    EXPECT_TRUE(contains(help.out, "Example: rekindle bench flythrough "));
    EXPECT_TRUE(contains(help.out, "--protection"));
}

TEST_F(FlythroughCommand, InputAndFoldersThatCannotBeAreRefused)
{
    const Strings bench = kFlythrough + kTinyFlight;
    expectRefused(bench + Strings{kScene, "none.gltf", "-o", "x"}, 3, "none.gltf");
    writeFile("words.gltf", "these are words");
    expectRefused(bench + Strings{"words.gltf", "-o", "x"}, 3, "words.gltf");
    writeFile("path.json", "{\"keys\": [{\"frame\": 0}, {\"frame\": \"one\"}]}");
    expectRefused(bench + Strings{kScene, "-o", "x", "--path", "path.json"}, 3, "path.json");
    expectRefused(bench + Strings{kScene, "-o", "x", "--path", "no-path.json"}, 3, "no-path.json");
    writeFile("short.json", "{\"keys\": [{\"frame\": 0}, {\"frame\": 1}]}");
    expectRefused(bench + Strings{kScene, "-o", "x", "--path", "short.json", "--frames", "9"}, 3,
                  "give fewer --frames");
    expectRefused(bench + Strings{kScene, "-o", "x", "--camera", "nobody"}, 2, "nobody");
    EXPECT_FALSE(fs::exists(work("x")));
    writeFile("file", "mine");
    expectRefused(bench + Strings{kScene, "-o", "file"}, 3, "file: is a file");
    expectRefused(bench + Strings{kScene, "-o", "/proc/nowhere"}, 3, "cannot be made");
    EXPECT_EQ(readAll(work("file")), "mine");
}

TEST_F(FlythroughCommand, WritesAPageAndItsNumbers)
{
    const Result result =
        finish(start(kFlythrough + kTinyFlight + Strings{kScene, "-o", "new/fly"}), 180);
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_TRUE(contains(result.err, "new/fly/index.html"));
    const Json json = results("new/fly");
    EXPECT_EQ(json.at("schema"), 1);
    EXPECT_EQ(json.at("command"), "bench flythrough");
    EXPECT_EQ(json.at("interrupted"), false);

    // Every strategy in every place, Discard measured against itself.
    std::map<std::string, size_t> places;
    for (const Json& row : json.at("rows")) {
        for (const char* key : {"variance", "rmse", "relmse", "mean_signed_error",
                                "mean_signed_error_se", "rays", "seconds"})
            EXPECT_TRUE(row.at(key).is_number()) << row.dump();
        EXPECT_EQ(row.at("scene"), "cornell-diffuse");
        EXPECT_GT(row.at("rays"), 24 * 20);
        EXPECT_GT(row.at("seconds"), 0);
        EXPECT_GT(row.at("rmse"), 0);
        if (row.at("n") != 1) continue;
        EXPECT_TRUE(row.at("step") == 1 || row.at("step") == 4);
        ++places[row.at("strategy")];
        if (row.at("strategy") != "discard") continue;
        EXPECT_EQ(row.at("relmse_ratio"), 1);
        EXPECT_EQ(row.at("equal_time_ratio"), 1);
        EXPECT_EQ(row.at("trimmed_ratio"), 1);
    }
    const auto names = core::enumNames<core::ReuseStrategy>();
    EXPECT_EQ(places.size(), names.size());
    for (const std::string_view name : names) {
        EXPECT_EQ(places[std::string(name)], 2u * 3u) << name;  // steps, frames 1, 2, 3
        EXPECT_TRUE(contains(result.out, "  " + std::string(name) + ' ')) << name;
    }
    EXPECT_FALSE(json.at("sweeps").empty());
    EXPECT_EQ(lineCount(readAll(work("new/fly/flythrough.csv"))), 1 + 6 * names.size());

    // The page stands alone: every picture is in it, and beside it.
    const std::string page = readAll(work("new/fly/index.html"));
    EXPECT_TRUE(page.ends_with("</html>\n"));
    const Json pictures = json.at("scenes")[0].at("pictures");
    EXPECT_GE(pictures.size(), names.size() + 1);
    for (const Json& picture : pictures)
        for (const char* file : {"file", "part"})
            EXPECT_TRUE(fs::exists(work("new/fly/" + picture.at(file).get<std::string>())));
    EXPECT_EQ(countOf(page, "src=\"data:image/png;base64,iVBORw0KGgo"), 2 * pictures.size());
    EXPECT_EQ(countOf(page, "src="), 2 * pictures.size());
    EXPECT_FALSE(contains(page, "http://") || contains(page, "https://"));
    for (const char* file : {"flythrough.json", "flythrough.csv", "pictures", "references"}) {
        EXPECT_TRUE(contains(page, file)) << file;
        EXPECT_TRUE(fs::exists(work(std::string("new/fly/") + file))) << file;
    }
}

TEST_F(FlythroughCommand, FliesInTheWindowsOwnLoop)
{
    expectRefused(kFlythrough + Strings{kScene, "-o", "x", "--window", "640"}, 2, "--window");
    const Result result =
        finish(start(kFlythrough + kTinyFlight +
                     Strings{kScene, "-o", "fly", "--strategies", "naive", "--frames", "2",
                             "--no-sweeps", "--quick", "--window", "40x32"}),
               180);
    ASSERT_EQ(result.code, 0) << result.err;
    const Json json = results("fly");
    EXPECT_EQ(json.at("window_size"), Json::array({40, 32}));
    const Json& rows = json.at("scenes")[0].at("window").at("rows");
    ASSERT_EQ(rows.size(), 4u);  // two rates, two strategies
    for (size_t i = 0; i < rows.size(); ++i) {
        const Json& row = rows[i];
        EXPECT_EQ(row.at("strategy"), i % 2 == 0 ? "discard" : "naive");
        EXPECT_EQ(row.at("target_seconds"), i < 2 ? 0.033 : 0.1);
        EXPECT_GT(row.at("relmse"), 0);
        EXPECT_GT(row.at("picture_seconds"), 0);
        EXPECT_GT(row.at("share"), 0);
        EXPECT_LE(row.at("share"), 1);
        EXPECT_GT(row.at("scale"), 0);
        EXPECT_LE(row.at("scale"), 1);
        EXPECT_EQ(row.at("pictures"), 2);
        EXPECT_GT(row.at("shown_mse_by_size"), 0);
        EXPECT_GT(row.at("under_way_mse"), 0);
        if (i % 2 == 0) {
            EXPECT_EQ(row.at("relmse_ratio"), 1);
            EXPECT_LT(row.at("shown_mse_by_size"), row.at("shown_mse")) << "there is noise, too";
        }
    }
    EXPECT_TRUE(contains(readAll(work("fly/index.html")), "In the window's own loop"));
    EXPECT_TRUE(contains(result.out, "in the window's loop, 40x32"));
    EXPECT_TRUE(fs::exists(work("fly/references/cornell-diffuse-window-40x32-64spp.exr")));
}

TEST_F(FlythroughCommand, ReferencesAreMadeOnceAndAnewWhenTheyNoLongerFit)
{
    const std::string scene = copyOf("cornell-diffuse");
    const Strings bench = kFlythrough + kTinyFlight +
                          Strings{scene, "-o", "fly", "--strategies", "ra", "--frames", "2", "-q"};
    const auto kept = [&](const Strings& more) {
        const Result result = run(bench + more);
        EXPECT_EQ(result.code, 0) << result.err;
        return results("fly").at("scenes")[0].at("reference_kept").get<bool>();
    };
    const fs::path file = work("fly/references/cornell-diffuse-24x20-16spp.exr");
    EXPECT_FALSE(kept({}));
    ASSERT_TRUE(fs::exists(file));
    const core::ImageFile reference = exr("fly/references/cornell-diffuse-24x20-16spp.exr");
    EXPECT_TRUE(reference.hasLayer("variance"));
    const std::string key = reference.metadata.at("rekindle:reference");
    EXPECT_EQ(Json::parse(key).at("commit"), results("fly").at("commit"));
    const auto written = fs::last_write_time(file);
    EXPECT_TRUE(kept({}));
    EXPECT_TRUE(kept({"--no-sweeps"}));
    EXPECT_TRUE(results("fly").at("sweeps").empty());
    EXPECT_TRUE(kept({"--steps", "2", "--seed", "8", "--records", "2"}));
    EXPECT_EQ(fs::last_write_time(file), written);
    EXPECT_FALSE(kept({"--max-depth", "3"}));
    EXPECT_FALSE(kept({}));
    writeFile("fly/references/cornell-diffuse-24x20-16spp.exr", "no picture");
    EXPECT_FALSE(kept({}));
    EXPECT_TRUE(kept({}));
    std::string text = readAll(work(scene));
    text.insert(text.rfind('}'), " ");
    writeFile(scene, text);
    EXPECT_FALSE(kept({}));
}

TEST_F(FlythroughCommand, SameSeedSameErrorsOnEitherDevice)
{
    const auto rows = [this](const std::string& device, const std::string& folder) {
        const Strings few{"--steps", "1", "--no-sweeps", "--strategies", "naive,ra"};
        const pid_t pid = start(kFlythrough + kTinyFlight + few +
                                Strings{kScene, "-o", folder, "--device", device});
        const Result result = finish(pid, 180);  // kernels are compiled on the way
        EXPECT_EQ(result.code, 0) << result.err;
        return results(folder).at("rows");
    };
    const Json a = rows("cpu", "a"), b = rows("cpu", "b"), c = rows("vulkan", "c");
    ASSERT_EQ(a.size(), b.size());
    ASSERT_EQ(a.size(), c.size());
    for (size_t i = 0; i < a.size(); ++i) {
        EXPECT_EQ(a[i].at("relmse"), b[i].at("relmse"));
        EXPECT_EQ(a[i].at("strategy"), c[i].at("strategy"));
        EXPECT_GT(c[i].at("relmse").get<double>(), 0);
    }
}

TEST_F(FlythroughCommand, CtrlCKeepsWhatIsThere)
{
    // So many samples that only a signal ends the reference.
    const Strings endless{"--reference-spp", "100000000", "--device", "cpu", "--size", "24x20"};
    pid_t pid = start(kFlythrough + endless + Strings{kScene, "-o", "new/fly"});
    waitForError("reference");
    kill(pid, SIGINT);
    Result result = finish(pid, 20);
    EXPECT_EQ(result.code, 130) << result.err;
    EXPECT_TRUE(contains(result.err, "nothing written"));
    EXPECT_EQ(result.out, "");
    EXPECT_FALSE(fs::exists(work("new")));

    // Files are written after each scene; the rest is stopped then.
    pid = start(kFlythrough + kTinyFlight +
                Strings{kScene, kScene, kScene, kScene, "-o", "fly", "--seeds", "9"});
    for (int i = 0; i < 3000 && !fs::exists(work("fly/index.html")); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    kill(pid, SIGINT);
    result = finish(pid, 20);
    EXPECT_EQ(result.code, 130) << result.err;
    EXPECT_TRUE(contains(result.err, "what was measured so far is written"));
    const Json json = results("fly");
    EXPECT_EQ(json.at("interrupted"), true);
    EXPECT_GE(json.at("scenes").size(), 1u);
    EXPECT_EQ(json.at("scenes")[0].at("scene"), "cornell-diffuse");
    EXPECT_TRUE(contains(result.out, "cornell-diffuse, after 3 frames"));
    EXPECT_TRUE(contains(readAll(work("fly/index.html")), "Interrupted"));
}

}  // namespace
