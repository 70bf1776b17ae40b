// The viewer without its window: ways back to a view, what is kept between runs, what leaving would
// lose.
#include <chrono>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/session/losses.h"
#include "core/base/pcg32.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/session/desk.h"
#include "tests/support/session/session_steps.h"

namespace {

using namespace tests;

TEST(Session, HomeAndBackLeadWhereOneCameFrom)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    const core::Camera home = session.navigation.camera();
    double now = 0;
    const auto rest = [&] {
        for (now = 0; now < 1; now += 0.01) session.update(0.01, kArea);
        return session.navigation.camera();
    };
    act(session, "orbit", {{"dx", 0.1}, {"dy", 0.05}});
    const core::Camera first = rest();
    act(session, "focus");
    const core::Camera second = rest();
    EXPECT_NE(first, second);
    act(session, "previous-view");
    EXPECT_EQ(session.navigation.camera(), first);
    act(session, "previous-view");
    EXPECT_EQ(session.navigation.camera(), home);
    act(session, "next-view");
    act(session, "next-view");
    EXPECT_EQ(session.navigation.camera(), second);
    act(session, "next-view");
    EXPECT_TRUE(told(session, "no other view"));
    act(session, "home");
    EXPECT_EQ(session.navigation.camera(), home);
    act(session, "previous-view");
    EXPECT_EQ(session.navigation.camera(), second) << "home is a view that one can come back from";
}

