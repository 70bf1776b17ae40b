// Settings between runs: what is written comes back to the bit, and nothing that a file may hold
// keeps the program from starting.
#include "app/session/settings.h"

#include <fstream>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include "app/base/files.h"
#include "app/files/params_json.h"
#include "core/base/check.h"
#include "core/base/output_file.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/process/environment_variable.h"

namespace {

namespace fs = std::filesystem;
using app::Settings;
using tests::EnvironmentVariable;
using tests::TemporaryFolder;

/// Differs from the defaults in every member.
Settings someSettings()
{
    Settings s;
    s.view = {.show = app::Show::deviation,
              .methodMap = 2,
              .exposure = -1.3f,
              .tone = app::Tone::neutral,
              .map = app::ColourMap::magma,
              .errorKind = app::ErrorKind::squared,
              .errorRange = 1e-4f,  // at its bound, which is no float
              .compareAt = 0.3f,
              .pictureScale = 0.1f,
              .frameLimit = 144,
              .movingRate = 17.5f,
              .movingDepth = 5,
              .moving = app::Moving::shaded,
              .movingDetail = false,
              .wheel = app::Wheel::pivot,
              .walls = app::Walls::pass};
    s.panels = {.panel = false,
                .help = true,
                .log = true,
                .plot = false,
                .profiler = true,
                .side = app::PanelSide::right,
                .fold = app::PanelFold::folded,
                .width = 31.25f,
                .uiScale = 1.5f,
                .opacity = 0.3f};
    s.sections = {.scene = false,
                  .method = false,
                  .view = false,
                  .camera = true,
                  .animation = false,
                  .path = true,
                  .compare = true,
                  .reference = true,
                  .limits = true,
                  .save = true};
    s.places = "[Window][Messages###log]\nPos=40,50\nSize=300,200\n";
    s.keepParams(core::PathParams{.maxDepth = 17,
                                  .rouletteDepth = 5,
                                  .seed = 4294967295u,
                                  .sampler = core::SamplerKind::independent,
                                  .strategy = core::Strategy::light,
                                  .clampIndirect = 2.7f,
                                  .kernel = core::Kernel::megakernel,
                                  .sky = core::SkySampling::regions});
    s.windowSize = {800, 601};
    s.recentFiles = {"/a/b.glb", "/a/c d.gltf"};
    s.presets = {{"mine", core::PathParams{.maxDepth = 3}},
                 {"\xc3\xa9t\xc3\xa9", core::PathParams{.seed = 9}}};
    for (const core::MethodInfo& method : core::methods()) {  // of every method one
        s.presets.push_back({"of " + std::string(method.id()), method.defaults});
        if (method.id() != "path") s.keepParams(method.defaults);
    }
    s.cameras = {{"00ff", R"([{"name":"door","position":[0.1,2.0,3.0]}])"}};
    return s;
}

/// Without what belongs to the picture that was on show.
Settings lasting(Settings s)
{
    const app::ViewParams fresh;
    s.view.show = fresh.show;
    s.view.methodMap = fresh.methodMap;
    s.view.exposure = fresh.exposure;
    s.view.compareAt = fresh.compareAt;
    s.panels.panel = app::PanelParams().panel;
    return s;
}

Settings read(const fs::path& file, bool expectProblem = false)
{
    std::string problem = "left from before";
    const Settings s = app::readSettings(file, problem);
    EXPECT_EQ(!problem.empty(), expectProblem) << problem;
    return s;
}

TEST(Settings, RoundTripToTheBit)
{
    const TemporaryFolder folder;
    const fs::path file = folder / "new" / "folders" / "settings.json";
    const Settings s = someSettings();
    // The test is one only if nothing is at its default.
    const Settings defaults;
    const auto differ = [](const auto& a, const auto& b) {
        const auto left = app::paramsJson(a), right = app::paramsJson(b);
        for (const auto& [name, value] : left.items())
            EXPECT_NE(value, right[name]) << name << " is at its default";
    };
    differ(s.view, defaults.view);
    differ(s.panels, defaults.panels);
    differ(s.sections, defaults.sections);
    differ(s.paramsOf("path"), defaults.paramsOf("path"));
    app::writeSettings(file, s);
    EXPECT_EQ(read(file), lasting(s));
    app::writeSettings(file, defaults);  // over the other
    EXPECT_EQ(read(file), defaults);
    EXPECT_EQ(std::distance(fs::directory_iterator(file.parent_path()), fs::directory_iterator()),
              1);
}

TEST(Settings, NoFileIsNoProblem)
{
    const TemporaryFolder folder;
    EXPECT_EQ(read(folder / "settings.json"), Settings());
    EXPECT_EQ(folder.count(), 0u);
}

TEST(Settings, DamagedFilesAreKeptAside)
{
    for (const char* text :
         {"", "{", "[]", "7", "{\"version\": 1", "{}", "{\"version\": 0}", "{\"version\": \"1\"}",
          "{\"version\": 1.5}", "\xff\xfe", "{\"version\": 1, \"view\": {\"exposure\": 1e999}}"}) {
        const TemporaryFolder folder;
        const fs::path file = folder / "settings.json";
        core::writeFile(file, text);
        std::string problem;
        EXPECT_EQ(app::readSettings(file, problem), Settings()) << text;
        EXPECT_NE(problem.find(file.string() + ": "), std::string::npos) << problem;
        EXPECT_NE(problem.find("settings.json.bad"), std::string::npos) << problem;
        EXPECT_EQ(app::readText(folder / "settings.json.bad"), text);
        EXPECT_FALSE(fs::exists(file));
        EXPECT_EQ(read(file), Settings());  // and the next time there is nothing to report
    }
    const TemporaryFolder folder;
    core::writeFile(folder / "settings.json", std::string(200000, '['));
    EXPECT_EQ(read(folder / "settings.json", true), Settings());
}

TEST(Settings, TheSizeOfTheWindowIsReadWithoutTouchingTheFile)
{
    const TemporaryFolder folder;
    const fs::path file = folder / "settings.json";
    const glm::uvec2 fresh = Settings().windowSize;
    EXPECT_EQ(app::keptWindowSize(""), fresh);
    EXPECT_EQ(app::keptWindowSize(file), fresh);
    for (const auto& [text, size] : std::vector<std::pair<std::string, glm::uvec2>>{
             {R"({"version": 1, "window": [800, 600]})", {800, 600}},
             {R"({"version": 9, "window": [800, 600]})", {800, 600}},
             {R"({"version": 1, "window": [8, 600]})", fresh},
             {R"({"window": [800, 600]})", fresh},
             {R"({"version": 1, "window": [800)", fresh}}) {
        core::writeFile(file, text);
        EXPECT_EQ(app::keptWindowSize(file), size) << text;
        EXPECT_EQ(app::readText(file), text);
        EXPECT_EQ(folder.count(), 1u) << text;
    }
}

TEST(Settings, WhatIsAbsentOrWrongFallsBackAlone)
{
    const TemporaryFolder folder;
    const fs::path file = folder / "settings.json";
    core::writeFile(file,
                    R"({"version": 1, "colour": "unknown", "view": {"exposure": 3, "tone": "sepia",
        "error-range": -1, "compare-at": "0.7", "moving-depth": 2.5, "frame-limit": 30, "show": 3},
        "panels": {"help": 1, "log": true, "opacity": 0, "ui-scale": 2},
        "path": [1, 2], "window": [10, 700],
        "recent": ["/x.glb", "relative.glb", 5, "/x.glb"],
        "presets": [{"name": "a", "path": {"max-depth": 99999, "seed": 4}}, {"name": ""}, {"path": {}}, 7],
        "cameras": {"h": "text", "i": [], "j": [{"yfov": 40}]}})");
    const Settings s = read(file);
    Settings expected;
    expected.view.frameLimit = 30;
    expected.panels.log = true;
    expected.panels.uiScale = 2;
    expected.recentFiles = {"/x.glb"};
    expected.presets = {{"a", core::PathParams{.seed = 4}}};
    expected.cameras = {{"j", R"([{"yfov":40}])"}};
    EXPECT_EQ(s, expected);
    core::writeFile(file, R"({"version": 1})");
    EXPECT_EQ(read(file), Settings());
    core::writeFile(
        file,
        R"({"version": 1, "view": 3, "recent": {}, "presets": null, "cameras": [1], "window": [1280]})");
    EXPECT_EQ(read(file), Settings());
}

