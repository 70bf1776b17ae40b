// What is saved is what was on show when it was asked for: whatever moves, is loaded or ends in the
// meantime; and what else a person does while work of another kind is under way.
#include <fstream>
#include <set>

#include "app/base/files.h"
#include "app/session/pending_saves.h"
#include "app/session/replay.h"
#include "core/base/output_file.h"
#include "core/image/metrics.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/session/pretender.h"
#include "tests/support/session/session_steps.h"

namespace {

using namespace tests;

struct SessionSaves : testing::Test {
    /// Before anything that was asked for has been updated.
    void save(Session& session, const char* name)
    {
        act(session, "save", {{"file", (folder / name).string()}});
    }
    core::ImageFile saved(const char* name) const { return core::readExr(folder / name); }
    static std::string valueOf(const core::ImageFile& image, const char* key)
    {
        const auto found = image.metadata.find(key);
        return found == image.metadata.end() ? "" : found->second;
    }
    /// A session whose samples last as long as the book says.
    app::SessionOptions pretended()
    {
        app::SessionOptions o = options("cornell-diffuse.gltf");
        o.factory = [this](const app::RenderParams&, bool) {
            return std::make_unique<Pretender>(book);
        };
        return o;
    }

    TemporaryFolder folder;
    Book book;
};

TEST_F(SessionSaves, ACameraPathReplacesNoFileUnasked)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "add-key");
    EXPECT_TRUE(told(session, "the camera path has 1 key"));
    const auto savePath = [&](const char* name, bool replace) {
        act(session, "save-path", {{"file", (folder / name).string()}, {"replace", replace}});
    };
    savePath("scene.gltf", true);
    EXPECT_TRUE(told(session, "ends in .json"));
    EXPECT_FALSE(fs::exists(folder / "scene.gltf"));

    core::writeFile(folder / "old.json", "precious");
    savePath("old.json", false);
    EXPECT_TRUE(told(session, "is there already"));
    EXPECT_EQ(app::readText(folder / "old.json"), "precious");
    savePath("old.json", true);
    const std::string one = app::readText(folder / "old.json");
    EXPECT_NE(one, "precious");
    act(session, "add-key");
    savePath("old.json", false);
    EXPECT_NE(app::readText(folder / "old.json"), one) << "its own file is no other one's";
}

TEST_F(SessionSaves, WhatWasOnShowIsSavedThoughTheCameraMoves)
{
    Session session(options("cornell-diffuse.gltf"));
    act(session, "set", {{"name", "spp-limit"}, {"value", 4}});
    ASSERT_TRUE(until(session, [&] { return settled(session) && session.picture()->finished; }));
    const core::Image mean = session.picture()->mean;
    save(session, "a.exr");
    act(session, "orbit", {{"dx", 0.3}});
    ASSERT_TRUE(until(session, [&] { return told(session, "a.exr: saved"); }));
    EXPECT_EQ(valueOf(saved("a.exr"), "spp"), "4");
    EXPECT_EQ(saved("a.exr").layer("").pixels, mean.pixels);
}

TEST_F(SessionSaves, WhatWasOnShowIsSavedThoughAnotherSceneComes)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    const std::string hash = session.document()->world->scene->hash;
    session.load(kAssets / "hall.gltf");
    save(session, "a.exr");
    ASSERT_TRUE(until(session, [&] { return told(session, "a.exr: saved"); }));
    ASSERT_TRUE(until(session, [&] {
        return settled(session) && session.document()->file.filename() == "hall.gltf";
    }));
    EXPECT_EQ(valueOf(saved("a.exr"), "scene_hash"), hash);
    EXPECT_NE(session.document()->world->scene->hash, hash);
}

TEST_F(SessionSaves, NoneOfSeveralIsLost)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    save(session, "a.exr");
    save(session, "b.png");
    EXPECT_TRUE(session.saving());
    ASSERT_TRUE(until(session, [&] { return !session.saving(); }));
    EXPECT_TRUE(told(session, "a.exr: saved") && told(session, "b.png: saved"));
    EXPECT_FALSE(session.saveFailed());
    EXPECT_TRUE(saved("a.exr").hasLayer("variance"));
    EXPECT_TRUE(saved("a.exr").hasLayer("depth"));
    save(session, "none/c.exr");
    ASSERT_TRUE(until(session, [&] { return !session.saving(); }));
    EXPECT_TRUE(session.saveFailed());
}