TEST(Session, LookingAtTheWholeRoomDoesNotLeaveIt)
{
    Session session(options("hall.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    const core::World& world = *session.document()->world;
    const glm::dvec3 low(world.boundsLow), high(world.boundsHigh);
    const auto inside = [&](glm::dvec3 p) {
        return glm::all(glm::greaterThan(p, low)) && glm::all(glm::lessThan(p, high));
    };
    ASSERT_TRUE(inside(session.navigation.camera().position)) << "the test needs a room";
    for (int i = 0; i < 8; ++i) {
        act(session, "focus");
        EXPECT_TRUE(inside(session.navigation.camera().position)) << i;
        EXPECT_FALSE(session.insideSolid());
        act(session, "look", {{"dx", 0.3}, {"dy", 0.02 * i}});
        act(session, "fly", {{"forward", 1}, {"seconds", 0.1}});
        if (!inside(session.navigation.camera().position)) act(session, "home");
    }
    session.navigation.set(core::lookAt(3.0 * high, {0, 0, 0}, {0, 1, 0}, 0.7),
                           static_cast<double>(world.radius));
    act(session, "focus");
    EXPECT_FALSE(inside(session.navigation.camera().position)) << "from outside all of it is seen";
}

TEST(Session, AWallThatWasGoneThroughIsToldOnce)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    const auto tellings = [&] {
        for (double now = 0; now < 1; now += 0.01) session.update(0.01, kArea);
        uint64_t times = 0;
        for (const app::Notice& notice : session.notices.list())
            if (notice.text.find("gone through a surface") != std::string::npos)
                times += notice.times;
        return times;
    };
    const double radius = static_cast<double>(session.document()->world->radius);
    const auto fly = [&](double radii) {
        for (int i = 0; i < 20; ++i)
            act(session, "fly",
                {{"forward", radii < 0 ? -1 : 1},
                 {"seconds", std::abs(radii) * radius / 20 / session.navigation.speed()}});
    };
    act(session, "orbit", {{"dx", 0.02}});
    EXPECT_EQ(tellings(), 0u);
    fly(5);
    EXPECT_EQ(tellings(), 1u) << "the box's back";
    fly(-5);
    EXPECT_EQ(tellings(), 1u) << "it is known by now";
    act(session, "home");
    EXPECT_EQ(tellings(), 1u) << "a jump is no way";
    fly(5);
    EXPECT_EQ(tellings(), 2u);
    act(session, "previous-view");
    EXPECT_EQ(tellings(), 2u);
}

/// Drags and a wheel led back, from within a closed box whose sides are one from the origin.
TEST(Session, DragsStayWithinARoom)
{
    for (const bool pass : {false, true}) {
        Session session(options("furnace-80.gltf"));
        ASSERT_TRUE(until(session, [&] { return settled(session); }));
        const core::World& world = *session.document()->world;
        const glm::dvec3 high(world.boundsHigh), low(world.boundsLow);
        const auto inside = [&] {
            const glm::dvec3 at = session.navigation.camera().position;
            return glm::all(glm::lessThan(at, high)) && glm::all(glm::greaterThan(at, low));
        };
        ASSERT_TRUE(inside());
        if (pass) act(session, "set", {{"name", "walls"}, {"value", "pass"}});
        core::Pcg32 random(7);
        const auto uniform = [&] { return random() - 0.5; };
        int left = 0;
        for (int i = 0; i < 200; ++i) {
            const glm::dvec3 forward = session.navigation.camera().forward;
            session.orbit({uniform(), 0.3 * uniform()});
            EXPECT_NE(session.navigation.camera().forward, forward) << "it always turns";
            session.pan({uniform(), uniform()});
            session.dolly(-5 * std::abs(uniform()), {0.5, 0.5});
            left += !inside();
            if (!inside()) act(session, "home");
        }
        EXPECT_EQ(left > 0, pass) << left;
        uint64_t times = 0;
        for (const app::Notice& notice : session.notices.list())
            if (notice.text.find("a wall stops the camera") != std::string::npos)
                times += notice.times;
        EXPECT_EQ(times, pass ? 0u : 1u);
    }
}

/// Flat, of a brightness that is given.
class FlatRenderer : public tests::GreyRenderer {
public:
    explicit FlatRenderer(float value) : value_(value) {}
    void setView(const core::View& view, core::Start start) override
    {
        GreyRenderer::setView(view, start);
        size_ = view.size;
    }
    core::Estimate read(core::Reading) override
    {
        return tests::flatEstimate(size_, value_, 0.01f, std::max<uint64_t>(progress().samples, 2));
    }

private:
    float value_;
    glm::uvec2 size_{1};
};

TEST(Session, APictureFarTooBrightIsToldOnceAndExposedFor)
{
    for (const int stops : {0, 2, 5, -6}) {
        app::SessionOptions with = options("cornell-diffuse.gltf");
        with.factory = [stops](const app::RenderParams&, bool) {
            return std::make_unique<FlatRenderer>(0.18f * std::exp2(static_cast<float>(stops)));
        };
        Session session(with);
        const auto whole = [&] {
            return settled(session) && session.picture() && !session.picture()->preview &&
                   session.picture()->samples > 1;
        };
        ASSERT_TRUE(until(session, whole));
        act(session, "restart");
        for (int i = 0; i < 50; ++i) session.update(0.01, kArea);
        std::vector<std::string> told;
        for (const app::Notice& notice : session.notices.list())
            if (notice.text.find("Ctrl+E") != std::string::npos) told.push_back(notice.text);
        if (std::abs(stops) > 3) {
            ASSERT_EQ(told.size(), 1u);
            EXPECT_EQ(told[0], "the picture is " + std::to_string(std::abs(stops)) +
                                   (stops > 0 ? " stops too bright" : " stops too dark") +
                                   ": Ctrl+E exposes for it");
        } else {
            EXPECT_TRUE(told.empty()) << stops;
        }
        EXPECT_EQ(session.settings.view.exposure, 0);
        ASSERT_TRUE(until(session, whole));
        act(session, "expose");
        EXPECT_NEAR(session.settings.view.exposure, -stops, 1e-3);
    }
}

TEST(Session, TheWheelGoesWhereTheSettingSays)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "dolly", {{"steps", 2}, {"x", 0.3}, {"y", 0.8}});
    const glm::dvec3 aside = session.navigation.camera().position;
    act(session, "home");
    const core::Camera home = session.navigation.camera();
    EXPECT_GT(glm::length(glm::cross(aside - home.position, home.forward)), 0.01);
    act(session, "set", {{"name", "wheel"}, {"value", "pivot"}});
    act(session, "dolly", {{"steps", 2}, {"x", 0.3}, {"y", 0.8}});
    const glm::dvec3 ahead = session.navigation.camera().position - home.position;
    EXPECT_LT(glm::length(glm::cross(ahead, session.navigation.pivot() - home.position)), 1e-9);
}

