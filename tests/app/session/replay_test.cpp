// From a saved picture back to its view: what the program renders and what the window saves tell
// the same, and suffice to make the same pixels again.
#include "app/session/replay.h"

#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/base/files.h"
#include "app/files/camera_file.h"
#include "app/files/load.h"
#include "app/files/params_json.h"
#include "app/pictures/save_picture.h"
#include "core/base/check.h"
#include "core/base/output_file.h"
#include "core/image/film.h"
#include "core/image/image_metadata.h"
#include "core/methods/method.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/session/session_steps.h"

namespace {

namespace fs = std::filesystem;
using tests::TemporaryFolder;

const fs::path kReplayed = fs::path(REKINDLE_SOURCE_DIR) / "assets" / "cornell-diffuse.gltf";

/// Starts the real program in a folder; true when it ends with 0.
bool rekindle(const fs::path& folder, const std::string& arguments)
{
    const std::string command = "cd '" + folder.string() +
                                "' && timeout 60 '" REKINDLE_BINARY "' " + arguments +
                                " >/dev/null 2>errors.txt";
    return std::system(command.c_str()) == 0;
}

std::string quoted(const fs::path& file)
{
    return "'" + file.string() + "'";
}

/// The text of what was thrown; empty when nothing was.
template <class Action> std::string refusalOf(Action action)
{
    try {
        action();
    } catch (const core::Error& error) {
        return error.what();
    }
    return {};
}

core::PathParams someParams()
{
    core::PathParams params;
    params.maxDepth = 3;
    params.rouletteDepth = 1;
    params.seed = 77;
    params.sampler = core::SamplerKind::independent;
    params.strategy = core::Strategy::bsdf;
    params.clampIndirect = 0.1f;
    return params;
}

const std::string kOptions = " --device cpu --size 24x16 --spp 3 --max-depth 3 --roulette-depth 1 "
                             "--seed 77 --sampler independent --strategy bsdf --clamp-indirect 0.1";

void expectSome(const app::Replay& replay)
{
    EXPECT_EQ(replay.params, core::AnyParams(someParams()));
    EXPECT_EQ(replay.size, glm::uvec2(24, 16));
    EXPECT_EQ(replay.samples, 3u);
    EXPECT_EQ(replay.device, app::DeviceKind::cpu);
    EXPECT_EQ(replay.at, 0);
    EXPECT_FALSE(replay.sceneHash.empty());
}

TEST(Replay, PicturesOfTheProgramSayEverything)
{
    const TemporaryFolder folder;
    for (const char* name : {"a.exr", "a.png"}) {
        ASSERT_TRUE(
            rekindle(folder.path(), "render " + quoted(kReplayed) + " -o " + name + kOptions))
            << app::readText(folder / "errors.txt");
        const app::Replay replay = app::readReplay(folder / name);
        expectSome(replay);
        EXPECT_EQ(replay.scene, kReplayed);
        EXPECT_TRUE(nlohmann::json::parse(replay.cameraJson).contains("position"));
    }
}

/// The scene and a renderer's picture of it, as the window would hold them.
struct Shown {
    std::shared_ptr<const core::World> world;
    app::Picture picture;