TEST(Settings, NewerVersionsAreReadAsFarAsKnownAndKept)
{
    const TemporaryFolder folder;
    const fs::path file = folder / "settings.json";
    const std::string text =
        R"({"version": 2, "view": {"frame-limit": 30, "hologram": true}, "future": []})";
    core::writeFile(file, text);
    std::string problem;
    const Settings s = app::readSettings(file, problem);
    EXPECT_EQ(s.view.frameLimit, 30);
    EXPECT_NE(problem.find("newer"), std::string::npos);
    app::writeSettings(file, s);
    EXPECT_EQ(app::readText(folder / "settings.json.newer"), text);
}

TEST(Settings, FoldersThatRefuse)
{
    const TemporaryFolder folder;
    core::writeFile(folder / "plain", "a file where a folder should be");
    EXPECT_THROW(app::writeSettings(folder / "plain" / "settings.json", {}), core::Error);
    EXPECT_THROW(app::writeSettings(folder.path(), {}), core::Error);  // a folder, not a file
    EXPECT_THROW(app::writeSettings("", {}), core::Error);
    EXPECT_EQ(read(folder.path(), true), Settings());
    EXPECT_TRUE(fs::is_directory(folder.path()));  // a folder of that name is not set aside
    EXPECT_EQ(read("", true), Settings());
    if (geteuid() == 0) return;  // may write everywhere
    core::writeFile(folder / "private.json", R"({"version": 1})");
    fs::permissions(folder / "private.json", fs::perms::none);
    EXPECT_EQ(read(folder / "private.json", true), Settings());
    EXPECT_TRUE(fs::exists(folder / "private.json.bad")) << "else it would be replaced at the end";
    const fs::path sealed = folder / "sealed";
    fs::create_directory(sealed);
    core::writeFile(sealed / "settings.json", "{");
    fs::permissions(sealed, fs::perms::owner_read | fs::perms::owner_exec);
    EXPECT_THROW(app::writeSettings(sealed / "settings.json", {}), core::Error);
    std::string problem;
    EXPECT_EQ(app::readSettings(sealed / "settings.json", problem), Settings());
    EXPECT_NE(problem.find("could not be renamed"), std::string::npos) << problem;
    fs::permissions(sealed, fs::perms::owner_all);
}