TEST(Session, TheCamerasFrameFitsIntoANarrowArea)
{
    Session session(options("animated.gltf"));  // made for 16:9
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    const double aspect = double(kArea.x) / kArea.y;
    const core::Camera& own = session.navigation.camera();
    ASSERT_GT(own.aspect, aspect);
    EXPECT_NEAR(std::tan(0.5 * session.picture()->camera.yfov) * aspect,
                std::tan(0.5 * own.yfov) * own.aspect, 1e-9);
    EXPECT_EQ(session.placeOf(*session.picture()), (app::Area{{0, 0}, {1, 1}}));
}

/// More triangles than rays can be tried against within a frame.
fs::path heavyScene(const TemporaryFolder& folder)
{
    std::ifstream file(kAssets / "glass.gltf");
    ActionJson scene = ActionJson::parse(file);
    for (int i = 0; i < 40; ++i) {
        scene["scenes"][0]["nodes"].push_back(scene["nodes"].size());
        scene["nodes"].push_back({{"mesh", 6}});
    }
    fs::copy_file(kAssets / "glass.bin", folder / "glass.bin");
    std::ofstream(folder / "glass.gltf") << scene.dump();
    return folder / "glass.gltf";
}

TEST(Session, TheHandWaitsForNoRaysThroughManyTriangles)
{
    const TemporaryFolder folder;
    app::SessionOptions o = options("");
    o.scene.file = heavyScene(folder);
    o.scene.load.instancing = core::Instancing::flat;
    Session session(o);
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    ASSERT_FALSE(app::quickToLook(*session.document()->world)) << "the test needs more";
    const glm::dvec3 pivot = session.navigation.pivot();
    const ActionJson low{{"x", 0.5}, {"y", 0.75}};
    act(session, "focus", low);
    EXPECT_EQ(session.navigation.pivot(), pivot) << "another thread looks for it";
    ASSERT_TRUE(until(session, [&] { return session.navigation.pivot() != pivot; }));
    app::Navigation expected = session.navigation;
    expected.dollyTo(expected.pointAt({0.5, 0.75}), 1);
    act(session, "dolly", {{"steps", 1}, {"x", 0.5}, {"y", 0.75}});
    EXPECT_EQ(session.navigation.viewpoint(), expected.viewpoint());
    const app::Viewpoint near = session.navigation.viewpoint();
    act(session, "focus");
    EXPECT_EQ(session.navigation.viewpoint(), near);
    EXPECT_TRUE(until(session, [&] { return session.navigation.viewpoint() != near; }));
}

/// Updates with an area of that size until it shows a picture of `size`, ten seconds at most.
bool showsAt(Session& session, glm::uvec2 area, glm::uvec2 size)
{
    for (int i = 0; i < 1000; ++i) {
        session.update(0.01, area);
        const auto picture = session.picture();
        if (picture && picture->fullSize == size && !picture->preview &&
            picture->generation >= session.generation())
            return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
}

/// Longer than an area takes to settle.
void restAt(Session& session, glm::uvec2 area)
{
    for (int i = 0; i < 40; ++i) session.update(0.01, area);
}

constexpr glm::uvec2 kWideArea(64, 32);  // kArea once the panel is hidden

TEST(Session, ALongPictureKeepsItsSizeUntilItIsBegunAnew)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    session.muchSeconds = 0;
    uint64_t generation = session.generation();
    restAt(session, kWideArea);
    EXPECT_EQ(session.generation(), generation) << "nothing was thrown away";
    EXPECT_TRUE(told(session, "keeps its size"));
    EXPECT_EQ(session.placeOf(*session.picture()), app::whole(kArea, kWideArea));
    session.muchSeconds = 60;  // as after it has been saved
    restAt(session, kWideArea);
    EXPECT_EQ(session.generation(), generation);
    restAt(session, kArea);
    restAt(session, kWideArea);
    EXPECT_NE(session.generation(), generation) << "a moment's work follows the window";

    session.muchSeconds = 0;
    ASSERT_TRUE(showsAt(session, kWideArea, kWideArea));
    generation = session.generation();
    restAt(session, kArea);
    EXPECT_EQ(session.generation(), generation);
    act(session, "restart");
    EXPECT_TRUE(showsAt(session, kArea, kArea));
    restAt(session, kWideArea);
    EXPECT_EQ(session.picture()->fullSize, kArea);
    act(session, "set", {{"name", "max-depth"}, {"value", 3}});
    EXPECT_TRUE(showsAt(session, kWideArea, kWideArea)) << "it begins anew in any case";
    act(session, "set", {{"name", "picture-scale"}, {"value", 0.5}});
    EXPECT_TRUE(showsAt(session, kWideArea, {32, 16})) << "chosen by the hand";
}