TEST_F(SessionSaves, TheEndOfTheProgramWritesWholeSamples)
{
    {
        Session session(pretended());
        ASSERT_TRUE(until(session, [&] { return settled(session); }));
        book.set(&Book::secondsPerPixel, 1.0 / (kArea.x * kArea.y));
        session.restart();
        // The second sample is under way.
        ASSERT_TRUE(until(session, [&] {
            return settled(session) && session.picture()->samples == 1 &&
                   session.picture()->fraction > 0;
        }));
        save(session, "a.exr");
    }
    EXPECT_EQ(valueOf(saved("a.exr"), "spp"), "1");
    {
        Session session(pretended());
        ASSERT_TRUE(until(session, [&] { return session.picture() != nullptr; }));
        book.set(&Book::secondsPerPixel, 1.0);
        act(session, "orbit", {{"dx", 0.3}});
        session.update(0.01, kArea);
        save(session, "b.exr");
        session.load(kAssets / "hall.gltf");
        ASSERT_TRUE(until(session, [&] { return told(session, "b.exr: not saved"); }));
    }
    EXPECT_FALSE(fs::exists(folder / "b.exr"));
}

TEST_F(SessionSaves, SavingAndQuittingWaitsForTheFile)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    app::AppRequests requests;
    app::runAction("save-and-quit", session, requests, {{"file", (folder / "a.exr").string()}});
    EXPECT_FALSE(requests.quit);
    EXPECT_TRUE(requests.quitWhenSaved);
    ASSERT_TRUE(until(session, [&] { return !session.saving(); }));
    EXPECT_TRUE(saved("a.exr").hasLayer("variance"));
}

TEST_F(SessionSaves, AReferenceTakesTheThreadFromNoExport)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    for (const double frame : {0.0, 4000.0}) act(session, "add-key", {{"frame", frame}});
    act(session, "export-path", {{"file", (folder / "out/f-%04d.png").string()}, {"spp", 1000000}});
    ASSERT_TRUE(until(session, [&] { return session.coreThread().active(); })) << "the folder";
    act(session, "reference", {{"spp", 2}});
    EXPECT_TRUE(told(session, "is under way"));
    EXPECT_TRUE(session.coreThread().name.starts_with("export"));
    act(session, "cancel");
    ASSERT_TRUE(until(session, [&] { return !session.coreThread().active(); }));
}

TEST_F(SessionSaves, PicturesThatAreKeptHaveTheirVarianceSoon)
{
    Session session(options("cornell-diffuse.gltf"));
    session.settings.sections.compare = false;
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    ASSERT_EQ(session.picture()->variance, nullptr);
    act(session, "store-a");
    ASSERT_TRUE(until(session, [&] { return session.slots[0].picture->variance != nullptr; }));
    act(session, "set", {{"name", "max-depth"}, {"value", 2}});
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "store-b");
    ASSERT_TRUE(until(session, [&] { return session.comparison() != nullptr; }));
    EXPECT_EQ(core::findParam<uint32_t>(session.slots[0].picture->params.method, "max-depth")[0],
              8u);
}

/// As after the loss of a device, which begins the picture anew.
TEST(PendingSaves, FewerSamplesOfTheSameViewReplaceNone)
{
    app::RenderRequest view;
    view.world = std::make_shared<core::World>();
    const auto sampled = [&](uint64_t samples) {
        auto picture = std::make_shared<app::Picture>();
        picture->world = view.world;
        picture->samples = samples;
        return picture;
    };
    app::PendingSaves saves;
    saves.add({{}, view, 1});
    for (const uint64_t samples : {5u, 10u, 1u}) saves.offer(sampled(samples));
    auto other = sampled(100);
    other->restarts = 1;
    saves.offer(other);
    const std::vector<app::SaveItem> items = saves.takeAll();
    ASSERT_EQ(items.size(), 1u);
    EXPECT_EQ(items[0].picture->samples, 10u);
}

TEST_F(SessionSaves, EqualTimeEndsWhereTheViewChanges)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "orbit", {{"dx", 0.3}});
    ASSERT_TRUE(until(session, [&] { return settled(session) && !session.isMoving(); }));
    session.compareEqualTime(session.render, session.render, 60);
    session.update(0.01, kArea);
    ASSERT_TRUE(session.equalTime().running());
    act(session, "home");
    session.update(0.01, kArea);
    EXPECT_FALSE(session.equalTime().running());
    EXPECT_TRUE(told(session, "the view has changed"));
}