TEST(Settings, ReadOnlyFileSystem)
{
    // Nobody, not even root, can write here.
    EXPECT_THROW(app::writeSettings("/proc/rekindle/settings.json", {}), core::Error);
}

TEST(Settings, ALinkStaysALink)
{
    const TemporaryFolder folder;
    fs::create_directory(folder / "elsewhere");
    app::writeSettings(folder / "elsewhere" / "mine.json", {});
    fs::create_symlink(folder / "elsewhere" / "mine.json", folder / "settings.json");
    const Settings s = someSettings();
    app::writeSettings(folder / "settings.json", s);
    EXPECT_TRUE(fs::is_symlink(folder / "settings.json"));
    EXPECT_EQ(read(folder / "elsewhere" / "mine.json"), lasting(s));
}

TEST(Settings, NamesThatAreNotTextAreLeftOut)
{
    const TemporaryFolder folder;
    Settings s;
    s.recentFiles = {"/good.glb", "/b\xff\xfe.glb"};
    s.presets = {{"b\xff", {}}};
    s.cameras = {{"h", "not json"}, {"\xff", "[1]"}};
    app::writeSettings(folder / "settings.json", s);
    Settings expected;
    expected.recentFiles = {"/good.glb"};
    EXPECT_EQ(read(folder / "settings.json"), expected);
}

TEST(Settings, WhereTheyAreKept)
{
    {
        const EnvironmentVariable xdg("XDG_CONFIG_HOME", "/c"), home("HOME", "/h");
        EXPECT_EQ(app::settingsFile(), "/c/rekindle/settings.json");
    }
    for (const char* notAbsolute : {static_cast<const char*>(nullptr), "", "c", "./c"}) {
        const EnvironmentVariable xdg("XDG_CONFIG_HOME", notAbsolute), home("HOME", "/h");
        EXPECT_EQ(app::settingsFile(), "/h/.config/rekindle/settings.json");
    }
    for (const char* nowhere : {static_cast<const char*>(nullptr), "", "h"}) {
        const EnvironmentVariable xdg("XDG_CONFIG_HOME", nullptr), home("HOME", nowhere);
        EXPECT_EQ(app::settingsFile(), "");
    }
}

