// The panel without a window: Dear ImGui with no back end over a real session with a made-up
// renderer, in every state that the session can be in, in windows of every size. Dear ImGui's own
// assertions are part of the test; on top of them everything must lie inside the window, and
// nothing may use an action that does not exist.
#include "app/view/imgui/input.h"
#include "app/view/ui/ui.h"

#include <chrono>
#include <cmath>
#include <set>
#include <thread>

#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>

#include "app/view/ui/ui_parts.h"
#include "tests/support/fake_estimate.h"

namespace {

/// Flat grey with a little noise, one sample per millisecond.
class GreyRenderer : public core::Renderer {
public:
    void setWorld(std::shared_ptr<const core::World>, const core::Progress& progress) override
    {
        progress("build", 0.5);
    }
    void setView(const core::View& view, core::Start) override
    {
        size_ = view.size;
        samples_ = 0;
    }
    void setPace(const core::Pace&) override {}
    void advance(const core::Budget& budget, std::stop_token) override
    {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        samples_ += budget.samples;
    }
    core::RenderProgress progress() const override { return {samples_, samples_, 0}; }
    core::Estimate read(core::Reading) override
    {
        const float n = static_cast<float>(std::max<uint64_t>(samples_, 2));
        core::Estimate estimate = tests::flatEstimate(size_, 0.5f, 0.05f / (n - 1), samples_);
        estimate.counters.nan = 3;  // so that the line of status tells it
        return estimate;
    }
    core::Aovs aovs() override
    {
        return {core::Image(size_.x, size_.y, 1), core::Image(size_.x, size_.y, 3),
                core::Image(size_.x, size_.y, 3), core::Image(size_.x, size_.y, 3)};
    }
    core::RenderStats stats() const override
    {
        core::RenderStats stats;
        stats.device = "grey";
        stats.rays = samples_ * 1000;
        return stats;
    }

private:
    glm::uvec2 size_{1};
    uint64_t samples_ = 0;
};

class FailingRenderer : public GreyRenderer {
public:
    void setWorld(std::shared_ptr<const core::World>, const core::Progress&) override
    {
        throw core::Error("device: out of memory, 12.3 GiB needed — use a smaller scene");
    }
};

app::SessionOptions options(const char* scene = nullptr)
{
    app::SessionOptions made;
    made.quiet = true;
    if (scene != nullptr) made.scene.file = std::string(REKINDLE_SOURCE_DIR "/assets/") + scene;
    made.factory = [](const app::RenderParams&, bool) { return std::make_unique<GreyRenderer>(); };
    return made;
}

const app::UiKey kTab = *app::findKey("Tab"), kEnter = *app::findKey("Enter");

/// A session whose panel is drawn: makes frames and checks them.
class Desk {
public:
    explicit Desk(const app::SessionOptions& with, ImVec2 size = {1280, 720}, float scale = 1)
        : session(with)
    {
        context_ = ImGui::CreateContext();
        ImGuiIO& io = ImGui::GetIO();
        io.IniFilename = nullptr;
        io.DisplaySize = size;
        ImFontConfig font;
        font.SizePixels = 13 * scale;
        io.Fonts->AddFontDefault(&font);
        unsigned char* pixels;
        int width, height;
        io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
        ImGui::GetStyle().ScaleAllSizes(scale);
#if IMGUI_VERSION_NUM < 18700
        io.KeyMap[ImGuiKey_Tab] = kTab;
        io.KeyMap[ImGuiKey_Enter] = kEnter;
#endif
    }
    ~Desk()
    {
        ImGui::DestroyContext(context_);
    }

    void frame()
    {
        ImGuiIO& io = ImGui::GetIO();
        io.DeltaTime = 1 / 60.0f;
        const glm::uvec2 area(static_cast<uint32_t>(io.DisplaySize.x),
                              static_cast<uint32_t>(io.DisplaySize.y));
        session.update(1 / 60.0, glm::uvec2(64, 36));  // small pictures: the panel is under test
        ImGui::NewFrame();
        if (openAll) openSections();
        loop.area = area;
        ui.draw(session, requests, loop);
        ImGui::Render();
        check();
    }
    void frames(int count)
    {
        for (int i = 0; i < count; ++i) frame();
    }
    /// Presses and lets go.
    void key(app::UiKey key)
    {
        app::sendKey(key, true);
        frame();
        app::sendKey(key, false);
        frame();
    }
    void type(const std::string& text)
    {
        ImGui::GetIO().AddInputCharactersUTF8(text.c_str());
        frames(2);
    }