TEST(Session, EqualTimeKeepsItsSizeAndEndsByAMotionWithAWord)
{
    for (const char* motion : {"orbit", "previous-view", "dolly"}) {
        Session session(options("cornell-diffuse.gltf"));
        ASSERT_TRUE(until(session, [&] { return settled(session); }));
        act(session, "orbit", {{"dx", 0.3}});
        ASSERT_TRUE(until(session, [&] { return settled(session) && !session.isMoving(); }));
        for (int i = 0; i < 100; ++i) session.update(0.01, kArea);
        session.compareEqualTime(session.render, session.render, 600);
        restAt(session, kWideArea);
        EXPECT_TRUE(session.equalTime().running()) << motion;
        act(session, motion, {{"dx", 0.1}, {"steps", 1}});
        session.update(0.01, kWideArea);
        EXPECT_FALSE(session.equalTime().running()) << motion;
        EXPECT_TRUE(told(session, "the view has changed")) << motion;
    }
}

TEST(Session, LettersOfOneRunAreNotKept)
{
    const tests::TemporaryFolder folder;
    app::SessionOptions o = options("");
    o.settings = folder / "settings.json";
    const auto scale = [&](float given, double set) {
        o.uiScale = given;
        Session session(o);
        const float shown = session.settings.panels.uiScale;
        if (set > 0) act(session, "set", {{"name", "ui-scale"}, {"value", set}});
        return shown;
    };
    EXPECT_EQ(scale(0, 1.5), 0);
    EXPECT_EQ(scale(2, 0), 2);
    EXPECT_EQ(scale(0, 0), 1.5f) << "the 2 was for one run";
    EXPECT_EQ(scale(2, 1.25), 2);
    EXPECT_EQ(scale(0, 0), 1.25f) << "what the hand sets is kept";
}

TEST(Session, SectionsOfThePanelAreKept)
{
    const tests::TemporaryFolder folder;
    app::SessionOptions o = options("");
    o.settings = folder / "settings.json";
    {
        Session session(o);
        act(session, "set", {{"name", "section-camera"}, {"value", true}});
        act(session, "set", {{"name", "panel-side"}, {"value", "right"}});
    }
    const Session session(o);
    EXPECT_TRUE(session.settings.sections.camera);
    EXPECT_EQ(session.settings.panels.side, app::PanelSide::right);
}

TEST(Session, SettingsAreWrittenWhileItRuns)
{
    const tests::TemporaryFolder folder;
    app::SessionOptions o = options("");
    o.settings = folder / "settings.json";
    Session session(o);
    act(session, "set", {{"name", "panel-side"}, {"value", "right"}});
    session.update(4, kArea);
    ASSERT_TRUE(until(session, [&] { return std::filesystem::exists(o.settings); }));
    Session other(o);
    EXPECT_EQ(other.settings.panels.side, app::PanelSide::right);
}

TEST(Session, AStartShowsThePanel)
{
    const tests::TemporaryFolder folder;
    app::SessionOptions o = options("");
    o.settings = folder / "settings.json";
    {
        Session session(o);
        act(session, "panel");
        EXPECT_FALSE(session.settings.panels.panel);
    }
    EXPECT_TRUE(Session(o).settings.panels.panel);
}

