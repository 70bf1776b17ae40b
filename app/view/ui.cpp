// The panel and everything else over the picture: what is drawn in which order, and where the panel
// stands. The parts are in ui_*.cpp.
#include "app/view/ui.h"

#include <algorithm>

#include "app/view/ui_parts.h"

namespace app {
namespace {

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

void drawHead(const UiContext& c)
{
    actionButton(c, c.session.paused ? "Go on" : "Pause", "pause", {}, {}, 5 * c.em);
    sameLineIfRoom(buttonWidth("Restart"));
    actionButton(c, "Restart", "restart");
    sameLineIfRoom(buttonWidth("Keys"));
    actionButton(c, "Keys", "help");
    sameLineIfRoom(buttonWidth("Plot"));
    actionButton(c, "Plot", "plot");
    sameLineIfRoom(buttonWidth("Times"));
    actionButton(c, "Times", "profiler");
    sameLineIfRoom(buttonWidth("Log"));
    actionButton(c, "Log", "log");
}

/// The panel at the left edge, as high as the window, as wide as the user drags it within limits.
/// In a window too small for both it starts collapsed.
void drawPanel(const UiContext& c)
{
    const float most = std::max(c.window.x - 6 * c.em, 4 * c.em);
    const float least = std::min(14 * c.em, most);
    const float first = std::clamp(0.38f * c.window.x, least, std::min(25 * c.em, most));
    ImGui::SetNextWindowPos(ImVec2(0, 0));
    ImGui::SetNextWindowSize(ImVec2(first, c.window.y), c.state.area == c.frame.area
                                                            ? ImGuiCond_FirstUseEver
                                                            : ImGuiCond_Always);
    ImGui::SetNextWindowSizeConstraints(ImVec2(least, c.window.y), ImVec2(most, c.window.y));
    ImGui::SetNextWindowCollapsed(c.window.x < 32 * c.em, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowBgAlpha(c.session.settings.panels.opacity);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0.0f);
    const bool visible =
        ImGui::Begin("Rekindle###panel", nullptr,
                     ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoBringToFrontOnFocus);
    c.state.panelWidth = visible && !ImGui::IsWindowCollapsed() ? ImGui::GetWindowWidth() : 0;
    if (visible) {
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
    if (c.window.x < 1 || c.window.y < 1) return;
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
        state_->panelWidth = 0;
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
