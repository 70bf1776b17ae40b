// What would be lost is asked about whichever hand would lose it, and what is saved instead is all
// of it, each in a new file.
#include "app/session/losses.h"

#include <gtest/gtest.h>

#include "app/base/files.h"
#include "core/base/output_file.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/process/environment_variable.h"
#include "tests/support/session/pretender.h"
#include "tests/support/session/session_steps.h"

namespace {

using namespace tests;
using app::Part;

/// The folder that files without one go to, for the life of an object.
class CurrentFolder {
public:
    explicit CurrentFolder(const fs::path& folder) : before_(fs::current_path())
    {
        fs::current_path(folder);
    }
    ~CurrentFolder() { fs::current_path(before_); }
    CurrentFolder(const CurrentFolder&) = delete;
    CurrentFolder& operator=(const CurrentFolder&) = delete;

private:
    fs::path before_;
};

/// Sessions in which any rendering at all is much.
struct Losses : testing::Test {
    Losses() : here(folder.path())
    {
        app::SessionOptions o = options("cornell-diffuse.gltf");
        o.factory = [this](const app::RenderParams&, bool) {
            return std::make_unique<Pretender>(book);
        };
        o.render.sppLimit = 3;
        session = std::make_unique<Session>(o);
        EXPECT_TRUE(until(*session, [&] { return finished(); }));
        session->muchSeconds = 0;
    }
    bool finished() const { return settled(*session) && session->picture()->finished; }
    void keepReference() const
    {
        session->keepAsReference();
        EXPECT_TRUE(until(*session, [&] { return session->reference() != nullptr; }));
    }
    /// Until the scene is there, though not its picture.
    void show(const char* scene) const
    {
        act(*session, "load", {{"file", (kAssets / scene).string()}});
        EXPECT_TRUE(until(*session, [&] {
            return session->settled() && session->document()->file.filename() == scene;
        }));
    }
    /// As A, with its variance: from then on the slot stays as it is.
    void storeSide() const
    {
        act(*session, "store-a");
        EXPECT_TRUE(
            until(*session, [&] { return session->slots[0].picture->variance != nullptr; }));
        session->update(0.01, kArea);
    }
    /// Whether a key or a button of this action asks first.
    bool asks(const std::string& action, const ActionJson& arguments = ActionJson::object())
    {
        app::AppRequests requests;
        app::runByHand(action, *session, requests, arguments);
        return requests.question.has_value();
    }
    std::vector<Part> parts() const
    {
        std::vector<Part> list;
        for (const app::Loss& loss : app::lossesOf(*session)) list.push_back(loss.part);
        return list;
    }
    void savePicture() const
    {
        act(*session, "save", {{"file", "picture.exr"}});
        EXPECT_TRUE(until(*session, [&] { return !session->saving(); }));
    }