TEST_F(SessionSaves, EscStopsAnAnimationAndLeavesNothingElse)
{
    Session session(options("animated.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "animation", {{"play", true}});
    for (int i = 0; i < 20; ++i) session.update(0.01, kArea);
    app::AppRequests requests;
    app::escapeFrom(session, requests);
    EXPECT_FALSE(session.player.playing);
    EXPECT_FALSE(requests.leave);
    for (int i = 0; i < 20; ++i) session.update(0.01, kArea);
    EXPECT_FALSE(told(session, "pose"));
}

TEST_F(SessionSaves, EscCancelsWhatWasBegunLastAndNothingElse)
{
    Session session(pretended());
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "reference", {{"spp", 1000000}});
    ASSERT_TRUE(until(session, [&] { return session.coreThread().active(); }));
    session.compareEqualTime(session.render, session.render, 60);
    session.update(0.01, kArea);
    EXPECT_EQ(session.works(), (std::vector{app::Work::equalTime, app::Work::background}));
    app::AppRequests requests;
    app::escapeFrom(session, requests);
    EXPECT_FALSE(session.equalTime().running());
    EXPECT_TRUE(told(session, "equal time: cancelled"));
    EXPECT_TRUE(session.coreThread().active()) << "it was begun before";
    session.update(0.01, kArea);
    app::escapeFrom(session, requests);
    EXPECT_FALSE(session.coreThread().active());
    session.update(0.01, kArea);
    EXPECT_TRUE(told(session, "reference: cancelled"));
    EXPECT_FALSE(requests.leave);
    app::escapeFrom(session, requests);
    EXPECT_TRUE(requests.leave) << "nothing runs";
}

TEST_F(SessionSaves, EachWorkIsCancelledByItsName)
{
    Session session(pretended());
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    session.compareEqualTime(session.render, session.render, 60);
    session.update(0.01, kArea);
    act(session, "reference", {{"spp", 1000000}});
    EXPECT_EQ(session.works().front(), app::Work::background) << "also before it has been seen";
    act(session, "cancel", {{"what", "equal-time"}});
    EXPECT_FALSE(session.equalTime().running());
    EXPECT_TRUE(session.coreThread().active());
    act(session, "cancel", {{"what", "load"}});  // does not run
    EXPECT_TRUE(session.coreThread().active());
    EXPECT_THROW(act(session, "cancel", {{"what", "lunch"}}), core::Error);
    act(session, "cancel");
    EXPECT_TRUE(session.works().empty());
}

TEST_F(SessionSaves, ASceneIsThereOnlyOnceItIsShown)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    EXPECT_TRUE(session.settled());
    session.load(kAssets / "hall.gltf");
    while (session.loading().active()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_FALSE(session.settled());
    session.update(0.01, kArea);
    EXPECT_TRUE(session.settled());
    EXPECT_EQ(session.document()->file.filename(), "hall.gltf");
}

TEST_F(SessionSaves, AnotherEnvironmentLeavesTheViewAndAFailureEverything)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    EXPECT_EQ(session.document()->environment, "auto");
    EXPECT_FALSE(session.document()->world->scene->environment);
    const core::Camera home = session.navigation.camera();
    act(session, "orbit", {{"dx", 0.2}});
    const core::Camera camera = session.navigation.camera();
    act(session, "add-key");
    act(session, "save-camera", {{"name", "aside"}});
    act(session, "environment", {{"what", (folder / "none.exr").string()}});
    ASSERT_TRUE(until(session, [&] { return told(session, "none.exr"); }));
    EXPECT_EQ(session.document()->environment, "auto");
    act(session, "environment", {{"what", "plain"}});
    ASSERT_TRUE(until(session, [&] { return session.document()->environment == "plain"; }));
    EXPECT_TRUE(session.document()->world->scene->environment);
    EXPECT_EQ(session.navigation.camera(), camera);
    EXPECT_EQ(session.homeCamera(), home);
    EXPECT_EQ(session.track.keys().size(), 1u);
    ASSERT_EQ(session.savedCameras().size(), 1u);
    act(session, "previous-view");
    EXPECT_EQ(session.navigation.camera(), home) << "where one came from";
    act(session, "next-view");
    session.load(kAssets / "hall.gltf");
    ASSERT_TRUE(until(session, [&] { return session.document()->file.filename() == "hall.gltf"; }));
    EXPECT_EQ(session.document()->environment, "plain");
    EXPECT_NE(session.navigation.camera(), camera);
    EXPECT_TRUE(session.track.empty() && session.savedCameras().empty());
    act(session, "environment", {{"what", "none"}});
    ASSERT_TRUE(until(session, [&] { return session.document()->environment == "none"; }));
    session.load(kAssets / "cornell-diffuse.gltf");
    ASSERT_TRUE(until(
        session, [&] { return session.document()->file.filename() == "cornell-diffuse.gltf"; }));
    ASSERT_EQ(session.savedCameras().size(), 1u) << "views are kept with the scene in any light";
    EXPECT_EQ(session.savedCameras()[0].name, "aside");
}

