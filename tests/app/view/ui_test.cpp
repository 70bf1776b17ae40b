// The panel without a window: Dear ImGui with no back end over a real session with a made-up
// renderer, in every state that the session can be in, in windows of every size. Dear ImGui's own
// assertions are part of the test; on top of them everything must lie inside the window, and
// nothing may use an action that does not exist.
#include <sstream>

#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>

#include "app/view/ui/ui_parts.h"
#include "tests/support/session/desk.h"

namespace {

using namespace tests;

TEST(Ui, NothingToShow)
{
    Desk desk(deskOptions());
    openEverything(desk);
    desk.frames(5);
    EXPECT_FALSE(desk.hasPicture());
    EXPECT_TRUE(desk.windows().contains("Rekindle###panel"));
    EXPECT_TRUE(desk.windows().contains("##status"));
}

TEST(Ui, EverySectionInEverySize)
{
    struct Size {
        ImVec2 window;
        float scale;
    };
    for (const Size& size :
         {Size{{1280, 720}, 1}, Size{{640, 360}, 1}, Size{{320, 200}, 1}, Size{{3840, 2160}, 2},
          Size{{640, 360}, 3}, Size{{40, 30}, 1}, Size{{1, 1}, 1}}) {
        SCOPED_TRACE(testing::Message()
                     << size.window.x << " x " << size.window.y << " at " << size.scale);
        Desk desk(deskOptions("animated.gltf"), size.window, size.scale);
        openEverything(desk);
        ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
        desk.frames(5);
    }
}

TEST(Ui, SmallWindowsLeaveRoomForThePicture)
{
    {
        Desk desk(deskOptions("animated.gltf"), {640, 360});
        openEverything(desk);
        desk.frames(3);
        const ImGuiWindow* panel = ImGui::FindWindowByName("Rekindle###panel");
        ASSERT_NE(panel, nullptr);
        EXPECT_LT(panel->Size.x, 0.45f * 640);
        EXPECT_EQ(panel->Size.x + desk.loop.layout.picture.size.x, 640);
        EXPECT_FALSE(desk.windows().contains("Error over time###plot"));
    }
    Desk desk(deskOptions("animated.gltf"), {320, 200});
    desk.frames(3);
    EXPECT_FALSE(desk.windows().contains("Rekindle###panel"));
    EXPECT_TRUE(desk.windows().contains("##status")) << "where a button opens it";
}

/// It would cover a third of the picture. The settings keep that it is wanted elsewhere.
TEST(Ui, ASmallWindowHasThePlotOnlyWhenItIsAskedFor)
{
    Desk desk(deskOptions("animated.gltf"), {640, 480});
    desk.session.settings.panels.fold = app::PanelFold::folded;
    const auto toggled = [&] {
        app::runAction("plot", desk.session, desk.requests);
        desk.frames(3);
        return desk.windows().contains("Error over time###plot");
    };
    desk.frames(3);
    EXPECT_FALSE(desk.windows().contains("Error over time###plot"));
    EXPECT_TRUE(desk.session.settings.panels.plot);
    EXPECT_TRUE(toggled());
    EXPECT_FALSE(toggled());
    EXPECT_TRUE(toggled());
}

TEST(Ui, WindowsFollowTheirEdgesThroughResizes)
{
    Desk desk(deskOptions("animated.gltf"));
    openEverything(desk);
    ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
    const ImGuiWindow* plot = ImGui::FindWindowByName("Error over time###plot");
    ASSERT_NE(plot, nullptr);
    const float gap = 1280 - plot->Pos.x - plot->Size.x;
    ImGui::GetIO().DisplaySize = {1920, 1080};
    desk.frames(3);
    EXPECT_NEAR(1920 - plot->Pos.x - plot->Size.x, gap, 1);
    for (const ImVec2 size :
         {ImVec2{100, 900}, ImVec2{2000, 60}, ImVec2{1, 1}, ImVec2{1280, 720}}) {
        ImGui::GetIO().DisplaySize = size;
        desk.frames(3);
    }
}

TEST(Ui, EveryViewEveryState)
{
    Desk desk(deskOptions("animated.gltf"));
    openEverything(desk);
    ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
    app::Session& session = desk.session;
    for (uint32_t show = 0; show < core::enumNames<app::Show>().size(); ++show) {
        session.settings.view.show = static_cast<app::Show>(show);
        desk.loop.scale = {show > 6, 0.001f, 5, show == 8, show == 9, "a scale"};
        desk.loop.problem = show == 10 ? "there is no reference" : "";
        desk.frames(2);
        EXPECT_EQ(desk.windows().contains("##colour bar"), show > 6);
    }
    session.storeSlot(0);
    session.comparing = true;
    desk.frames(2);
    EXPECT_TRUE(desk.windows().contains("##slider"));
    session.track.add(session.navigation.camera());
    session.track.add(session.navigation.camera());
    session.track.play();
    session.paused = true;
    session.render.method.as<core::PathParams>().clampIndirect = 3;
    session.render.sppLimit = 10;
    session.render.secondsLimit = 2;
    session.render.errorLimit = 0.5;
    desk.frames(3);
    session.compareEqualTime(session.render, session.render, 0.05);
    desk.frames(3);
    EXPECT_TRUE(desk.windows().contains("##progress"));
    session.cancel();
    session.settings.panels.panel = false;
    desk.frames(3);
    EXPECT_FALSE(desk.windows().contains("Rekindle###panel"));
    EXPECT_FALSE(desk.windows().contains("##status"));
}

TEST(Ui, ErrorsStayUntilTheyAreClosedAndNewsFade)
{
    Desk desk(deskOptions());
    desk.session.notices.tell(app::Severity::news, "saved");
    std::string longText(3000, 'x');
    longText.append("\nscene.gltf: /meshes/3: is wrong");
    desk.session.notices.tell(app::Severity::error, longText);
    for (int i = 0; i < 20; ++i)
        desk.session.notices.tell(app::Severity::warning, "warning " + std::to_string(i));
    desk.frames(2);
    EXPECT_TRUE(desk.windows().contains("##toast22"));
    desk.frames(60 * 15);
    EXPECT_FALSE(desk.windows().contains("##toast1"));
    EXPECT_TRUE(desk.windows().contains("##toast2"));
    EXPECT_FALSE(desk.windows().contains("##toast22"));
}

TEST(Ui, ToastsTakeAThirdOfTheHeightAtMostAndLeaveTitlesFree)
{
    Desk desk(deskOptions(), {640, 400});
    desk.session.settings.panels.help = true;
    for (int i = 0; i < 6; ++i)
        desk.session.notices.tell(app::Severity::error, "scene.gltf: /meshes/" + std::to_string(i) +
                                                            ": " + std::string(400, 'x'));
    desk.frames(4);
    float top = 400, end = 0, bar = 0;
    for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows) {
        if (!window->Active || window->Hidden) continue;
        if (std::string(window->Name).starts_with("##toast")) {
            top = std::min(top, window->Pos.y);
            end = std::max(end, window->Pos.y + window->Size.y);
        }
        if (std::string(window->Name).ends_with("###help"))
            bar = window->Pos.y + window->TitleBarHeight();
    }
    EXPECT_GT(bar, 0);
    EXPECT_GE(top, bar);
    EXPECT_LE(end - top, 400 / 3 + 1);
}