    app::ShownScene scene(double at = 0) const
    {
        return {kReplayed, world, at, core::kAnyEnvironment};
    }
};

Shown show(uint64_t samples)
{
    Shown shown{app::loadWorld({.file = kReplayed, .load = {}, .at = 0}, 0, {}).world, {}};
    app::Picture& p = shown.picture;
    p.camera = core::lookAt({0.1, 0.3, 2.5}, {0, 0.1, 0}, {0, 1, 0}, 0.9);
    p.camera.name = shown.world->cameras.front().name;  // files of cameras without a name leave it
    p.params.device = app::DeviceKind::cpu;
    p.params.method = someParams();
    const auto renderer = core::makeRenderer("path");
    renderer->setWorld(shown.world, {});
    renderer->setView({p.camera, {24, 16}, p.params.method}, core::Start::anew);
    renderer->advance({.samples = static_cast<uint32_t>(samples)}, {});
    const core::Estimate film = renderer->read(core::Reading::everything);
    p.mean = film.mean;
    p.variance = std::make_shared<core::Image>(film.variance);
    p.aovs = std::make_shared<core::Aovs>(renderer->aovs());
    p.fullSize = {24, 16};
    p.samples = samples;
    p.seconds = 0.25;
    p.stats = renderer->stats();
    return shown;
}

/// Headless pictures keep the camera's angle, the window shows all of the camera's frame.
TEST(Replay, PicturesOfAnotherShapeThanTheirCamerasFrameComeOutAgain)
{
    const TemporaryFolder folder;
    const fs::path scene = fs::path(REKINDLE_SOURCE_DIR) / "assets" / "animated.gltf";
    const glm::uvec2 size = tests::kArea;
    ASSERT_LT(9 * size.x, 16 * size.y) << "the test needs a picture narrower than the frame";
    ASSERT_TRUE(rekindle(folder.path(), "render " + quoted(scene) +
                                            " -o a.exr --device cpu --spp 3 --size " +
                                            std::to_string(size.x) + 'x' + std::to_string(size.y)));
    app::Session session(tests::options(""));
    session.replay(folder / "a.exr");
    ASSERT_TRUE(tests::until(
        session, [&] { return tests::settled(session) && session.picture()->finished; }));
    EXPECT_EQ(session.picture()->samples, 3u);
    EXPECT_EQ(session.picture()->mean.pixels, core::readExr(folder / "a.exr").layer("").pixels);
}

/// Placement, instancing and the choice of emitters are those of the pose that came first.
TEST(Replay, FramesOfAnAnimationComeBackAsThePosesThatTheyWere)
{
    const TemporaryFolder folder;
    const fs::path assets = fs::path(REKINDLE_SOURCE_DIR) / "assets", file = folder / "large.gltf";
    fs::copy_file(assets / "animated.bin", folder / "animated.bin");
    nlohmann::json scene = nlohmann::json::parse(app::readText(assets / "animated.gltf"));
    scene["nodes"][2]["scale"] = {40, 40, 40};  // the ball sticks out, and takes the bounds along
    core::writeFile(file, scene.dump());
    const auto first = app::loadWorld({.file = file, .load = {}, .at = 0}, 0, {}).world;
    const auto alone = app::loadWorld({.file = file, .load = {}, .at = 0.7}, 0, {}).world;
    const auto shown = core::poseWorld(core::poseWorld(first, 0.3), 0.7);
    ASSERT_NE(alone->placement.centre, first->placement.centre) << "the test needs two placements";
    const auto facts = [&](const std::shared_ptr<const core::World>& world) {
        app::PictureFacts f;
        f.scene = {file, world, 0.7, core::kAnyEnvironment};
        f.camera = world->cameras.front();
        f.size = {24, 16};
        f.params = someParams();
        f.samples = 3;
        f.device = "cpu";
        return app::imageMetadata(f);
    };
    EXPECT_FALSE(facts(alone).contains("laid_out_at"));
    const app::Replay replay = app::replayOf(facts(shown), file);
    EXPECT_EQ(replay.at, 0.7);
    ASSERT_EQ(replay.laidOutAt, 0.0);
    const auto again =
        app::loadWorld(
            {.file = replay.scene, .load = {}, .at = replay.at, .laidOutAt = replay.laidOutAt}, 0,
            {})
            .world;
    EXPECT_EQ(again->time, 0.7);
    EXPECT_EQ(again->laidOutAt, 0);
    EXPECT_EQ(again->placement.centre, shown->placement.centre);
    EXPECT_EQ(again->positions, shown->positions);
    EXPECT_EQ(again->cameras, shown->cameras);
}

TEST(Replay, PicturesOfTheWindowSayTheSameAndComeOutAgain)
{
    const TemporaryFolder folder;
    Shown shown = show(3);
    shown.picture.finished = true;
    shown.picture.params.sppLimit = 3;
    app::savePicture(folder / "w.exr", shown.picture, shown.scene(), {});
    const app::Replay replay = app::readReplay(folder / "w.exr");
    expectSome(replay);
    core::writeFile(folder / "camera.json", replay.cameraJson);
    ASSERT_TRUE(rekindle(folder.path(), "render " + quoted(replay.scene) +
                                            " -o r.exr --camera camera.json" + kOptions))
        << app::readText(folder / "errors.txt");
    const core::ImageFile window = core::readExr(folder / "w.exr"),
                          render = core::readExr(folder / "r.exr");
    EXPECT_EQ(window.layer("").pixels, render.layer("").pixels);
    EXPECT_EQ(window.layer("variance").pixels, render.layer("variance").pixels);
    EXPECT_EQ(window.layer("").pixels, shown.picture.mean.pixels);
    for (const char* layer : {"depth", "normal", "albedo", "ids"})
        EXPECT_TRUE(window.hasLayer(layer)) << layer;
    // The same members with the same contents, but for how long it took.
    core::Metadata a = window.metadata, b = render.metadata;
    EXPECT_EQ(a.at("seconds"), "0.250");
    a.erase("seconds");
    b.erase("seconds");
    EXPECT_EQ(a, b);
}

/// What views before it left to a picture is in no file: the file says so.
TEST(Replay, PicturesThatFollowOnOthersSaySo)
{
    const TemporaryFolder folder;
    Shown shown = show(1);
    for (const bool follows : {false, true}) {
        shown.picture.follows = follows;
        app::savePicture(folder / "w.exr", shown.picture, shown.scene(), {});
        EXPECT_EQ(app::readReplay(folder / "w.exr").follows, follows);
    }
}

TEST(Replay, WhatAWindowSaves)
{
    const TemporaryFolder folder;
    Shown shown = show(1);
    app::Picture& p = shown.picture;
    const auto save = [&](const fs::path& file, double at = 0) {
        app::savePicture(file, p, shown.scene(at), {.exposure = 2, .tone = app::Tone::linear});
    };
    save(folder / "one.exr", 1.5);
    const core::ImageFile one = core::readExr(folder / "one.exr");
    EXPECT_FALSE(one.hasLayer("variance"));  // one sample has none
    EXPECT_EQ(one.metadata.at("ended"), "interrupted");
    EXPECT_EQ(app::readReplay(folder / "one.exr").at, 1.5);
    // A PNG is brightened as the window shows it.
    save(folder / "bright.png");
    core::writePng(folder / "same.png", p.mean, 2, static_cast<uint32_t>(app::Tone::linear),
                   core::readMetadata(folder / "bright.png"));
    EXPECT_EQ(app::readText(folder / "bright.png"), app::readText(folder / "same.png"));
    // First hits of another size are not those of this picture.
    auto other = std::make_shared<core::Aovs>(*p.aovs);
    other->depth = core::Image(7, 5, 1);
    p.aovs = other;
    save(folder / "lagging.exr");
    EXPECT_FALSE(core::readExr(folder / "lagging.exr").hasLayer("depth"));
    EXPECT_TRUE(core::readExr(folder / "lagging.exr").hasLayer("normal"));

    const size_t before = folder.count();
    EXPECT_NE(refusalOf([&] { save(folder / "x.jpg"); }).find(".exr or .png"), std::string::npos);
    EXPECT_NE(refusalOf([&] { save(folder / "none" / "x.exr"); }).find("does not exist"),
              std::string::npos);
    p.preview = true;
    EXPECT_NE(refusalOf([&] { save(folder / "x.exr"); }).find("preview"), std::string::npos);
    p.preview = false;
    p.samples = 0;
    EXPECT_NE(refusalOf([&] { save(folder / "x.exr"); }).find("no picture yet"), std::string::npos);
    EXPECT_EQ(folder.count(), before);
}

/// Metadata that is complete, beside a scene that exists.
core::Metadata complete(const fs::path& scene)
{
    return {{"software", "rekindle"},
            {"scene", scene.string()},
            {"scene_hash", "ab"},
            {"camera", R"({"position": [0, 1, 2]})"},
            {"width", "320"},
            {"height", "200"},
            {"spp", "16"},
            {"method", "path"},
            {"params", app::paramsJson(core::PathParams()).dump()},
            {"device", "llvmpipe"},
            {"at", "0.5"}};
}

TEST(Replay, EachMissingMemberIsNamed)
{
    const TemporaryFolder folder;
    const fs::path picture = folder / "p.exr";
    const core::Metadata all = complete(kReplayed);
    const app::Replay replay = app::replayOf(all, picture);
    EXPECT_EQ(replay.device, app::DeviceKind::vulkan);
    EXPECT_EQ(replay.at, 0.5);
    EXPECT_EQ(replay.params, core::AnyParams());
    for (const char* name :
         {"scene", "scene_hash", "camera", "width", "height", "spp", "method", "params"}) {
        core::Metadata some = all;
        some.erase(name);
        const std::string text = refusalOf([&] { app::replayOf(some, picture); });
        EXPECT_EQ(text.rfind(picture.string() + ": does not say its " + name, 0), 0u) << text;
    }
    for (const char* name : {"software", "device", "at"}) {
        core::Metadata some = all;
        some.erase(name);
        EXPECT_EQ(refusalOf([&] { app::replayOf(some, picture); }), "") << name;
    }
    EXPECT_NE(refusalOf([&] { app::replayOf({}, picture); }).find("not made by this program"),
              std::string::npos);
}

TEST(Replay, EachMalformedMemberIsNamed)
{
    const TemporaryFolder folder;
    const fs::path picture = folder / "p.exr";
    struct Case {
        const char *name, *value, *expected;
    };
    for (const Case& c : {Case{"width", "0", "from 1 to 65536"},
                          {"height", "2e3", "from 1 to 65536"},
                          {"width", "99999", "from 1 to 65536"},
                          {"spp", "-1", "whole number"},
                          {"method", "magic", "is not one of path"},
                          {"at", "soon", "a number"},
                          {"camera", "{", "not JSON"},
                          {"camera", "[1]", "expected {"},
                          {"params", "[]", "expected an object"},
                          {"params", R"({"max-depth": 1e9})", "from 0 to 4096"},
                          {"params", R"({"max-depth": 1e999})", "too large"},
                          {"params", R"({"max-depht": 3})", "did you mean max-depth"}}) {
        core::Metadata all = complete(kReplayed);
        all[c.name] = c.value;
        const std::string text = refusalOf([&] { app::replayOf(all, picture); });
        EXPECT_EQ(text.rfind(picture.string() + ": " + c.name, 0), 0u) << text;
        EXPECT_NE(text.find(c.expected), std::string::npos) << text;
    }
    // A parameter that came later is at its default.
    core::Metadata older = complete(kReplayed);
    older["params"] = R"({"max-depth": 3})";
    EXPECT_EQ(app::replayOf(older, picture).params.as<core::PathParams>().maxDepth, 3u);
}

TEST(Replay, TheSceneIsSoughtWhereItWasNamedAndBesideThePicture)
{
    const TemporaryFolder folder;
    fs::create_directories(folder / "rooms");
    const fs::path picture = folder / "p.exr";
    const auto found = [&](const fs::path& named) {
        return app::replayOf(complete(named), picture).scene;
    };
    EXPECT_EQ(found(kReplayed), kReplayed);
    const std::string text = refusalOf([&] { found("rooms/hall.glb"); });
    EXPECT_NE(text.find("rooms/hall.glb is neither there nor beside"), std::string::npos) << text;
    core::writeFile(folder / "hall.glb", "scene");
    EXPECT_EQ(found("rooms/hall.glb"), folder / "hall.glb");
    EXPECT_EQ(found("/elsewhere/hall.glb"), folder / "hall.glb");
    core::writeFile(folder / "rooms" / "hall.glb", "scene");
    EXPECT_EQ(found("rooms/hall.glb"), folder / "rooms/hall.glb");
    EXPECT_EQ(found("/moved/rooms/hall.glb"), folder / "rooms/hall.glb");
    EXPECT_NE(refusalOf([&] { found(folder.path()); }), "");  // a folder is no scene
}

TEST(Replay, FilesThatAreNoPicturesOfOurs)
{
    const TemporaryFolder folder;
    EXPECT_NE(refusalOf([&] { app::readReplay(folder / "none.exr"); }).find("no such file"),
              std::string::npos);
    EXPECT_NE(refusalOf([&] { app::readReplay(kReplayed); }).find("not an EXR or PNG"),
              std::string::npos);
    fs::create_directory(folder / "d.png");
    EXPECT_NE(refusalOf([&] { app::readReplay(folder / "d.png"); }).find("not a regular file"),
              std::string::npos);
    for (const char* name : {"a.exr", "a.png"}) {
        core::writeFile(folder / name, "something else entirely");
        EXPECT_NE(refusalOf([&] { app::readReplay(folder / name); }).find(name), std::string::npos);
    }
    core::writePng(folder / "other.png", core::Image(2, 2, 3), 0, 0, {});
    EXPECT_NE(refusalOf([&] { app::readReplay(folder / "other.png"); }).find("not made by this"),
              std::string::npos);
    core::writeExr(folder / "other.exr", {{{"", core::Image(2, 2, 3)}}, {}});
    EXPECT_NE(refusalOf([&] { app::readReplay(folder / "other.exr"); }).find("not made by this"),
              std::string::npos);
}

/// What was around the scene is kept with the picture, by name.
TEST(Replay, TheEnvironmentComesAlong)
{
    const TemporaryFolder folder;
    const Shown shown = show(1);
    const fs::path picture = folder / "picture.exr";
    const auto replayed = [&](const std::string& environment) {
        app::ShownScene scene = shown.scene();
        scene.environment = environment;
        app::savePicture(picture, shown.picture, scene, {});
        return app::readReplay(picture).environment;
    };
    for (const char* word : {"own", "auto", "none", "plain"}) EXPECT_EQ(replayed(word), word);
    EXPECT_NE(refusalOf([&] { replayed("/not/here/sky.exr"); }).find("its environment"),
              std::string::npos);
    core::writeFile(folder / "sky.exr", "any");
    EXPECT_EQ(replayed("/not/here/sky.exr"), folder / "sky.exr");
    // Pictures of older versions do not say.
    core::Metadata metadata = core::readMetadata(picture);
    metadata.erase("environment");
    EXPECT_EQ(app::replayOf(metadata, picture).environment, "");
}

TEST(Replay, AScreenshotIsReplayedAsAnyPictureIs)
{
    const TemporaryFolder folder;
    Shown shown = show(3);
    shown.picture.finished = true;
    shown.picture.params.sppLimit = 3;
    const auto screenshot = [&](const fs::path& file) {
        const std::vector<uint8_t> window(16 * 8 * 4, 99);
        core::writePngBytes(file, 16, 8, 4, window,
                            app::viewMetadata(shown.picture, shown.scene()));
        return app::readReplay(file);
    };
    expectSome(screenshot(folder / "shot.png"));
    // While the camera moves the picture is small: what is meant is the view.
    const glm::uvec2 full = shown.picture.fullSize;
    shown.picture.mean = core::Image(2, 1, 3);
    shown.picture.preview = true;
    const app::Replay moving = screenshot(folder / "moving.png");
    EXPECT_EQ(moving.size, full);
    EXPECT_EQ(moving.samples, 0u) << "no limit";
}

}  // namespace
