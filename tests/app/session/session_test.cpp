// The viewer without its window: what loads, what an edit restarts and what not, references,
// saving, random walks.
#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <thread>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/base/json_file.h"
#include "app/session/actions.h"
#include "app/session/replay.h"
#include "app/session/session.h"
#include "app/view/random_walk.h"
#include "core/base/check.h"
#include "core/base/output_file.h"
#include "core/image/metrics.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/session/session_steps.h"

namespace {

using namespace tests;

TEST(Session, LoadsASceneAndShowsItFromItsCamera)
{
    Session session(options("cornell-diffuse.gltf"));
    EXPECT_EQ(session.document(), nullptr);
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    EXPECT_EQ(session.document()->file.filename(), "cornell-diffuse.gltf");
    EXPECT_EQ(session.navigation.camera(), session.document()->world->cameras.front());
    EXPECT_EQ(session.picture()->mean.width, kArea.x);
    ASSERT_TRUE(until(session, [&] { return session.picture()->samples >= 8; }));
    EXPECT_TRUE(session.picture()->counters.clean());
}

TEST(Session, ABrokenFileLeavesTheSceneAsItIs)
{
    const tests::TemporaryFolder folder;
    std::ofstream(folder / "broken.gltf") << "{\"asset\":";
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    const auto world = session.document()->world;
    const uint64_t generation = session.generation();
    act(session, "load", {{"file", (folder / "broken.gltf").string()}});
    ASSERT_TRUE(until(session, [&] { return told(session, "broken.gltf"); }));
    EXPECT_EQ(session.document()->world, world);
    EXPECT_EQ(session.generation(), generation) << "nothing was to be rendered anew";
    act(session, "load", {{"file", (folder / "missing.glb").string()}});
    ASSERT_TRUE(until(session, [&] { return told(session, "missing.glb"); }));
    EXPECT_EQ(session.document()->world, world);
}

TEST(Session, BehindAFirstSceneThatIsNoneStandsTheBuiltInOne)
{
    app::SessionOptions o = options("cornel-difuse.gltf");
    o.builtIn = true;
    Session session(o);
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    EXPECT_TRUE(told(session, "cornell-diffuse.gltf?")) << "the nearest name is proposed";
    EXPECT_EQ(session.document()->file.filename(), "cornell-diffuse.gltf");
}

TEST(Session, OnlyWhatAnEditInvalidatesStartsAnew)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(
        until(session, [&] { return settled(session) && session.picture()->samples >= 4; }));
    uint64_t samples = session.picture()->samples;
    const auto continues = [&](const std::string& name, const ActionJson& value) {
        samples = session.picture()->samples;
        act(session, "set", {{"name", name}, {"value", value}});
        EXPECT_TRUE(until(session, [&] {
            return settled(session) && session.picture()->samples > samples;
        })) << name;
        return session.picture()->seconds > 0 && session.picture()->samples > samples;
    };
    EXPECT_TRUE(continues("exposure", 2));
    EXPECT_TRUE(continues("tone", "aces"));
    EXPECT_TRUE(continues("show", "depth"));
    EXPECT_TRUE(continues("spp-limit", 1000000));
    EXPECT_TRUE(continues("show", "deviation"));
    EXPECT_NE(session.picture()->variance, nullptr);

    for (const auto& [name, value] : std::vector<std::pair<std::string, ActionJson>>{
             {"max-depth", 3}, {"sampler", "independent"}, {"seed", 9}, {"strategy", "bsdf"}}) {
        ASSERT_TRUE(
            until(session, [&] { return settled(session) && session.picture()->samples >= 40; }));
        act(session, "set", {{"name", "spp-limit"}, {"value", 2}});
        act(session, "set", {{"name", name}, {"value", value}});
        ASSERT_TRUE(
            until(session, [&] { return settled(session) && session.picture()->finished; }));
        EXPECT_EQ(session.picture()->samples, 2u) << name << " did not start the picture anew";
        act(session, "set", {{"name", "spp-limit"}, {"value", 0}});
    }
    act(session, "set", {{"name", "spp-limit"}, {"value", 3}});
    act(session, "restart");
    ASSERT_TRUE(until(session, [&] { return settled(session) && session.picture()->finished; }));
    EXPECT_EQ(session.picture()->samples, 3u);
}