TEST(Ui, FilesThatAreSavedOneAfterTheOtherAreOneToast)
{
    Desk desk(deskOptions());
    for (int i = 0; i < 5; ++i) {
        const std::string file = "/tmp/shot-" + std::to_string(i) + ".png";
        desk.session.notices.tell(app::Severity::news, file + ": saved", file);
        desk.frames(2);
    }
    EXPECT_TRUE(desk.windows().contains("##toast5"));
    for (int i = 1; i < 5; ++i)
        EXPECT_FALSE(desk.windows().contains("##toast" + std::to_string(i))) << i;
}

TEST(Ui, FailuresOfTheRendererAreTold)
{
    app::SessionOptions failing = deskOptions("animated.gltf");
    failing.factory = [](const app::RenderParams&, bool) {
        return std::make_unique<FailingRenderer>();
    };
    Desk desk(failing);
    openEverything(desk);
    EXPECT_TRUE(desk.framesUntil([&] { return desk.session.rendering().errorCount > 0; }));
    desk.frames(3);
}

TEST(Ui, ViewsAndTheHeldReferenceSayWhatTheyAre)
{
    Desk desk(deskOptions("animated.gltf"));
    ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
    const auto written = [&] {
        desk.frames(2);
        return ImGui::GetBackgroundDrawList()->VtxBuffer.Size > 0;
    };
    EXPECT_FALSE(written());
    for (uint32_t show = 1; show < core::enumNames<app::Show>().size(); ++show) {
        desk.session.settings.view.show = static_cast<app::Show>(show);
        EXPECT_TRUE(written()) << show;
        EXPECT_NE(app::captionOf(desk.session.settings.view.show),
                  app::captionOf(app::Show::color));
    }
    desk.loop.problem = "there is no reference";
    EXPECT_FALSE(written()) << "what is shown is not what was asked for";
    desk.loop.problem.clear();
    desk.session.settings.panels.panel = false;
    EXPECT_FALSE(written());
}