    TemporaryFolder folder;
    CurrentFolder here;
    Book book;
    std::unique_ptr<Session> session;
};

TEST_F(Losses, NoKeyDropsALongReferenceUnasked)
{
    keepReference();
    const auto before = session->reference();
    for (const char* action : {"reference", "keep-reference", "drop-reference"})
        EXPECT_TRUE(asks(action)) << action;
    EXPECT_TRUE(asks("load-reference", {{"file", "other.exr"}}));
    session->update(0.01, kArea);
    EXPECT_EQ(session->reference(), before);
    session->muchSeconds = 60;
    EXPECT_FALSE(asks("reference", {{"spp", 4}})) << "a moment's work";
    ASSERT_TRUE(until(*session, [&] { return !session->coreThread().active(); }));
    EXPECT_NE(session->reference(), before);
}

TEST_F(Losses, AnotherSceneAsksForAllThatItDrops)
{
    EXPECT_TRUE(asks("load", {{"file", (kAssets / "hall.gltf").string()}})) << "the picture";
    savePicture();
    EXPECT_FALSE(asks("load", {{"file", (kAssets / "cornell-diffuse.gltf").string()}}));
    ASSERT_TRUE(until(*session, [&] { return session->settled() && finished(); }));
    session->muchSeconds = 60;
    for (const double frame : {0.0, 24.0}) act(*session, "add-key", {{"frame", frame}});
    EXPECT_TRUE(asks("load", {{"file", (kAssets / "hall.gltf").string()}})) << "the path";
    EXPECT_TRUE(asks("replay", {{"file", "picture.exr"}}));
    EXPECT_FALSE(asks("environment", {{"what", "plain"}})) << "which leaves the path";
    ASSERT_TRUE(until(*session, [&] { return session->document()->environment == "plain"; }));
    EXPECT_EQ(session->track.keys().size(), 2u);
}

TEST_F(Losses, ASideThatIsKeptIsNoLossOfTheLivePicture)
{
    storeSide();
    EXPECT_FALSE(asks("store-a")) << "it is on show";
    EXPECT_FALSE(asks("restart")) << "it stays as A";
    act(*session, "restart");
    ASSERT_TRUE(until(*session, [&] {
        return finished() && !holds(session->slots[0].picture, session->picture());
    }));
    EXPECT_TRUE(asks("restart"));
    for (const char* action : {"store-a", "live-a", "clear-slots", "equal-time"})
        EXPECT_TRUE(asks(action)) << action;
    EXPECT_FALSE(asks("store-b"));
}

TEST_F(Losses, AnAnswerDoesWhatWasAskedFor)
{
    keepReference();
    app::AppRequests requests;
    app::runByHand("drop-reference", *session, requests);
    ASSERT_TRUE(requests.question);
    EXPECT_TRUE(session->reference());
    app::doIntent(*requests.question, *session, requests);
    EXPECT_FALSE(session->reference());
}

TEST_F(Losses, AReferenceThatIsBeingRenderedIsToldOnce)
{
    savePicture();
    act(*session, "reference", {{"spp", 1000000}});
    ASSERT_TRUE(until(*session, [&] { return session->reference() != nullptr; }));
    const std::vector<app::Loss> losses = app::lossesOf(*session);
    ASSERT_EQ(losses.size(), 1u);
    EXPECT_EQ(losses[0].part, Part::reference);
    EXPECT_TRUE(losses[0].text.starts_with("what runs in the background (reference): "));
    EXPECT_TRUE(app::canBeSaved(*session, losses[0]));
    EXPECT_TRUE(asks("reference"));
    act(*session, "cancel");
}

/// While something else runs in the background no reference can be rendered: that is said at once.
TEST_F(Losses, WhatIsRefusedAsksNothing)
{
    keepReference();
    const auto before = session->reference();
    for (const double frame : {0.0, 4000.0}) act(*session, "add-key", {{"frame", frame}});
    act(*session, "export-path", {{"file", "out/f-%04d.png"}, {"spp", 1000000}});
    ASSERT_TRUE(until(*session, [&] { return session->coreThread().active(); }));
    EXPECT_FALSE(asks("reference"));
    EXPECT_TRUE(told(*session, "is under way"));
    EXPECT_EQ(session->reference(), before);
    EXPECT_TRUE(asks("drop-reference")) << "that can be done meanwhile";
    act(*session, "cancel");
    ASSERT_TRUE(until(*session, [&] { return !session->coreThread().active(); }));
    EXPECT_TRUE(asks("reference"));
}

TEST_F(Losses, APathOfTheHandIsOneUntilItIsSaved)
{
    savePicture();
    act(*session, "add-key", {{"frame", 0}});
    EXPECT_TRUE(parts().empty()) << "one key is no path";
    act(*session, "add-key", {{"frame", 24}});
    EXPECT_EQ(parts(), std::vector{Part::path});
    EXPECT_EQ(app::lossesOf(*session)[0].text, "the camera path: 2 keys that are in no file");
    EXPECT_TRUE(asks("clear-path"));
    EXPECT_EQ(session->track.keys().size(), 2u);
    act(*session, "save-path", {{"file", "path.json"}});
    EXPECT_TRUE(parts().empty());
    session->track.loop = !session->track.loop;
    EXPECT_EQ(parts(), std::vector{Part::path}) << "a file keeps that, too";
    session->track.loop = !session->track.loop;
    EXPECT_FALSE(asks("clear-path"));
    EXPECT_TRUE(parts().empty());
    act(*session, "load-path", {{"file", "path.json"}});
    EXPECT_EQ(session->track.keys().size(), 2u);
    EXPECT_TRUE(parts().empty());
}

TEST_F(Losses, SavingAndQuittingSavesAllThatTheQuestionNames)
{
    storeSide();
    keepReference();
    act(*session, "set", {{"name", "max-depth"}, {"value", 2}});
    ASSERT_TRUE(until(*session, [&] { return finished(); }));
    act(*session, "store-b");
    act(*session, "set", {{"name", "max-depth"}, {"value", 3}});
    ASSERT_TRUE(until(*session, [&] { return finished(); }));
    for (const double frame : {0.0, 24.0}) act(*session, "add-key", {{"frame", frame}});
    EXPECT_EQ(parts(), (std::vector{Part::picture, Part::a, Part::b, Part::reference, Part::path}));
    app::AppRequests requests;
    app::runAction("save-and-quit", *session, requests);
    EXPECT_TRUE(requests.quitWhenSaved);
    ASSERT_TRUE(until(*session, [&] { return !session->saving(); }));
    EXPECT_FALSE(session->saveFailed());
    EXPECT_EQ(folder.count(), 5u);
    EXPECT_TRUE(parts().empty());
    fs::path reference;
    for (const auto& entry : fs::directory_iterator(folder.path())) {
        const std::string name = entry.path().filename().string();
        EXPECT_TRUE(told(*session, name + ": ")) << name;
        if (name.ends_with("-reference.exr")) reference = entry.path();
    }
    const core::Image mean = session->reference()->mean;
    session->loadReference(reference);
    EXPECT_EQ(session->reference()->mean.pixels, mean.pixels);
    EXPECT_EQ(core::readExr(reference).metadata.at("spp"), "3");

    session->restart();
    ASSERT_TRUE(until(*session, [&] { return finished(); }));
    app::runAction("save-and-quit", *session, requests);
    ASSERT_TRUE(until(*session, [&] { return !session->saving(); }));
    EXPECT_EQ(folder.count(), 6u) << "none is replaced, and what is saved is not saved again";
}

TEST_F(Losses, WhatCannotBeSavedIsStillALoss)
{
    storeSide();
    act(*session, "restart");
    ASSERT_TRUE(until(*session, [&] { return finished(); }));
    savePicture();
    session->saveSlot(0, folder / "none" / "a.exr");
    ASSERT_TRUE(until(*session, [&] { return !session->saving(); }));
    EXPECT_TRUE(session->saveFailed());
    EXPECT_EQ(parts(), (std::vector{Part::picture, Part::a})) << "it is asked for both again";
}

TEST_F(Losses, ATypedNameReplacesAFileOnlyWhenItIsMeant)
{
    const auto write = [&](const char* action, const char* file, bool replace) {
        app::AppRequests requests;
        app::runAction(action, *session, requests,
                       {{"file", file}, {"replace", replace}, {"spp", 1}});
        return requests.wouldReplace;
    };
    core::writeFile(folder / "old.exr", "precious");
    EXPECT_TRUE(write("save", "old.exr", false));
    session->update(0.01, kArea);
    EXPECT_FALSE(session->saving());
    EXPECT_EQ(app::readText(folder / "old.exr"), "precious");
    EXPECT_TRUE(told(*session, "is there already"));
    EXPECT_FALSE(write("save", "old.exr", true));
    ASSERT_TRUE(until(*session, [&] { return !session->saving(); }));
    EXPECT_NE(app::readText(folder / "old.exr"), "precious");

    for (const double frame : {0.0, 2.0}) act(*session, "add-key", {{"frame", frame}});
    core::writeFile(folder / "f-1.png", "precious");
    EXPECT_TRUE(write("export-path", "f-%d.png", false)) << "one of the frames is there";
    EXPECT_FALSE(session->coreThread().active());
    EXPECT_FALSE(write("export-path", "f-%d.png", true));
    ASSERT_TRUE(until(*session, [&] { return !session->coreThread().active(); }));
    EXPECT_NE(app::readText(folder / "f-1.png"), "precious");
}

TEST_F(Losses, APathOfAnotherSceneIsNoNewerVersionOfThisOne)
{
    const auto save = [&] {
        app::AppRequests requests;
        app::runAction("save-path", *session, requests, {{"file", "path.json"}});
        return requests.wouldReplace;
    };
    for (const double frame : {0.0, 24.0}) act(*session, "add-key", {{"frame", frame}});
    EXPECT_FALSE(save());
    const std::string one = app::readText(folder / "path.json");
    show("hall.gltf");
    for (const double frame : {0.0, 24.0}) act(*session, "add-key", {{"frame", frame}});
    EXPECT_TRUE(save());
    EXPECT_EQ(app::readText(folder / "path.json"), one);
    EXPECT_TRUE(told(*session, "is there already"));
}

/// A question about a picture that is gone would be answered by saving another one.
TEST_F(Losses, APictureThatIsGoneIsNoLoss)
{
    EXPECT_EQ(parts(), std::vector{Part::picture});
    book.set(&Book::endlessPrepare, true);
    act(*session, "set", {{"name", "max-depth"}, {"value", 3}});
    session->update(0.01, kArea);
    EXPECT_EQ(session->unsavedSeconds(), 0) << "other parameters";
    EXPECT_TRUE(parts().empty());
    book.set(&Book::endlessPrepare, false);
    ASSERT_TRUE(until(*session, [&] { return finished(); }));
    EXPECT_GT(session->unsavedSeconds(), 0);

    book.set(&Book::endlessWorld, true);
    show("hall.gltf");
    ASSERT_TRUE(session->picture());
    EXPECT_EQ(session->unsavedSeconds(), 0) << "another scene";
    EXPECT_TRUE(parts().empty());
    book.set(&Book::endlessWorld, false);
}

/// What looked for each frame by its name would take half an hour here.
TEST_F(Losses, FramesThatAreThereAreFoundAmongAsManyAsThereCanBe)
{
    const auto refused = [&](const char* file) {
        app::AppRequests requests;
        app::runAction("export-path", *session, requests,
                       {{"file", file}, {"replace", false}, {"spp", 1}});
        session->cancel(app::Work::background);
        EXPECT_TRUE(until(*session, [&] { return !session->coreThread().active(); }));
        return requests.wouldReplace;
    };
    for (const double frame : {2.0, 1e9}) act(*session, "add-key", {{"frame", frame}});
    EXPECT_FALSE(refused("nowhere/f-%d.png"));
    for (const char* other : {"f-1.png", "f-002.png", "f-2.exr", "f-2.png.old", "f-.png", "g-2.png",
                              "f-1000000001.png", "f-99999999999999999999.png", "f-+3.png"})
        core::writeFile(folder / other, "precious");
    EXPECT_FALSE(refused("f-%d.png"));
    EXPECT_TRUE(refused("f-%03d.png"));
    core::writeFile(folder / "h-1000000000.png", "precious");
    EXPECT_TRUE(refused("h-%d.png"));
    EXPECT_TRUE(told(*session, "h-1000000000.png is there already"));
}

TEST_F(Losses, FramesOfNoNameGoToAFolderOfTheirOwn)
{
    for (const double frame : {0.0, 1.0}) act(*session, "add-key", {{"frame", frame}});
    for (const char* frames : {"frames", "frames-2"}) {
        act(*session, "export-path", {{"spp", 1}});
        ASSERT_TRUE(until(*session, [&] { return !session->coreThread().active(); }));
        EXPECT_TRUE(fs::exists(folder / frames / "frame-0001.exr")) << frames;
    }
}

TEST_F(Losses, TildeIsTheHomeFolder)
{
    const EnvironmentVariable home("HOME", folder.path().c_str());
    act(*session, "save", {{"file", "~/at-home.exr"}});
    act(*session, "add-key");
    act(*session, "save-path", {{"file", "~/at-home.json"}});
    ASSERT_TRUE(until(*session, [&] { return !session->saving(); }));
    EXPECT_TRUE(fs::exists(folder / "at-home.exr") && fs::exists(folder / "at-home.json"));
}

}  // namespace