TEST_F(SessionSaves, AnotherSceneUnderTheSameNameIsEnteredAnew)
{
    const fs::path file = folder / "scene.gltf";
    const auto put = [&](const std::string& asset) {
        fs::copy_file(kAssets / (asset + ".gltf"), file, fs::copy_options::overwrite_existing);
        fs::copy_file(kAssets / (asset + ".bin"), folder / (asset + ".bin"));
    };
    put("cornell-diffuse");
    Session session(options(""));
    session.load(file);
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "add-key");
    put("lights");
    act(session, "environment", {{"what", "plain"}});
    ASSERT_TRUE(until(session, [&] { return session.document()->environment == "plain"; }));
    EXPECT_TRUE(session.track.empty());
    EXPECT_EQ(session.navigation.camera(), session.document()->world->cameras.front());
}

TEST_F(SessionSaves, AReplayHasTheEnvironmentOfThePicture)
{
    const fs::path file = folder / "plain.exr";
    {
        app::SessionOptions plain = options("cornell-diffuse.gltf");
        plain.scene.load.environment = core::kPlainSky;
        Session session(plain);
        ASSERT_TRUE(until(session, [&] { return settled(session); }));
        session.save(file);
        ASSERT_TRUE(until(session, [&] { return !session.saving(); }));
    }
    Session session(options("hall.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    session.replay(file);
    ASSERT_TRUE(until(
        session, [&] { return session.document()->file.filename() == "cornell-diffuse.gltf"; }));
    EXPECT_EQ(session.document()->environment, core::kPlainSky);
    EXPECT_FALSE(told(session, "its hash differs"));
}

TEST_F(SessionSaves, TheWindowIsAwakeWhileARendererIsBuilt)
{
    book.set(&Book::endlessWorld, true);
    Session session(pretended());
    ASSERT_TRUE(until(session, [&] { return session.rendering().stage == "building"; }));
    for (int i = 0; i < 100; ++i) session.update(0.1, kArea);  // nothing has moved for long
    EXPECT_TRUE(session.busy());
    book.set(&Book::endlessWorld, false);
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
}

TEST_F(SessionSaves, PresetsOfTheMethodComeFirst)
{
    Session session(options("cornell-diffuse.gltf"));
    session.settings.presets = {{"balanced", core::GuidedParams{}}};
    act(session, "preset", {{"name", "balanced"}});
    EXPECT_EQ(session.render.method.id(), "path");
    session.settings.presets = {{"mine", core::GuidedParams{}}};
    act(session, "preset", {{"name", "mine"}});
    EXPECT_EQ(session.render.method.id(), "guided");
}

TEST_F(SessionSaves, AReplayTakesTheDeviceAndForgetsOtherLimits)
{
    {
        Session session(options("cornell-diffuse.gltf"));
        act(session, "set", {{"name", "spp-limit"}, {"value", 3}});
        ASSERT_TRUE(
            until(session, [&] { return settled(session) && session.picture()->finished; }));
        save(session, "a.exr");
        ASSERT_TRUE(until(session, [&] { return !session.saving(); }));
    }
    app::SessionOptions o = pretended();
    o.render.device = app::DeviceKind::vulkan;
    o.render.secondsLimit = 1;
    Session session(o);
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    session.replay(folder / "a.exr");
    ASSERT_TRUE(until(session, [&] { return session.render.device == app::DeviceKind::cpu; }));
    EXPECT_EQ(session.render.secondsLimit, 0);
    EXPECT_EQ(session.render.sppLimit, 3u);
}

TEST_F(SessionSaves, AReplayWithoutItsSceneShowsTheBuiltInOne)
{
    std::ofstream(folder / "no picture.exr") << "nothing";
    app::SessionOptions o = options("");
    o.builtIn = true;
    Session session(o);
    session.replay(folder / "no picture.exr");
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    EXPECT_TRUE(told(session, "no picture.exr"));
}

TEST_F(SessionSaves, OneFailureOfSeveralIsAFailure)
{
    Session session(options("cornell-diffuse.gltf"));
    save(session, "early.exr");
    EXPECT_TRUE(session.saveFailed()) << "there is no picture yet, and quitting would lose it";
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    save(session, "none/a.exr");
    save(session, "b.exr");
    ASSERT_TRUE(until(session, [&] { return !session.saving(); }));
    EXPECT_TRUE(told(session, "b.exr: saved"));
    EXPECT_TRUE(session.saveFailed());
    save(session, "c.exr");
    ASSERT_TRUE(until(session, [&] { return !session.saving(); }));
    EXPECT_FALSE(session.saveFailed());
}

TEST_F(SessionSaves, NoNameIsGivenTwice)
{
    Session session(options(""));
    std::set<fs::path> names;
    for (int i = 0; i < 5; ++i) {
        app::AppRequests requests;
        app::runAction("screenshot", session, requests);
        EXPECT_TRUE(names.insert(requests.screenshot.value()).second) << *requests.screenshot;
    }
}

}  // namespace
