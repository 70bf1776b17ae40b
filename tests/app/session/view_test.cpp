// The viewer as a person meets it: the real program in a window of an X server without a screen,
// driven by scripts.
#include <csignal>
#include <fstream>

#include "core/image/image.h"
#include "tests/support/process/program.h"
#include "tests/support/session/virtual_display.h"

namespace {

using namespace tests;

class View : public Cli {
protected:
    void SetUp() override
    {
        if (!VirtualDisplay::installed()) GTEST_SKIP() << "Xvfb is not installed";
        display_.emplace();
        fs::create_directory_symlink(kAssets, work("assets"));
    }

    /// Runs a script; what it printed, as JSON.
    Json runScript(const std::string& script, const Strings& more = {}, int code = 0,
                   double seconds = 240)
    {
        const Result result = finish(start(Strings{"view", kScene, "--script", script,
                                                   "--no-settings", "--size", "480x270"} +
                                           more),
                                     seconds);
        EXPECT_EQ(result.code, code) << result.err << result.out;
        EXPECT_FALSE(contains(result.err, "validation:")) << result.err;
        const Json report = Json::parse(result.out, nullptr, false);
        EXPECT_FALSE(report.is_discarded()) << result.out << result.err;
        return report;
    }

    Json runSteps(const Json& steps, const Strings& more = {}, int code = 0)
    {
        writeFile("script.json", Json{{"steps", steps}}.dump());
        return runScript("script.json", more, code);
    }