TEST(Ui, ViewsOfFirstHitsSayWhatIsBlack)
{
    core::World world;
    using app::Show;
    EXPECT_EQ(app::blackMeans(Show::color, &world), "");
    EXPECT_EQ(app::blackMeans(Show::material, nullptr), "; black: nothing hit");
    EXPECT_EQ(app::blackMeans(Show::emitter, &world), "; black: nothing emits light");
    world.emitters = std::vector<shared::Emitter>(1);
    world.environmentEmitter = 0;
    EXPECT_EQ(app::blackMeans(Show::emitter, &world), "; black: only the sky shines");
    world.emitters = std::vector<shared::Emitter>(2);
    EXPECT_EQ(app::blackMeans(Show::emitter, &world), "; black: no emitter");
}

TEST(Ui, SaysWhatTheSecondsOfAPictureCount)
{
    app::Picture picture;
    picture.fullSize = {640, 360};
    picture.mean = core::Image(160, 90, 3);
    picture.preview = true;
    const std::string small = app::secondsMean(picture);
    EXPECT_NE(small.find("the full one counts anew"), std::string::npos);
    EXPECT_NE(app::previewMeans(picture).find("160 x 90"), std::string::npos);
    EXPECT_NE(app::previewMeans(picture).find("or until"), std::string::npos)
        << "small pictures come before a full one at rest, too";
    picture.fraction = 0.4;
    EXPECT_EQ(app::secondsMean(picture), small);
    picture.mean = core::Image(640, 360, 3);  // a part of the first sample
    EXPECT_NE(app::secondsMean(picture), small);
    picture.fraction = 0;  // in motion
    EXPECT_EQ(app::secondsMean(picture), small);
}

TEST(Ui, TheColourBarIsNotUnderThePlot)
{
    Desk desk(deskOptions("animated.gltf"), {1000, 700});
    ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
    desk.session.settings.view.show = app::Show::error;
    desk.loop.scale = {true, 0, 0.5f, false, false, "relative error of luminance"};
    const auto apart = [&] {
        desk.frames(4);
        const ImGuiWindow *plot = ImGui::FindWindowByName("Error over time###plot"),
                          *bar = ImGui::FindWindowByName("##colour bar");
        if (plot == nullptr || bar == nullptr || !plot->Active || !bar->Active) return false;
        return !plot->Rect().Overlaps(bar->Rect());
    };
    EXPECT_TRUE(apart());
    for (const float x : {300.0f, 400.0f, 500.0f, 600.0f}) {
        ImGui::SetWindowPos("Error over time###plot", {x, 400});
        EXPECT_TRUE(apart()) << x;
    }
}