TEST(Session, MotionGivesPreviewsAndRestGivesTheFullPicture)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    const core::Camera before = session.navigation.camera();
    bool preview = false;
    for (int i = 0; i < 200 && !preview; ++i) {
        act(session, "orbit", {{"dx", 0.01}, {"dy", 0}});
        session.update(0.01, kArea);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        preview = session.picture()->preview;
    }
    EXPECT_TRUE(preview);
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    EXPECT_NE(session.picture()->camera, before);
    EXPECT_EQ(session.picture()->camera, session.navigation.camera());
    EXPECT_EQ(session.picture()->mean.width, kArea.x);
}

TEST(Session, AReferenceCountsForItsViewOnly)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "reference", {{"spp", 64}});
    ASSERT_TRUE(
        until(session, [&] { return session.reference() && session.reference()->samples == 64; }));
    EXPECT_TRUE(session.referenceFits());
    ASSERT_TRUE(until(session, [&] {
        return settled(session) && !session.picture()->curve.empty() &&
               session.picture()->curve.back().rmse > 0;
    }));
    const double rmse = session.picture()->curve.back().rmse;
    EXPECT_NEAR(rmse, core::imageErrors(session.picture()->mean, session.reference()->mean).rmse,
                0.5 * rmse);

    const std::string camera = session.cameraText();
    act(session, "orbit", {{"dx", 0.2}, {"dy", 0}});
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    EXPECT_FALSE(session.referenceFits());
    act(session, "paste-camera", {{"json", camera}});
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    EXPECT_TRUE(session.referenceFits()) << "back where it was made";
    act(session, "drop-reference");
    session.update(0.01, kArea);
    EXPECT_EQ(session.reference(), nullptr);
}

TEST(Session, SavesAPictureThatReplaysToTheSameBits)
{
    const tests::TemporaryFolder folder;
    const fs::path file = folder / "kept.exr";
    core::Image saved;
    {
        Session session(options("cornell-glossy.gltf"));
        act(session, "set", {{"name", "spp-limit"}, {"value", 5}});
        act(session, "set", {{"name", "max-depth"}, {"value", 4}});
        ASSERT_TRUE(until(session, [&] { return settled(session); }));
        act(session, "orbit", {{"dx", 0.1}, {"dy", 0.05}});
        ASSERT_TRUE(
            until(session, [&] { return settled(session) && session.picture()->finished; }));
        act(session, "save", {{"file", file.string()}});
        ASSERT_TRUE(until(session, [&] { return told(session, "kept.exr: saved"); }));
        const core::ImageFile image = core::readExr(file);
        saved = image.layer("");
        EXPECT_TRUE(image.hasLayer("variance"));
        EXPECT_EQ(saved.pixels, session.picture()->mean.pixels);
    }
    Session session(options(""));
    act(session, "replay", {{"file", file.string()}});
    ASSERT_TRUE(until(session, [&] { return settled(session) && session.picture()->finished; }));
    EXPECT_EQ(session.render.method.as<core::PathParams>().maxDepth, 4u);
    EXPECT_EQ(session.picture()->samples, 5u);
    EXPECT_EQ(session.picture()->mean.pixels, saved.pixels)
        << "a saved picture tells how to render it again";
}

