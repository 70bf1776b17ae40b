// The panel and everything else over the picture: what is drawn in which order, and where the panel
// stands. The parts are in ui_*.cpp.
#include "app/view/ui/ui.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

/// In letters: a smaller window shows the picture alone.
const ImVec2 kLeastWindow{14, 8};

struct Section {
    const char* title;
    bool open;  // at first
    void (*draw)(const UiContext&);
    bool (*there)(const UiContext&);
};

bool always(const UiContext&)
{
    return true;
}
bool animated(const UiContext& c)
{
    return c.session.player.duration > 0;
}

constexpr Section kSections[] = {
    {"Scene", true, drawSceneSection, always},
    {"Method", true, drawMethodSection, always},
    {"View", true, drawViewSection, always},
    {"Camera", false, drawCameraSection, always},
    {"Animation", true, drawAnimationSection, animated},
    {"Camera path", false, drawPathSection, always},
    {"Compare", false, drawCompareSection, always},
    {"Reference", false, drawReferenceSection, always},
    {"Stop when", false, drawLimitsSection, always},
    {"Save", false, drawSaveSection, always},
};

struct HeadButton {
    const char *label, *action;
    std::string whyNot = {};
};

/// Buttons that share the width of the line evenly.
void drawHeadRow(const UiContext& c, std::initializer_list<HeadButton> buttons)
{
    const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
    const auto count = static_cast<float>(buttons.size());
    const float width = (ImGui::GetContentRegionAvail().x - (count - 1) * gap) / count;
    bool first = true;
    for (const HeadButton& button : buttons) {
        if (!first) ImGui::SameLine(0, gap);
        first = false;
        actionButton(c, button.label, button.action, button.whyNot,
                     nlohmann::ordered_json::object(), std::max(width, 1.0f));
    }
}

void drawHead(const UiContext& c)
{
    drawHeadRow(c, {{c.session.paused ? "Go on" : "Pause", "pause"},
                    {"Restart", "restart"},
                    {"Open...", "open"}});
    drawHeadRow(
        c,
        {{"Keys", "help"}, {"Plot", "plot", whyNoPlot(c)}, {"Times", "profiler"}, {"Log", "log"}});
    ImGui::Spacing();
}

/// Where the panel may stand: at the left edge, as high as the window, as wide as the user drags it
/// within limits. In a window too small for both it starts collapsed. True when it is open.
bool beginPanel(const UiContext& c)
{
    UiState& state = c.state;
    const bool resized = state.area != c.frame.area;
    const float most = std::max(c.window.x - 6 * c.em, 4 * c.em);
    const float least = std::min(14 * c.em, most);
    const float usual =
        std::clamp(0.38f * c.window.x, least, std::max(least, std::min(25 * c.em, most)));
    const float width = state.chosenWidth > 0 ? std::clamp(state.chosenWidth, least, most) : usual;
    ImGui::SetNextWindowPos(ImVec2(0, 0));
    ImGui::SetNextWindowSize(ImVec2(width, c.window.y),
                             resized ? ImGuiCond_Always : ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSizeConstraints(ImVec2(least, c.window.y), ImVec2(most, c.window.y));
    ImGui::SetNextWindowCollapsed(c.window.x < 32 * c.em, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowBgAlpha(c.session.settings.panels.opacity);
    const bool visible =
        ImGui::Begin("Rekindle###panel", nullptr,
                     ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoBringToFrontOnFocus);
    const bool open = visible && !ImGui::IsWindowCollapsed();
    if (open && !resized && state.panelWidth > 0 &&
        std::abs(ImGui::GetWindowWidth() - state.panelWidth) > 0.5f)
        state.chosenWidth = ImGui::GetWindowWidth();
    state.panelWidth = open ? ImGui::GetWindowWidth() : 0;
    state.overlayTop = open ? 0 : ImGui::GetWindowHeight();
    return visible;
}

void drawPanel(const UiContext& c)
{
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0.0f);
    if (beginPanel(c)) {
        drawHead(c);
        for (const Section& s : kSections) {
            if (!s.there(c) || !section(s.title, s.open)) continue;
            ImGui::PushID(s.title);
            s.draw(c);
            ImGui::Spacing();
            ImGui::PopID();
        }
    }
    ImGui::End();
    ImGui::PopStyleVar();
}

}  // namespace

Ui::Ui() : state_(std::make_unique<UiState>()) {}
Ui::~Ui() = default;

const std::vector<std::string>& Ui::unknownActions() const
{
    return state_->unknownActions;
}

void Ui::draw(Session& session, AppRequests& app, const UiFrame& frame)
{
    const UiContext c{
        session, app, frame, *state_, ImGui::GetFontSize(), ImGui::GetIO().DisplaySize};
    if (c.window.x < kLeastWindow.x * c.em || c.window.y < kLeastWindow.y * c.em) return;
    const PanelParams& panels = session.settings.panels;
    state_->statusHeight = 0;
    if (panels.panel) {
        drawStatusLine(c);
        drawCompareSlider(c);
        drawColourBar(c);
        drawPanel(c);
        drawPlotWindow(c);
        drawProfilerWindow(c);
        drawLogWindow(c);
    } else {
        state_->panelWidth = state_->overlayTop = 0;
        drawCompareSlider(c);
    }
    drawProgress(c);
    drawToasts(c);
    drawHelpWindow(c);
    drawOpenBox(c);
    drawQuitQuestion(c);
    drawInspector(c);
    state_->area = frame.area;
}

}  // namespace app
