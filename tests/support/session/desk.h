// The panel without a window: Dear ImGui with no back end over a real session with a made-up
// renderer. Dear ImGui's own assertions are part of every test; on top of them everything must lie
// inside the window, and nothing may use an action that does not exist.
#pragma once

#include "app/view/imgui/input.h"
#include "app/view/ui/ui.h"

#include <chrono>
#include <set>
#include <thread>

#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>

#include "tests/support/methods/fake_estimate.h"

namespace tests {

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
                core::Image(size_.x, size_.y, 3), core::Image(size_.x, size_.y, 3),
                core::Image(size_.x, size_.y, 3)};
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

inline app::SessionOptions deskOptions(const char* scene = nullptr)
{
    app::SessionOptions made;
    made.quiet = true;
    if (scene != nullptr) made.scene.file = std::string(REKINDLE_SOURCE_DIR "/assets/") + scene;
    made.factory = [](const app::RenderParams&, bool) { return std::make_unique<GreyRenderer>(); };
    return made;
}

inline const app::UiKey kTab = *app::findKey("Tab"), kEnter = *app::findKey("Enter"),
                        kEscape = *app::findKey("Esc"), kDown = *app::findKey("Down");

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
        io.KeyMap[ImGuiKey_Escape] = kEscape;
        io.KeyMap[ImGuiKey_DownArrow] = kDown;
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
        session.update(1 / 60.0, glm::uvec2(64, 36));  // small pictures: the panel is under test
        ImGui::NewFrame();
        if (openAll) openSections();
        layOut();
        if (requests.foldPanel) {  // as the window's loop does it
            session.settings.panels.fold =
                loop.layout.panel.empty() ? app::PanelFold::open : app::PanelFold::folded;
            requests.foldPanel = false;
            layOut();
        }
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
    void layOut()
    {
        const ImVec2 size = ImGui::GetIO().DisplaySize;
        loop.layout = app::layOut({size.x, size.y}, ImGui::GetFontSize(), session.settings.panels);
    }
    void openSections()
    {
        app::SectionParams::visit(session.settings.sections,
                                  [](const core::Field&, bool& open) { open = true; });
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
inline void openEverything(Desk& desk)
{
    app::PanelParams& panels = desk.session.settings.panels;
    panels.panel = panels.help = panels.log = panels.plot = panels.profiler = true;
    desk.openAll = true;
}

}  // namespace tests