TEST(Session, LeavingAsksForWhatTookLongAndIsNotSaved)
{
    const tests::TemporaryFolder folder;
    Session session(options("cornell-diffuse.gltf"));
    EXPECT_TRUE(app::lossesOf(session).empty());
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    EXPECT_TRUE(app::lossesOf(session).empty()) << "a moment's work";
    EXPECT_GT(session.unsavedSeconds(), 0);
    auto stored = std::make_shared<app::Picture>(*session.picture());
    stored->seconds = 59;
    session.slots[0] = {stored, "A"};
    EXPECT_TRUE(app::lossesOf(session).empty());
    stored->seconds = 61;
    ASSERT_EQ(app::lossesOf(session).size(), 1u);
    EXPECT_EQ(app::lossesOf(session)[0].text, "picture A: 61 seconds of rendering");
    act(session, "set", {{"name", "spp-limit"}, {"value", 3}});
    ASSERT_TRUE(until(session, [&] { return settled(session) && session.picture()->finished; }));
    act(session, "save", {{"file", (folder / "kept.exr").string()}});
    ASSERT_TRUE(until(session, [&] { return told(session, "kept.exr: saved"); }));
    EXPECT_EQ(session.unsavedSeconds(), 0);
    act(session, "restart");
    ASSERT_TRUE(until(session, [&] { return settled(session) && session.picture()->finished; }));
    EXPECT_EQ(session.unsavedSeconds(), session.picture()->seconds) << "however long it took";
    EXPECT_EQ(app::spanText(75.4), "75 seconds");
    EXPECT_EQ(app::spanText(180), "3 minutes");
    EXPECT_EQ(app::spanText(9000), "2.5 hours");
}

TEST(Session, TurnsAboutWhatIsClicked)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "focus", {{"x", 0.5}, {"y", 0.5}});
    const glm::dvec3 pivot = session.navigation.pivot();
    const core::Camera& camera = session.navigation.camera();
    const glm::dvec3 ahead = glm::normalize(pivot - camera.position);
    EXPECT_GT(glm::dot(ahead, camera.forward), 0.999)
        << "the middle of the picture lies straight ahead";
    for (const float extent :
         {session.document()->world->boundsLow.z - static_cast<float>(pivot.z)})
        EXPECT_LE(extent, 1e-3f);
}

/// The instant of the scene's animation that has been asked for is on show.
bool posed(const Session& session)
{
    return session.document()->time == session.player.time && session.settled();
}

TEST(Session, AnAnimationLeavesTheCameraThatOneBeganWith)
{
    const TemporaryFolder folder;
    const fs::path file = folder / "camera.json";
    std::ofstream(file) << R"({"position": [2, 1, 4], "target": [0, 1, 0]})";
    app::SessionOptions o = options("animated.gltf");
    o.camera = file.string();
    Session session(o);
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    const core::Camera camera = session.navigation.camera();
    ASSERT_NE(camera, session.document()->world->cameras.front());
    act(session, "animation", {{"time", 0.5}});
    ASSERT_TRUE(until(session, [&] { return posed(session); }));
    EXPECT_EQ(session.navigation.camera(), camera);
    EXPECT_EQ(session.homeCamera(), camera);

    act(session, "orbit", {{"dx", 0.2}});
    const core::Camera turned = session.navigation.camera();
    act(session, "environment", {{"what", "plain"}});
    ASSERT_TRUE(until(session, [&] { return session.document()->environment == "plain"; }));
    act(session, "animation", {{"time", 1.0}});
    ASSERT_TRUE(until(session, [&] { return posed(session); }));
    EXPECT_EQ(session.navigation.camera(), turned);
    EXPECT_EQ(session.homeCamera(), camera);
}

TEST(Session, AnAnimatedCameraIsFollowedAlsoWhereItWasAskedFor)
{
    for (const char* name : {"", "0", "camera"}) {
        app::SessionOptions o = options("animated.gltf");
        o.camera = name;
        Session session(o);
        ASSERT_TRUE(until(session, [&] { return settled(session); }));
        const core::Camera before = session.navigation.camera();
        act(session, "environment", {{"what", "plain"}});
        ASSERT_TRUE(until(session, [&] { return session.document()->environment == "plain"; }));
        act(session, "animation", {{"time", 0.5}});
        ASSERT_TRUE(until(session, [&] { return posed(session); }));
        EXPECT_EQ(session.navigation.camera(), session.document()->world->cameras.front()) << name;
        EXPECT_NE(session.navigation.camera(), before) << name;
    }
}

}  // namespace