    std::optional<VirtualDisplay> display_;
};

TEST_F(View, TheTourDoesEverythingWithoutAMessage)
{
    const Json report = runScript((kAssets / "scripts" / "tour.json").string(), {"--validation"});
    EXPECT_TRUE(report["failures"].empty()) << report["failures"].dump(1);
    EXPECT_EQ(report["counters"],
              (Json{{"nan", 0}, {"inf", 0}, {"negative", 0}, {"stack_overflow", 0}}));
    ASSERT_EQ(report["errors"].size(), 1u)
        << report["errors"].dump(1) << " (the file that is no scene)";
    EXPECT_GT(report["input_frames"]["count"].get<int>(), 0);
    for (const char* name : {"tour-picture.png", "tour-error.png", "tour-flip.png",
                             "tour-compare.png", "tour-equal-time.png", "tour-help.png"})
        EXPECT_GT(fs::file_size(work(name)), 10'000u) << name;
    const core::ImageFile saved = exr("tour.exr");
    EXPECT_GE(std::stoi(saved.metadata.at("spp")), 4);
    EXPECT_TRUE(contains(saved.metadata.at("scene"), "animated.gltf"));
}

TEST_F(View, FailuresOfAScriptAreItsExitCode)
{
    const Json report = runSteps({{{"wait", "loaded"}},
                                  {{"wait", "samples"}, {"value", 1e9}, {"timeout", 0.5}},
                                  {{"expect", "document"}, {"name", "other.gltf"}},
                                  {{"do", "set"}, {"name", "max-dept"}, {"value", 1}}},
                                 {}, 1);
    ASSERT_EQ(report["failures"].size(), 3u) << report.dump(1);
    EXPECT_TRUE(contains(report["failures"][0], "waited in vain"));
    EXPECT_TRUE(contains(report["failures"][1], "cornell-diffuse.gltf"));
    EXPECT_TRUE(contains(report["failures"][2], "max-depth"));
}

TEST_F(View, ScriptsThatAreNoneAreRefusedBeforeAnythingIsShown)
{
    writeFile("words.json", "these are words");
    writeFile("unknown.json", R"({"steps":[{"expext":"clean"}]})");
    writeFile("action.json", R"({"steps":[{"repeat":2,"steps":[{"do":"paus"}]}]})");
    expectRefused({"view", "--script", "words.json"}, 3, "words.json: not JSON");
    expectRefused({"view", "--script", "unknown.json"}, 3, "did you mean expect?");
    expectRefused({"view", "--script", "action.json"}, 3, "/steps/0/steps/0/do");
    expectRefused({"view", "--script", "none.json"}, 3, "none.json");
}

TEST_F(View, ARandomWalkInTheWindowEndsAsItShould)
{
    writeFile("broken.gltf", R"({"asset":{"version":"2.0"},"meshes":[{}]})");
    const Json report = runSteps(
        {{{"random", 150},
          {"seed", 3},
          {"folder", work().string()},
          {"files", {kScene, (kAssets / "lights.gltf").string(), work("broken.gltf").string()}}},
         {{"do", "load"}, {"file", kScene}},
         {{"wait", "seconds"}, {"value", 0.3}},
         {{"wait", "loaded"}},
         {{"expect", "document"}, {"name", "cornell-diffuse.gltf"}}},
        {"--validation"});
    EXPECT_TRUE(report["failures"].empty()) << report["failures"].dump(1);
}

/// Whether the process holds SIGINT back, for a thread that waits for it. All signals are held back
/// for a moment whenever a thread is made, which libraries do before main.
bool listens(pid_t pid)
{
    std::ifstream status("/proc/" + std::to_string(pid) + "/status");
    for (std::string line; std::getline(status, line);) {
        if (!line.starts_with("SigBlk:")) continue;
        const auto blocked = std::stoull(line.substr(7), nullptr, 16);
        const auto blocks = [blocked](int signal) { return (blocked >> (signal - 1) & 1) != 0; };
        return blocks(SIGINT) && !blocks(SIGSEGV);
    }
    return false;
}

/// The time counts from when the program listens, so that a busy machine, which takes its time to
/// load libraries, is asked for the same.
TEST_F(View, EndsWithinASecondWhateverItIsDoing)
{
    for (const double after : {0.0, 0.15, 0.5, 1.2}) {
        const pid_t pid = start({"view", (kAssets / "hall.gltf").string(), "--no-settings"});
        for (int i = 0; i < 6000 && !listens(pid); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        ASSERT_TRUE(listens(pid));
        std::this_thread::sleep_for(std::chrono::duration<double>(after));
        const auto asked = std::chrono::steady_clock::now();
        kill(pid, SIGINT);
        const Result result = finish(pid, 30);
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - asked;
        EXPECT_EQ(result.code, 130) << "after " << after << " s: " << result.err;
        RecordProperty("seconds-" + std::to_string(after), std::to_string(took.count()));
    }
}

TEST_F(View, WithoutItsDisplayItEndsAndSaysSo)
{
    const pid_t pid = start({"view", kScene, "--no-settings"});
    waitForError("loaded in");  // by then there is a window
    std::this_thread::sleep_for(std::chrono::seconds(2));
    display_->kill();
    const Result result = finish(pid, 30);
    EXPECT_EQ(result.code, 1) << result.err;
    EXPECT_TRUE(contains(result.err, "display")) << result.err;
}

/// A signal, and a display that goes: all that a question would have named is in files afterwards.
TEST_F(View, WhatNobodyCanBeAskedAboutIsSaved)
{
    writeFile("script.json", R"({"steps": [{"wait": "loaded"}, {"do": "add-key", "frame": 0},
        {"do": "orbit", "dx": 0.1}, {"do": "add-key", "frame": 24},
        {"wait": "seconds", "value": 1000, "timeout": 1000}]})");
    const auto paths = [&] {
        return std::ranges::count_if(
            files(), [](const std::string& name) { return name.ends_with("-path.json"); });
    };
    for (const bool display : {true, false}) {
        const pid_t pid = start({"view", kScene, "--no-settings", "--script", "script.json"});
        waitForError("the camera path has 2 keys");
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
        if (display)
            kill(pid, SIGTERM);
        else
            display_->kill();
        const Result result = finish(pid, 30);
        EXPECT_EQ(result.code, display ? 130 : 1) << result.err;
        EXPECT_TRUE(contains(result.err, "path saved")) << result.err;
        EXPECT_EQ(paths(), display ? 1 : 2);
    }
}

TEST_F(View, DamagedSettingsAreSetAsideWithAWord)
{
    fs::create_directories(work("config/rekindle"));
    writeFile("config/rekindle/settings.json", "{\"version\": 1, \"window\": [64");
    writeFile("script.json", R"({"steps": [{"wait": "loaded"}]})");
    const Result result = finish(start({"view", kScene, "--script", "script.json"},
                                       {"XDG_CONFIG_HOME=" + work("config").string()}),
                                 240);
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_TRUE(contains(result.err, "settings.json.bad")) << result.err;
    EXPECT_TRUE(fs::exists(work("config/rekindle/settings.json.bad")));
}

TEST_F(View, OnlyScenesHaveAFirstPicture)
{
    writeFile("path.json",
              R"({"keys": [{"frame": 0, "position": [0, 1, 3], "target": [0, 1, 0]}]})");
    const Json report = runSteps({{{"wait", "still"}},
                                  {{"drop", work("path.json").string()}},
                                  {{"wait", "frames"}, {"value", 5}},
                                  {{"do", "replay"}, {"file", work("none.png").string()}},
                                  {{"wait", "frames"}, {"value", 5}},
                                  {{"do", "load"}, {"file", work("none.gltf").string()}},
                                  {{"wait", "notice"}, {"text", "none.gltf"}},
                                  {{"wait", "frames"}, {"value", 5}},
                                  {{"do", "load"}, {"file", kScene}},
                                  {{"wait", "loaded"}},
                                  {{"wait", "still"}},
                                  {{"wait", "frames"}, {"value", 5}}});
    EXPECT_TRUE(report["failures"].empty()) << report["failures"].dump(1);
    EXPECT_EQ(report["first_picture_seconds"]["count"], 2);
}

}  // namespace