    /// Until `done`, at most ten seconds.
    template <class Done> bool framesUntil(Done&& done)
    {
        for (int i = 0; i < 2000 && !done(); ++i) {
            frame();
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        return done();
    }
    bool hasPicture() const
    {
        return session.picture() && !session.picture()->preview;
    }

    /// Names of the windows that were drawn in the last frame.
    std::set<std::string> windows() const
    {
        std::set<std::string> names;
        for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows) {
            if (window->Active && !window->Hidden) names.insert(window->Name);
        }
        return names;
    }

    app::Session session;
    app::AppRequests requests;
    app::Ui ui;
    app::UiFrame loop;
    bool openAll = false;

private:
    void openSections()
    {
        ImGuiWindow* panel = ImGui::FindWindowByName("Rekindle###panel");
        if (panel == nullptr) return;
        for (const char* title : {"Scene", "Method", "View", "Camera", "Animation", "Camera path",
                                  "Compare", "Reference", "Stop when", "Save"}) {
            panel->StateStorage.SetInt(panel->GetID(title), 1);
        }
    }

    void check()
    {
        const ImGuiContext& g = *ImGui::GetCurrentContext();
        const ImVec2 size = ImGui::GetIO().DisplaySize;
        for (const ImGuiWindow* window : g.Windows) {
            if (!window->Active || window->Hidden ||
                (window->Flags & ImGuiWindowFlags_ChildWindow) != 0)
                continue;
            if ((window->Flags & ImGuiWindowFlags_Tooltip) != 0) continue;
            if (std::string(window->Name) == "Debug##Default") continue;
            EXPECT_GE(window->Pos.x, 0) << window->Name;
            EXPECT_GE(window->Pos.y, 0) << window->Name;
            EXPECT_LE(window->Pos.x + window->Size.x, size.x + 1) << window->Name;
            EXPECT_LE(window->Pos.y + window->Size.y, size.y + 1) << window->Name;
        }
        EXPECT_TRUE(ui.unknownActions().empty()) << ui.unknownActions().front();
    }

    ImGuiContext* context_;
};

/// Everything on at once.
void openEverything(Desk& desk)
{
    app::PanelParams& panels = desk.session.settings.panels;
    panels.panel = panels.help = panels.log = panels.plot = panels.profiler = true;
    desk.openAll = true;
}

TEST(Ui, NothingToShow)
{
    Desk desk(options());
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
        Desk desk(options("animated.gltf"), size.window, size.scale);
        openEverything(desk);
        ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
        desk.frames(5);
    }
}

TEST(Ui, SmallWindowsLeaveRoomForThePicture)
{
    {
        Desk desk(options("animated.gltf"), {640, 360});
        openEverything(desk);
        desk.frames(3);
        const ImGuiWindow* panel = ImGui::FindWindowByName("Rekindle###panel");
        ASSERT_NE(panel, nullptr);
        EXPECT_FALSE(panel->Collapsed);
        EXPECT_LT(panel->Size.x, 0.45f * 640);
        EXPECT_FALSE(desk.windows().contains("Error over time###plot"));
    }
    Desk desk(options("animated.gltf"), {320, 200});
    desk.frames(3);
    EXPECT_TRUE(ImGui::FindWindowByName("Rekindle###panel")->Collapsed);
}

TEST(Ui, WindowsFollowTheirEdgesThroughResizes)
{
    Desk desk(options("animated.gltf"));
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
    Desk desk(options("animated.gltf"));
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
    Desk desk(options());
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

TEST(Ui, FailuresOfTheRendererAreTold)
{
    app::SessionOptions failing = options("animated.gltf");
    failing.factory = [](const app::RenderParams&, bool) {
        return std::make_unique<FailingRenderer>();
    };
    Desk desk(failing);
    openEverything(desk);
    EXPECT_TRUE(desk.framesUntil([&] { return desk.session.rendering().errorCount > 0; }));
    desk.frames(3);
}

TEST(Ui, QuestionBeforeQuitting)
{
    Desk desk(options());
    desk.requests.askQuit = true;
    desk.frames(3);
    EXPECT_FALSE(desk.requests.askQuit);
    EXPECT_FALSE(desk.requests.quit);
    EXPECT_TRUE(desk.windows().contains("Quit?###quit"));
}

TEST(Ui, PathBoxOpensWithoutThePanel)
{
    Desk desk(options());
    desk.session.settings.panels.panel = false;
    desk.requests.openPathBox = true;
    desk.frames(3);
    EXPECT_FALSE(desk.requests.openPathBox);
    EXPECT_TRUE(desk.windows().contains("Open a scene###open"));
    EXPECT_TRUE(ImGui::GetIO().WantCaptureKeyboard) << "what is typed goes to the line";
}

TEST(Ui, PathBoxCompletesAndLoads)
{
    Desk desk(options());
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

TEST(Ui, WholeNumbersCanBeTyped)
{
    Desk desk(options());
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

}  // namespace