/// After a move a method that keeps samples begins with what no file holds: file and replay say so.
TEST(Session, APictureThatKeptSamplesSaysThatItsNoiseWillNotComeBack)
{
    const tests::TemporaryFolder folder;
    const std::string words = "with the same light, but not with the same noise";
    Session session(options("cornell-diffuse.gltf"));
    act(session, "set", {{"name", "method"}, {"value", "reuse"}});
    act(session, "set", {{"name", "spp-limit"}, {"value", 2}});
    const auto saved = [&](const std::string& name) {
        const fs::path file = folder / name;
        EXPECT_TRUE(
            until(session, [&] { return settled(session) && session.picture()->finished; }));
        act(session, "save", {{"file", file.string()}});
        EXPECT_TRUE(until(session, [&] { return told(session, name + ": saved"); }));
        return file;
    };
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "orbit", {{"dx", 0.1}, {"dy", 0.05}});
    const fs::path moved = saved("moved.exr");
    EXPECT_TRUE(app::readReplay(moved).follows);
    act(session, "set", {{"name", "method"}, {"value", "path"}});
    const fs::path plain = saved("plain.exr");
    EXPECT_FALSE(app::readReplay(plain).follows);
    act(session, "replay", {{"file", plain.string()}});
    ASSERT_TRUE(until(session, [&] { return settled(session) && session.picture()->finished; }));
    EXPECT_FALSE(told(session, words));
    act(session, "replay", {{"file", moved.string()}});
    ASSERT_TRUE(until(session, [&] { return told(session, words); }));
}

TEST(Session, ComparesAfterEqualTimes)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "equal-time",
        {{"seconds", 0.2}, {"a", {{"max-depth", 1}}}, {"b", {{"sampler", "independent"}}}});
    ASSERT_TRUE(until(session, [&] { return session.comparing; }));
    const auto &a = session.slots[0].picture, &b = session.slots[1].picture;
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->params.method.as<core::PathParams>().maxDepth, 1u);
    EXPECT_EQ(b->params.method.as<core::PathParams>().sampler, core::SamplerKind::independent);
    EXPECT_EQ(b->params.method.as<core::PathParams>().maxDepth, core::PathParams().maxDepth);
    EXPECT_GE(a->seconds, 0.2);
    EXPECT_GE(b->seconds, 0.2);
    EXPECT_EQ(session.render.method, core::AnyParams())
        << "the parameters in the panel are the person's";
}

