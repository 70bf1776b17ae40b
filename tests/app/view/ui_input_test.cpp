// What the hand does to the panel: keys, lists, boxes, the edge, windows that are moved.
#include <filesystem>

#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>

#include "app/view/imgui/windows.h"
#include "app/view/input.h"
#include "app/view/ui/ui_parts.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/session/desk.h"

namespace {

using namespace tests;
namespace fs = std::filesystem;

void click(Desk& desk, ImVec2 place)
{
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = place;
    desk.frames(2);
    io.MouseDown[0] = true;
    desk.frames(2);
    io.MouseDown[0] = false;
    desk.frames(2);
}

TEST(Ui, QuestionBeforeQuitting)
{
    Desk desk(deskOptions());
    desk.requests.askQuit = true;
    desk.frames(3);
    EXPECT_FALSE(desk.requests.askQuit);
    EXPECT_FALSE(desk.requests.quit);
    EXPECT_TRUE(desk.windows().contains("Quit?###quit"));
    desk.key(kEscape);
    EXPECT_FALSE(desk.windows().contains("Quit?###quit"));
    EXPECT_FALSE(desk.requests.quit || desk.requests.leave);
}

TEST(Ui, WhatWouldBeLostIsAskedForBeforeAnAction)
{
    Desk desk(deskOptions("animated.gltf"));
    ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
    desk.session.muchSeconds = 0;
    desk.session.storeSlot(0);
    ASSERT_TRUE(desk.framesUntil([&] {
        const auto& stored = desk.session.slots[0].picture;
        return stored->variance && desk.session.picture()->samples > stored->samples;
    }));
    const auto isAsked = [&] {
        for (const std::string& name : desk.windows())
            if (name == "What is being rendered as A?###question") return true;
        return false;
    };
    app::runByHand("live-a", desk.session, desk.requests);
    desk.frames(3);
    EXPECT_FALSE(desk.requests.question);
    EXPECT_TRUE(isAsked());
    desk.key(kEscape);
    EXPECT_FALSE(isAsked());
    EXPECT_TRUE(desk.session.slots[0].picture);
    app::runByHand("live-a", desk.session, desk.requests);
    desk.frames(3);
    const ImGuiWindow* question = ImGui::FindWindowByName("###question");
    ASSERT_NE(question, nullptr);
    const float save = ImGui::CalcTextSize("Save and go on").x;
    click(desk, {question->Pos.x + save + 60, question->Pos.y + question->Size.y - 16});
    EXPECT_FALSE(isAsked());
    EXPECT_FALSE(desk.session.slots[0].picture);
}

TEST(Ui, TheQuestionMakesItselfRoom)
{
    Desk desk(deskOptions(), {500, 30});
    desk.requests.askQuit = true;
    desk.frame();
    EXPECT_TRUE(desk.requests.askQuit) << "it has not been asked";
    ASSERT_TRUE(desk.requests.resize);
    const glm::uvec2 size = *desk.requests.resize;
    EXPECT_GE(size.x, 500u);
    ImGui::GetIO().DisplaySize = {float(size.x), float(size.y)};
    desk.frames(3);
    EXPECT_FALSE(desk.requests.askQuit);
    EXPECT_TRUE(desk.windows().contains("Quit?###quit"));
}

/// Esc as the window's loop takes it: the key runs the action, unless ImGui wants the keyboard.
void escape(Desk& desk)
{
    desk.requests.escape = true;
    desk.frames(2);
    EXPECT_FALSE(desk.requests.escape);
}

TEST(Ui, EscClosesWhatIsOpenBeforeItLeaves)
{
    Desk desk(deskOptions());
    desk.session.settings.panels.help = true;
    desk.requests.openPathBox = true;
    desk.frames(3);
    desk.type("/");
    escape(desk);
    EXPECT_FALSE(desk.windows().contains("Open a scene###open"));
    EXPECT_TRUE(desk.session.settings.panels.help);
    escape(desk);
    EXPECT_FALSE(desk.session.settings.panels.help);
    desk.session.flying = true;
    escape(desk);
    EXPECT_FALSE(desk.session.flying);
    EXPECT_FALSE(desk.requests.leave);
    escape(desk);
    EXPECT_TRUE(desk.requests.leave);
}

TEST(Ui, TheButtonOfAStripCancelsItsOwnWork)
{
    Desk desk(deskOptions("animated.gltf"));
    ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
    app::Session& session = desk.session;
    app::runAction("reference", session, desk.requests, {{"spp", 1000000}});
    ASSERT_TRUE(desk.framesUntil([&] { return session.coreThread().seconds > 0.6; }));
    session.compareEqualTime(session.render, session.render, 60);
    desk.frames(3);
    ASSERT_EQ(session.works().size(), 2u);
    const ImGuiWindow* strips = ImGui::FindWindowByName("##progress");
    ASSERT_TRUE(strips != nullptr && strips->Active);
    const float right = strips->Pos.x + strips->Size.x - 20;
    click(desk, {right, strips->Pos.y + strips->Size.y - 16});  // the older one stands below
    EXPECT_FALSE(session.coreThread().active());
    EXPECT_TRUE(session.equalTime().running());
    session.cancel();
}

TEST(Ui, EscClosesAnOpenList)
{
    Desk desk(deskOptions());
    const auto frame = [&](bool open, bool close) {
        ImGui::NewFrame();
        const bool closed = close && app::closeInnermostPopup();
        if (open) ImGui::OpenPopup("a list");
        const bool shown = ImGui::BeginPopup("a list");
        if (shown) ImGui::EndPopup();
        ImGui::Render();
        return std::pair(shown, closed);
    };
    ImGui::GetIO().DeltaTime = 1 / 60.0f;
    EXPECT_TRUE(frame(true, false).first);
    EXPECT_TRUE(frame(false, false).first);
    EXPECT_EQ(frame(false, true), std::pair(false, true));
    EXPECT_EQ(frame(false, true), std::pair(false, false));
}

/// The plot's window appears with a field in it; a click beside a field gives its window the focus.
TEST(Ui, TabGoesIntoNoFieldThatNobodyTypesInto)
{
    Desk desk(deskOptions("animated.gltf"));
    ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
    const auto taken = [&] {
        desk.key(kTab);
        desk.frames(3);
        return ImGui::GetIO().WantCaptureKeyboard;
    };
    ASSERT_TRUE(desk.windows().contains("Error over time###plot"));
    EXPECT_FALSE(taken());
    for (const char* name : {"Error over time###plot", "Rekindle###panel"}) {
        const ImGuiWindow* window = ImGui::FindWindowByName(name);
        ASSERT_NE(window, nullptr);
        click(desk, {window->Pos.x + 3, window->Pos.y + window->Size.y / 2});
        EXPECT_FALSE(taken()) << name;
    }
    desk.session.settings.panels.help = true;
    desk.frames(3);
    EXPECT_FALSE(taken());
}

TEST(Ui, PathBoxOpensWithoutThePanel)
{
    Desk desk(deskOptions());
    desk.session.settings.panels.panel = false;
    desk.requests.openPathBox = true;
    desk.frames(3);
    EXPECT_FALSE(desk.requests.openPathBox);
    EXPECT_TRUE(desk.windows().contains("Open a scene###open"));
    EXPECT_TRUE(ImGui::GetIO().WantCaptureKeyboard) << "what is typed goes to the line";
}

TEST(Ui, PathBoxCompletesAndLoads)
{
    Desk desk(deskOptions());
    desk.session.settings.panels.panel = false;
    desk.requests.openPathBox = true;
    desk.frames(3);
    desk.type(REKINDLE_SOURCE_DIR "/assets/animated.g");
    desk.key(kTab);
    desk.frames(2);
    desk.key(kEnter);
    EXPECT_FALSE(desk.windows().contains("Open a scene###open"));
    EXPECT_TRUE(desk.framesUntil([&] { return desk.session.document() != nullptr; }));
    EXPECT_EQ(desk.session.document()->file.filename(), "animated.gltf");
}

TEST(Ui, TheBrowserWalksFoldersByTheKeyboard)
{
    const tests::TemporaryFolder folder;
    fs::create_directories(folder / "rooms" / "deep");
    for (const char* name : {"hall.gltf", "hall.bin"})
        fs::copy_file(fs::path(REKINDLE_SOURCE_DIR "/assets") / name, folder / "rooms" / name);
    fs::copy_file(folder / "rooms" / "hall.gltf", folder / "rooms" / "attic.gltf");
    Desk desk(deskOptions());
    desk.session.settings.panels.panel = false;
    desk.requests.openPathBox = true;
    desk.frames(3);
    desk.type(folder.path().string() + "/");  // in place of what stood there
    desk.frames(2);
    for (int i = 0; i < 2; ++i) desk.key(kDown);  // "..", then the only folder
    desk.key(kEnter);
    desk.frames(3);
    EXPECT_TRUE(desk.windows().contains("Open a scene###open"));
    EXPECT_EQ(desk.session.document(), nullptr);
    desk.type("ha");  // goes on behind the folder
    desk.frames(2);
    desk.key(kEnter);
    EXPECT_FALSE(desk.windows().contains("Open a scene###open"));
    EXPECT_TRUE(desk.framesUntil([&] { return desk.session.document() != nullptr; }));
    EXPECT_EQ(desk.session.document()->file, folder / "rooms" / "hall.gltf");
}

TEST(Ui, AClickOnATileOpensWhatWasOpenBefore)
{
    const tests::TemporaryFolder folder;
    app::SessionOptions with = deskOptions();
    with.cacheFolder = folder.path();
    const fs::path hall = fs::path(REKINDLE_SOURCE_DIR "/assets/hall.gltf");
    app::SmallPicture white;
    white.bytes.assign(3 * app::SmallPicture::kWidth * app::SmallPicture::kHeight, 255);
    app::ScenePictures(folder.path()).keep(hall, white);
    Desk desk(with);
    desk.session.settings.recentFiles = {hall.string(), "/gone/\u00e4" + std::string(60, 'x')};
    desk.requests.openPathBox = true;
    desk.frames(3);
    const ImGuiWindow* window = ImGui::FindWindowByName("Open a scene###open");
    ASSERT_NE(window, nullptr);
    const auto vertices = window->DrawList->VtxBuffer.Size;
    EXPECT_GT(vertices, int(app::SmallPicture::kWidth * app::SmallPicture::kHeight))
        << "the picture of the first";
    EXPECT_LT(vertices, 2 * int(app::SmallPicture::kWidth * app::SmallPicture::kHeight))
        << "the other has none";
    ImGuiIO& io = ImGui::GetIO();
    const float letter = ImGui::GetFontSize();
    io.MousePos = {window->Pos.x + 4 * letter, window->Pos.y + window->Size.y - 4 * letter};
    desk.frames(2);
    io.MouseDown[0] = true;
    desk.frames(2);
    io.MouseDown[0] = false;
    desk.frames(2);
    EXPECT_FALSE(desk.windows().contains("Open a scene###open"));
    EXPECT_TRUE(desk.framesUntil([&] { return desk.session.document() != nullptr; }));
    EXPECT_EQ(desk.session.document()->file, hall);
}

TEST(Ui, WholeNumbersCanBeTyped)
{
    Desk desk(deskOptions());
    uint64_t value = 0;
    for (int i = 0; i < 12; ++i) {
        ImGui::GetIO().DeltaTime = 1 / 60.0f;
        if (i == 7) ImGui::GetIO().AddInputCharactersUTF8("64");
        ImGui::NewFrame();
        ImGui::Begin("typed");
        if (i == 2) ImGui::SetKeyboardFocusHere();
        app::countInput("##value", value, "no limit");
        ImGui::End();
        ImGui::Render();
    }
    EXPECT_EQ(value, 64u) << "what is typed replaces the 0, which was selected";
}

TEST(Ui, WindowsComeBackWhereTheyWerePut)
{
    std::string places;
    {
        Desk desk(deskOptions());
        desk.session.settings.panels.log = true;
        desk.frames(3);
        ImGui::SetWindowPos("Messages###log", {501, 203});
        desk.frames(2);
        desk.ui.keepPlaces(desk.session);
        places = desk.session.settings.places;
        EXPECT_NE(places.find("###log"), std::string::npos) << places;
    }
    for (const std::string& text :
         {places, "[Window][###log]\nPos=99999999,-5\nSize=" + std::string(5000, '9'),
          std::string("[[[[\n\0x]", 8)}) {
        Desk desk(deskOptions());
        desk.session.settings.panels.log = true;
        desk.session.settings.places = text;
        desk.frames(3);  // and wherever that is, it lies in the window
        const ImGuiWindow* log = ImGui::FindWindowByName("Messages###log");
        ASSERT_NE(log, nullptr);
        if (text == places) {
            EXPECT_EQ(log->Pos.x, 501);
            EXPECT_EQ(log->Pos.y, 203);
        }
    }
}

/// What a small window makes of a place is no place that anybody has chosen.
TEST(Ui, ASmallWindowMovesNothingForGood)
{
    std::string places;
    const auto stands = [](const char* name) {
        const ImGuiWindow* window = ImGui::FindWindowByName(name);
        return app::Area{{window->Pos.x, window->Pos.y}, {window->Size.x, window->Size.y}};
    };
    const auto resize = [](Desk& desk, ImVec2 size) {
        ImGui::GetIO().DisplaySize = size;
        desk.frames(3);
    };
    app::Area log, plot;
    {
        Desk desk(deskOptions());
        desk.session.settings.panels.log = true;
        desk.frames(3);
        plot = stands("Error over time###plot");
        ImGui::SetWindowPos("Messages###log", {701, 503});
        ImGui::SetWindowSize("Messages###log", {500, 150});
        desk.frames(2);
        log = stands("Messages###log");
        EXPECT_EQ(log, (app::Area{{701, 503}, {500, 150}}));
        resize(desk, {400, 200});
        resize(desk, {1280, 720});
        EXPECT_EQ(stands("Messages###log"), log) << "the small window is gone";
        EXPECT_EQ(stands("Error over time###plot"), plot);
        resize(desk, {400, 200});
        places = desk.session.settings.places;
    }
    Desk desk(deskOptions());
    desk.session.settings.panels.log = true;
    desk.session.settings.places = places;
    desk.frames(3);
    EXPECT_EQ(stands("Messages###log"), log) << "nor does it count in the next run";
    EXPECT_EQ(stands("Error over time###plot"), plot);
}

TEST(Ui, ThePanelFoldsAndOpensAndTheSettingsKnow)
{
    Desk desk(deskOptions());
    desk.frames(2);
    EXPECT_TRUE(desk.windows().contains("Rekindle###panel"));
    app::runAction("fold-panel", desk.session, desk.requests);
    desk.frames(2);
    EXPECT_FALSE(desk.windows().contains("Rekindle###panel"));
    EXPECT_EQ(desk.loop.layout.picture.size.x, 1280);
    app::runAction("fold-panel", desk.session, desk.requests);
    app::runAction("panel-side", desk.session, desk.requests);
    desk.frames(2);
    const ImGuiWindow* panel = ImGui::FindWindowByName("Rekindle###panel");
    EXPECT_EQ(panel->Pos.x + panel->Size.x, 1280);
    EXPECT_EQ(panel->Pos.x, desk.loop.layout.picture.end().x);
}

#if IMGUI_VERSION_NUM < 18700
TEST(Ui, KeysThatAreUpAgainBeforeTheNextFrameAreSeenOnce)
{
    Desk desk(deskOptions());
    app::KeyLatch latch;
    const app::UiKey s = *app::findKey("S"), t = *app::findKey("T");
    constexpr int kCtrl = 2;  // GLFW_MOD_CONTROL
    ImGuiIO& io = ImGui::GetIO();
    const auto seen = [&](app::UiKey key) {
        io.DeltaTime = 1 / 60.0f;
        latch.apply();
        ImGui::NewFrame();
        const bool pressed = ImGui::IsKeyPressed(key, false);
        ImGui::Render();
        return pressed;
    };
    EXPECT_FALSE(seen(s));
    latch.told(s, true, kCtrl);
    latch.told(s, false, kCtrl);
    EXPECT_TRUE(seen(s));
    EXPECT_TRUE(io.KeyCtrl);
    EXPECT_FALSE(seen(s));
    EXPECT_FALSE(io.KeyCtrl);
    latch.told(t, true, 0);  // held: the back end's state has it
    io.KeysDown[t] = true;
    EXPECT_TRUE(seen(t));
    EXPECT_FALSE(seen(t));
    EXPECT_TRUE(ImGui::IsKeyDown(t));
    latch.told(t, false, 0);
    io.KeysDown[t] = false;
    EXPECT_FALSE(seen(t));
    EXPECT_FALSE(ImGui::IsKeyDown(t));
    latch.told(-1, true, 0);
    latch.told(100000, true, 0);
    EXPECT_FALSE(seen(t));
}
#endif

TEST(Ui, AHeldControlIsKnown)
{
    Desk desk(deskOptions());
    desk.frames(3);
    EXPECT_FALSE(desk.ui.isHeld());
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {desk.loop.layout.panel.end().x, 300};  // the panel's edge
    desk.frames(2);
    EXPECT_FALSE(desk.ui.isHeld());
    io.MouseDown[0] = true;
    desk.frames(2);
    EXPECT_TRUE(desk.ui.isHeld()) << "letters keep their size meanwhile";
    io.MousePos.x += 400;
    desk.frames(2);
    EXPECT_TRUE(desk.ui.isHeld());
    io.MouseDown[0] = false;
    desk.frames(2);
    EXPECT_FALSE(desk.ui.isHeld());
}

TEST(Ui, LettersThatFlyDoNothingElse)
{
    Desk desk(deskOptions("animated.gltf"));
    ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
    app::Session& session = desk.session;
    const auto press = [&](const char* modifier, const char* key) {
        app::AppRequests requests;
        for (const char* name : {modifier, key}) app::sendKey(*app::findKey(name), true);
        ImGui::GetIO().DeltaTime = 1 / 60.0f;
        ImGui::NewFrame();
        app::handleInput(session, requests, desk.loop.layout.picture, 1 / 60.0);
        ImGui::Render();
        for (const char* name : {key, modifier}) app::sendKey(*app::findKey(name), false);
        ImGui::NewFrame();
        ImGui::Render();
        return requests;
    };
    session.flying = true;
    const app::Show show = session.settings.view.show;
    const float exposure = session.settings.view.exposure;
    for (const char* modifier : {"Ctrl", "Shift"}) {
        const core::Camera before = session.navigation.camera();
        press(modifier, "D");
        EXPECT_EQ(session.settings.view.show, show) << modifier;
        EXPECT_NE(session.navigation.camera(), before) << modifier;
        press(modifier, "E");
        EXPECT_EQ(session.settings.view.exposure, exposure) << modifier;
    }
    const core::Camera before = session.navigation.camera();
    EXPECT_TRUE(press("Ctrl", "Q").leave);
    EXPECT_EQ(session.navigation.camera(), before);
    session.flying = false;
    press("Ctrl", "D");
    EXPECT_EQ(session.settings.view.show, app::Show::flip);
}

}  // namespace