TEST(Ui, AClickOnANoticeCopiesThePathOfItsFile)
{
    Desk desk(deskOptions());
    desk.session.notices.tell(app::Severity::news, "/tmp/shot.png: saved", "/tmp/shot.png");
    desk.frames(3);
    const ImGuiWindow* toast = ImGui::FindWindowByName("##toast1");
    ASSERT_NE(toast, nullptr);
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {toast->Pos.x + 10, toast->Pos.y + 10};
    desk.frames(2);
    io.MouseDown[0] = true;
    desk.frames(2);
    io.MouseDown[0] = false;
    desk.frames(2);
    EXPECT_STREQ(ImGui::GetClipboardText(), "/tmp/shot.png");
    EXPECT_TRUE(desk.windows().contains("##toast1")) << "it says so";
}

TEST(Ui, ErrorsOfBothSidesStandInTheSectionThatCompares)
{
    Desk desk(deskOptions("animated.gltf"));
    openEverything(desk);
    ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
    app::RenderParams b = desk.session.render;
    b.method.as<core::PathParams>().maxDepth = 2;
    desk.session.compareEqualTime(desk.session.render, b, 0.05);
    ASSERT_TRUE(desk.framesUntil([&] { return desk.session.comparison() != nullptr; }));
    EXPECT_EQ(desk.session.comparison()->source, app::PictureComparison::Source::variance);
    desk.frames(3);
    app::runAction("copy-comparison", desk.session, desk.requests);
    ASSERT_TRUE(desk.requests.toClipboard);
    EXPECT_NE(desk.requests.toClipboard->find("depth 2"), std::string::npos);
}

TEST(Ui, ValuesOfAReferenceAreToldInItsOwnViewOnly)
{
    Desk desk(deskOptions("animated.gltf"));
    ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
    app::Session& session = desk.session;
    ImGuiIO& io = ImGui::GetIO();
    const app::Area& area = desk.loop.layout.picture;
    io.MousePos = {area.corner.x + area.size.x / 2, area.corner.y + area.size.y / 2};
    app::sendKey(*app::findKey("Alt"), true);
    // How high the lines are, once all of them are known.
    const auto height = [&]() -> float {
        const bool known = desk.framesUntil([&] {
            const auto picture = session.picture();
            return picture->generation >= session.generation() && !picture->preview &&
                   picture->variance && picture->aovs;
        });
        EXPECT_TRUE(known);
        desk.frames(3);
        const ImGuiWindow* lines = ImGui::FindWindowByName("##Tooltip_00");
        return lines != nullptr && lines->Active ? lines->ContentSize.y : 0;
    };
    const float without = height();
    ASSERT_GT(without, 0);
    session.keepAsReference();
    ASSERT_TRUE(desk.framesUntil([&] { return session.reference() != nullptr; }));
    EXPECT_GT(height(), without);
    app::runAction("orbit", session, desk.requests, {{"dx", 0.3}});
    desk.frames(3);
    ASSERT_TRUE(session.reference());
    EXPECT_EQ(height(), without) << "the place under the mouse is another";
}

/// Values of the pixel in the middle, as lines.
float inspectorHeight(Desk& desk)
{
    ImGuiIO& io = ImGui::GetIO();
    const app::Area& area = desk.loop.layout.picture;
    io.MousePos = {area.corner.x + area.size.x / 2, area.corner.y + area.size.y / 2};
    desk.frames(3);
    const ImGuiWindow* lines = ImGui::FindWindowByName("##Tooltip_00");
    return lines != nullptr && lines->Active ? lines->ContentSize.y : 0;
}