TEST(Session, PlaysTheScenesAnimation)
{
    Session session(options("animated.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    ASSERT_GT(session.player.duration, 0);
    const auto before = session.document()->world;
    act(session, "animation", {{"time", 0.5 * session.player.duration}});
    ASSERT_TRUE(until(session, [&] {
        return session.document()->time == 0.5 * session.player.duration && settled(session);
    }));
    EXPECT_NE(session.document()->world, before);
    EXPECT_NE(session.document()->world->positions, before->positions);
    EXPECT_EQ(session.document()->world->placement.centre, before->placement.centre)
        << "the camera stays where it is";
    act(session, "animation", {{"play", true}});
    const double time = session.document()->time;
    ASSERT_TRUE(until(session, [&] { return session.document()->time != time; }));
    act(session, "animation", {{"play", false}});
    EXPECT_FALSE(session.player.playing);
}

TEST(Session, KeepsSettingsAndCamerasBetweenRuns)
{
    const tests::TemporaryFolder folder;
    app::SessionOptions o = options("cornell-diffuse.gltf");
    o.settings = folder / "settings.json";
    core::Camera kept;
    {
        Session session(o);
        ASSERT_TRUE(until(session, [&] { return settled(session); }));
        act(session, "dolly", {{"steps", 2}});
        act(session, "save-camera", {{"name", "near"}});
        kept = session.navigation.camera();
        act(session, "set", {{"name", "exposure"}, {"value", 1.5}});
        act(session, "set", {{"name", "frame-limit"}, {"value", 30}});
        act(session, "set", {{"name", "max-depth"}, {"value", 5}});
    }
    Session session(o);
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    EXPECT_EQ(session.settings.view.exposure, 0) << "it was that picture's";
    EXPECT_EQ(session.settings.view.frameLimit, 30);
    EXPECT_EQ(session.render.method.as<core::PathParams>().maxDepth, 5u);
    ASSERT_EQ(session.savedCameras().size(), 1u);
    EXPECT_EQ(session.savedCameras()[0].name, "near");
    act(session, "use-saved-camera", {{"index", 0}});
    EXPECT_LT(glm::distance(session.navigation.camera().position, kept.position), 1e-9);
    ASSERT_FALSE(session.settings.recentFiles.empty());
    EXPECT_EQ(fs::path(session.settings.recentFiles[0]).filename(), "cornell-diffuse.gltf");
}

TEST(Session, AKeptViewThatCannotBeReadStaysAndTakesNoOtherAlong)
{
    const tests::TemporaryFolder folder;
    app::SessionOptions o = options("cornell-diffuse.gltf");
    o.settings = folder / "settings.json";
    const auto kept = [&] { return app::readJson(o.settings)["cameras"].begin().value(); };
    {
        Session session(o);
        ASSERT_TRUE(until(session, [&] { return settled(session); }));
        for (const char* name : {"one", "two", "three"})
            act(session, "save-camera", {{"name", name}});
    }
    ActionJson json = app::readJson(o.settings);
    json["cameras"].begin().value()[1]["yfov"] = 1e9;
    json["cameras"].begin().value()[1]["of a newer version"] = true;
    const ActionJson unreadable = json["cameras"].begin().value()[1];
    core::writeFile(o.settings, json.dump());
    const auto keeps = [&] {
        const ActionJson list = kept();
        return std::count(list.begin(), list.end(), unreadable) == 1;
    };
    {
        Session session(o);
        ASSERT_TRUE(until(session, [&] { return settled(session); }));
        EXPECT_TRUE(told(session, "kept view cannot be read"));
        ASSERT_EQ(session.savedCameras().size(), 2u);
        EXPECT_EQ(session.savedCameras()[1].name, "three");
    }
    EXPECT_EQ(kept().size(), 3u);
    EXPECT_TRUE(keeps());
    {
        Session session(o);
        ASSERT_TRUE(until(session, [&] { return settled(session); }));
        for (int i = 0; i < 2; ++i) session.removeSavedCamera(0);
    }
    EXPECT_EQ(kept().size(), 1u);
    EXPECT_TRUE(keeps());
}

TEST(Session, TheListOfKeysIsClosedAtTheStart)
{
    const tests::TemporaryFolder folder;
    app::Settings kept;
    kept.panels.help = kept.panels.log = true;
    app::SessionOptions o = options("");
    o.settings = folder / "settings.json";
    app::writeSettings(o.settings, kept);
    const Session session(o);
    EXPECT_FALSE(session.settings.panels.help);
    EXPECT_TRUE(session.settings.panels.log);
}

TEST(Session, ExportsAPath)
{
    const tests::TemporaryFolder folder;
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "export-path", {{"file", (folder / "frame-%04d.png").string()}, {"spp", 1}});
    session.update(0.01, kArea);
    EXPECT_TRUE(told(session, "add keys first"));
    act(session, "add-key", {{"frame", 0}});
    act(session, "orbit", {{"dx", 0.1}, {"dy", 0}});
    act(session, "add-key", {{"frame", 2}});
    act(session, "export-path", {{"file", (folder / "frame-%04d.png").string()}, {"spp", 1}});
    ASSERT_TRUE(until(session, [&] { return told(session, "export frame-%04d.png: done"); }));
    EXPECT_EQ(folder.count(), 3u);
    EXPECT_TRUE(fs::exists(folder / "frame-0002.png"));
}

TEST(Session, ExportsAPathWithTheMethodShown)
{
    const tests::TemporaryFolder folder;
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "set", {{"name", "method"}, {"value", "reuse"}});
    act(session, "set", {{"name", "reuse"}, {"value", "mis"}});
    act(session, "set", {{"name", "seed"}, {"value", 5}});
    act(session, "add-key", {{"frame", 0}});
    act(session, "orbit", {{"dx", 0.02}, {"dy", 0}});
    act(session, "add-key", {{"frame", 3}});
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "export-path", {{"file", (folder / "frame-%d.exr").string()}, {"spp", 1}});
    ASSERT_TRUE(until(session, [&] { return told(session, "export frame-%d.exr: done"); }));

    core::ReuseParams params;
    params.reuse = core::ReuseStrategy::mis;
    params.seed = 5;
    const core::ImageFile last = core::readExr(folder / "frame-3.exr");
    const core::Image& picture = last.layer("");
    const auto renderer = core::makeRenderer("reuse");
    renderer->setWorld(session.document()->world, {});
    const auto flown = [&](core::Start start) {
        for (int i = 0; i <= 3; ++i) {
            renderer->setView({session.track.at(i), {picture.width, picture.height}, params},
                              i == 0 ? core::Start::anew : start);
            renderer->advance({.samples = 1}, {});
        }
        return renderer->read(core::Reading::mean).mean.pixels;
    };
    EXPECT_EQ(picture.pixels, flown(core::Start::moved));
    EXPECT_NE(picture.pixels, flown(core::Start::anew));
    EXPECT_TRUE(last.metadata.contains("follows"));
    EXPECT_FALSE(core::readExr(folder / "frame-0.exr").metadata.contains("follows"));
}