TEST(Settings, OfTwoViewersEachKeepsWhatItHasChanged)
{
    const TemporaryFolder folder;
    const fs::path file = folder / "settings.json";
    Settings base;
    base.recentFiles = {"/a.glb"};
    base.presets = {{"old", core::PathParams{.maxDepth = 3}}};
    base.cameras = {{"aa", R"([{"name":"door"}])"}};
    app::writeSettings(file, base);
    const Settings known = read(file);
    Settings one = known, two = known;
    one.view.movingRate = 12;
    one.panels.plot = !one.panels.plot;
    one.keepParams(core::PathParams{.maxDepth = 5});
    one.addRecent("/one.glb");
    one.presets.push_back({"mine", core::PathParams{.maxDepth = 4}});
    one.cameras["bb"] = R"([{"name":"window"}])";
    two.view.movingRate = 14;
    two.panels.opacity = 0.5f;
    two.keepParams(core::PathParams{});  // as they are by default
    two.addRecent("/two.glb");
    two.addRecent("/a.glb");
    two.presets.clear();
    two.cameras.clear();
    app::writeChanges(file, known, one);
    app::writeChanges(file, known, two);
    const Settings both = read(file);
    EXPECT_EQ(both.view.movingRate, 14) << "the last who changed it";
    EXPECT_EQ(both.panels.plot, one.panels.plot);
    EXPECT_EQ(both.panels.opacity, 0.5f);
    EXPECT_EQ(both.paramsOf("path").as<core::PathParams>().maxDepth, 5u);
    EXPECT_EQ(both.recentFiles, (std::vector<std::string>{"/a.glb", "/two.glb", "/one.glb"}));
    ASSERT_EQ(both.presets.size(), 1u);
    EXPECT_EQ(both.presets[0].name, "mine");
    EXPECT_EQ(both.cameras, (std::map<std::string, std::string>{{"bb", one.cameras["bb"]}}));

    const auto before = fs::last_write_time(file);
    app::writeChanges(file, two, two);
    EXPECT_EQ(fs::last_write_time(file), before) << "nothing has changed";
    fs::remove(file);
    app::writeChanges(file, two, two);
    EXPECT_EQ(read(file), lasting(two)) << "who has the only copy writes it";
}

TEST(Settings, RecentFilesComeFirstOnce)
{
    Settings s;
    for (int i = 0; i < 20; ++i) s.addRecent("/f" + std::to_string(i) + ".glb");
    ASSERT_EQ(s.recentFiles.size(), 12u);
    EXPECT_EQ(s.recentFiles.front(), "/f19.glb");
    EXPECT_EQ(s.recentFiles.back(), "/f8.glb");
    s.addRecent("/a/../f10.glb");
    EXPECT_EQ(s.recentFiles.size(), 12u);
    EXPECT_EQ(s.recentFiles.front(), "/f10.glb");
    s.addRecent("room.glb");
    EXPECT_EQ(s.recentFiles.front(), (fs::current_path() / "room.glb").string());
}

TEST(Settings, PresetsOfMethodsAreValidAndTold)
{
    std::set<std::string> names;  // of all methods: they are chosen by name alone
    for (const core::MethodInfo& method : core::methods()) {
        for (const core::MethodPreset& preset : method.presets) {
            EXPECT_TRUE(names.insert(preset.name).second) << preset.name;
            EXPECT_STRNE(preset.help, "");
            EXPECT_EQ(preset.params.id(), method.id());
            core::AnyParams back = method.defaults;
            EXPECT_TRUE(app::readParams(app::paramsJson(preset.params), back, preset.name).empty());
            EXPECT_EQ(back, preset.params);
        }
    }
    EXPECT_TRUE(names.count("balanced"));
}

/// Files of versions with one method keep its parameters under its name.
TEST(Settings, ParametersOfTheOnlyMethodThereWasAreRead)
{
    const TemporaryFolder folder;
    const fs::path file = folder / "settings.json";
    core::writeFile(file, R"({"version": 1, "path": {"max-depth": 5},
                             "presets": [{"name": "mine", "path": {"max-depth": 7}},
                                         {"name": "of a later version", "method": "magic"}]})");
    const Settings s = read(file);
    EXPECT_EQ(s.paramsOf("path"), core::AnyParams(core::PathParams{.maxDepth = 5}));
    ASSERT_EQ(s.presets.size(), 1u);
    EXPECT_EQ(s.presets[0].params, core::AnyParams(core::PathParams{.maxDepth = 7}));
}

TEST(ParamsJson, ProblemsAreNamed)
{
    core::PathParams p;
    const auto json = nlohmann::ordered_json::parse(
        R"({"max-depth": 5000, "roulette-depth": 3, "sead": 1, "sampler": "sobool", "clamp-indirect": "2"})");
    std::string all;
    int missing = 0;
    for (const app::ParamProblem& problem : app::readParams(json, p, "x"))
        if (problem.kind == app::ParamProblem::missing)
            ++missing;
        else
            all += problem.text + '\n';
    EXPECT_EQ(missing, 4);  // seed, strategy, kernel, sky
    EXPECT_NE(all.find("x: max-depth: 5000 is not a whole number from 0 to 4096"),
              std::string::npos)
        << all;
    EXPECT_NE(all.find("did you mean sobol"), std::string::npos) << all;
    EXPECT_NE(all.find("x: there is no sead; did you mean seed?"), std::string::npos) << all;
    EXPECT_NE(all.find("clamp-indirect"), std::string::npos) << all;
    core::PathParams expected;
    expected.rouletteDepth = 3;
    EXPECT_EQ(p, expected);
    EXPECT_EQ(app::readParams(nlohmann::ordered_json(3), p, "x").size(), 1u);
}

}  // namespace