TEST(Ui, ValuesAreThoseOfThePicturesOnShow)
{
    Desk desk(deskOptions("animated.gltf"));
    ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
    app::Session& session = desk.session;
    app::sendKey(*app::findKey("Alt"), true);
    desk.frames(2);
    ASSERT_TRUE(desk.framesUntil([&] {
        return session.picture()->variance && session.picture()->aovs && !session.isMoving();
    }));
    session.paused = true;
    desk.frames(30);
    const float alone = inspectorHeight(desk);
    ASSERT_GT(alone, 0);
    // A picture without a variance and first hits: fewer lines where it is on show.
    auto bare = std::make_shared<app::Picture>(*session.picture());
    bare->variance.reset();
    bare->aovs.reset();
    session.slots[0] = {bare, "A"};
    session.comparing = true;
    session.settings.view.compareAt = 0.25f;
    const float besideB = inspectorHeight(desk);
    EXPECT_GT(besideB, alone) << "A and B, the first hits of B";
    session.settings.view.compareAt = 0.75f;
    EXPECT_LT(inspectorHeight(desk), besideB) << "A is under the cursor, which has no first hits";
    session.comparing = false;
    session.keepAsReference();
    ASSERT_TRUE(desk.framesUntil([&] { return session.reference() != nullptr; }));
    const float both = inspectorHeight(desk);
    session.holdReference = true;
    EXPECT_LT(inspectorHeight(desk), both) << "the reference alone";
}

TEST(Ui, TextIsWrappedAtSpacesAlone)
{
    Desk desk(deskOptions());
    ImGui::NewFrame();
    const std::string text = "a reference (.exr), a camera path (.json)\nand more";
    EXPECT_EQ(app::wrappedAtSpaces(text, 10000), text);
    EXPECT_EQ(app::wrappedAtSpaces("", 10), "");
    for (float room = 20; room < 320; room += 7) {
        const std::string lines = app::wrappedAtSpaces(text, room);
        ASSERT_EQ(lines.size(), text.size());
        for (size_t i = 0; i < text.size(); ++i)
            EXPECT_TRUE(lines[i] == text[i] || (text[i] == ' ' && lines[i] == '\n')) << lines;
        std::istringstream each(lines);
        for (std::string line; std::getline(each, line);)
            EXPECT_TRUE(ImGui::CalcTextSize(line.c_str()).x <= room ||
                        line.find(' ') == std::string::npos)
                << line;
    }
    ImGui::Render();
}

TEST(Ui, LabelsAreCutInNoPanel)
{
    Desk desk(deskOptions());
    ImGui::NewFrame();
    const float letter = ImGui::GetFontSize();
    EXPECT_FALSE(app::labelStandsAbove("tone", 23 * letter));
    EXPECT_TRUE(app::labelStandsAbove("tone", 14 * letter)) << "the same for all of a narrow panel";
    EXPECT_TRUE(app::labelStandsAbove("a label of far too many words", 23 * letter));
    ImGui::Render();
}

TEST(Ui, ShortenedLabelsHaveRoomAndWholeLetters)
{
    Desk desk(deskOptions());
    ImGui::NewFrame();
    const std::string text = "noise of the r\xC3\xA9"
                             "f\xC3\xA9rence";
    EXPECT_EQ(app::shortenedLabel(text, 1000), text);
    for (float room = 30; room < 200; room += 3) {
        const std::string label = app::shortenedLabel(text, room);
        EXPECT_LE(ImGui::CalcTextSize(label.c_str()).x, room) << label;
        if (label == text) continue;
        ASSERT_TRUE(label.ends_with("..."));
        EXPECT_TRUE(text.starts_with(label.substr(0, label.size() - 3)));
        EXPECT_NE(label[label.size() - 4], '\xC3') << label;
    }
    ImGui::Render();
}

}  // namespace