TEST(Session, WrongActionsAreRefusedWithTheirNames)
{
    Session session(options(""));
    const auto message = [&](const std::string& name, const ActionJson& arguments) -> std::string {
        try {
            act(session, name, arguments);
        } catch (const core::Error& error) {
            EXPECT_EQ(error.code(), core::ExitCode::commandLine);
            return error.what();
        }
        return "nothing";
    };
    EXPECT_NE(message("paus", {}).find("did you mean pause?"), std::string::npos)
        << message("paus", {});
    EXPECT_NE(message("orbit", {{"dx", "far"}}).find("dx"), std::string::npos);
    EXPECT_NE(message("set", {{"name", "max-dept"}, {"value", 1}}).find("max-depth"),
              std::string::npos);
    EXPECT_NE(message("set", {{"name", "max-depth"}, {"value", -1}}).find("from 0 to 4096"),
              std::string::npos);
    EXPECT_NE(message("set", {{"name", "sampler"}, {"value", "halton"}}).find("sobol"),
              std::string::npos);
}

/// Ten times a second the input changes: no failure, no deadlock, no picture of another scene.
void walk(int steps, uint64_t seed)
{
    const tests::TemporaryFolder folder;
    std::ofstream(folder / "broken.gltf") << "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{}]}";
    app::SessionOptions o = options("cornell-diffuse.gltf");
    Session session(o);
    app::RandomWalk walk(seed,
                         {kAssets / "cornell-diffuse.gltf", kAssets / "animated.gltf",
                          kAssets / "lights.gltf", folder / "broken.gltf"},
                         folder.path());
    app::AppRequests requests;
    double longest = 0;
    for (int i = 0; i < steps; ++i) {
        const auto start = std::chrono::steady_clock::now();
        walk.step(session, requests);
        ASSERT_FALSE(requests.quit) << walk.last();
        session.update(0.02, kArea);
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
        longest = std::max(longest, took.count());
        const auto picture = session.picture();
        if (picture) {
            ASSERT_LE(picture->generation, session.generation()) << walk.last();
            ASSERT_TRUE(picture->counters.clean()) << walk.last();
        }
        // Sometimes long enough for something to finish.
        if (i % 4 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(i % 7));
    }
    EXPECT_LT(longest, 5.0) << "something waited: the window would have stood still";
    session.settings.view = {};
    session.cancel();
    act(session, "load", {{"file", (kAssets / "cornell-diffuse.gltf").string()}});
    session.paused = false;
    session.render = o.render;
    EXPECT_TRUE(until(session, [&] {
        return settled(session) && session.document()->file.filename() == "cornell-diffuse.gltf";
    })) << "after the walk it works as before";
}

TEST(Session, SurvivesARandomWalk)
{
    walk(1500, 1);
}

TEST(SlowSession, SurvivesTenThousandRandomActions)
{
    walk(10000, 2);
}

}  // namespace
