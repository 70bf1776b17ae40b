// The panel and everything else around the picture: what is drawn in which order. Where it stands
// is decided in app/session/window_layout.h; the parts are in ui_*.cpp.
#include "app/view/ui/ui.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "app/view/imgui/windows.h"
#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

struct Section {
    const char* title;
    bool SectionParams::*open;
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
    {"Scene", &SectionParams::scene, drawSceneSection, always},
    {"Method", &SectionParams::method, drawMethodSection, always},
    {"View", &SectionParams::view, drawViewSection, always},
    {"Camera", &SectionParams::camera, drawCameraSection, always},
    {"Animation", &SectionParams::animation, drawAnimationSection, animated},
    {"Camera path", &SectionParams::path, drawPathSection, always},
    {"Compare", &SectionParams::compare, drawCompareSection, always},
    {"Reference", &SectionParams::reference, drawReferenceSection, always},
    {"Stop when", &SectionParams::limits, drawLimitsSection, always},
    {"Save", &SectionParams::save, drawSaveSection, always},
};

struct HeadButton {
    const char *label, *action;
    std::string whyNot = {};
};

/// Buttons that share the width of the line: each has room for its word, what is left is shared.
/// Where the words have no room in one line they take more.
void drawHeadRow(const UiContext& c, std::initializer_list<HeadButton> buttons)
{
    const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
    const auto count = static_cast<float>(buttons.size());
    const auto least = [&](const HeadButton& button) {
        return ImGui::CalcTextSize(button.label).x + 0.5f * c.em;
    };
    float words = (count - 1) * gap;
    for (const HeadButton& button : buttons) words += least(button);
    const float room = ImGui::GetContentRegionAvail().x;
    const float spare = std::max(room - words, 0.0f) / count;
    const bool fits = words <= room;
    bool first = true;
    for (const HeadButton& button : buttons) {
        const float width = fits ? least(button) + spare : buttonWidth(button.label);
        if (!first && fits) ImGui::SameLine(0, gap);
        if (!first && !fits) sameLineIfRoom(width);
        first = false;
        actionButton(c, button.label, button.action, button.whyNot,
                     nlohmann::ordered_json::object(), width);
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

/// The edge between panel and picture, which the hand may drag.
void drawPanelEdge(const UiContext& c)
{
    PanelParams& panels = c.session.settings.panels;
    const Area& panel = c.frame.layout.panel;
    const bool left = panels.side == PanelSide::left;
    const float edge = left ? panel.end().x : panel.corner.x, reach = 0.3f * c.em;
    ImGui::SetNextWindowPos(ImVec2(left ? edge - reach : std::max(edge - reach, 0.0f), 0));
    ImGui::SetNextWindowSize(ImVec2(2 * reach, c.window.y));
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0, 0));
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1, 1));
    if (ImGui::Begin("##edge", nullptr, kOverlay | ImGuiWindowFlags_NoBackground)) {
        ImGui::InvisibleButton("##line", ImGui::GetWindowSize());
        const bool held = ImGui::IsItemActive();
        if (held)
            panels.width = panelWidthAt(ImGui::GetIO().MousePos.x, c.window.x, c.em, panels.side);
        if (ImGui::IsItemHovered() && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left))
            panels.width = 0;
        if (held || ImGui::IsItemHovered()) {
            ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
            ImGui::GetWindowDrawList()->AddLine(ImVec2(edge, 0), ImVec2(edge, c.window.y),
                                                ImGui::GetColorU32(ImGuiCol_CheckMark), 2);
        }
    }
    ImGui::End();
    ImGui::PopStyleVar(2);
}

void drawPanel(const UiContext& c)
{
    const Area& place = c.frame.layout.panel;
    if (place.empty()) return;
    ImGui::SetNextWindowPos(ImVec2(place.corner.x, place.corner.y));
    ImGui::SetNextWindowSize(ImVec2(place.size.x, place.size.y));
    ImGui::SetNextWindowBgAlpha(0);  // Gui's frames begin with that colour
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0.0f);
    bool open = true;
    const ImGuiWindowFlags flags = tabFlags() | ImGuiWindowFlags_NoMove |
                                   ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
                                   ImGuiWindowFlags_NoSavedSettings |
                                   ImGuiWindowFlags_NoBringToFrontOnFocus;
    if (ImGui::Begin("Rekindle###panel", &open, flags)) {
        drawHead(c);
        for (const Section& s : kSections) {
            if (!s.there(c) || !section(s.title, c.session.settings.sections.*s.open)) continue;
            ImGui::PushID(s.title);
            s.draw(c);
            ImGui::Spacing();
            ImGui::PopID();
        }
    }
    ImGui::End();
    ImGui::PopStyleVar();
    if (!open) c.act("fold-panel");
    drawPanelEdge(c);
}

/// What Esc closes first; false when nothing is open.
bool closeSomething(const UiContext& c)
{
    if (closeInnermostPopup()) return true;
    UiState& state = c.state;
    for (PathBox* box :
         {&state.scene, &state.reference, &state.path, &state.picture, &state.environment})
        if (std::exchange(box->open, false) && box->drawnAt + 1 >= ImGui::GetFrameCount())
            return true;  // in a section that has been folded nobody sees it
    return std::exchange(state.browser.open, false) ||
           std::exchange(c.session.settings.panels.help, false);
}

}  // namespace

Ui::Ui() : state_(std::make_unique<UiState>()) {}
Ui::~Ui() = default;

bool Ui::isHeld() const
{
    return ImGui::IsAnyItemActive() && ImGui::IsMouseDown(ImGuiMouseButton_Left);
}

const std::vector<std::string>& Ui::unknownActions() const
{
    return state_->unknownActions;
}

void Ui::draw(Session& session, AppRequests& app, const UiFrame& frame)
{
    const UiContext c{session,
                      app,
                      frame,
                      *state_,
                      ImGui::GetFontSize(),
                      ImGui::GetIO().DisplaySize,
                      frame.layout.picture};
    if (!state_->recalled) {
        state_->places.read(session.settings.places);
        state_->recalled = true;
    }
    if (std::exchange(app.escape, false) && !closeSomething(c)) escapeFrom(session, app);
    if (!hasRoomForText(frame.layout.window, c.em)) {
        if (app.askQuit || app.question)
            app.resize = glm::max(glm::uvec2(frame.layout.window), roomForQuestion(c.em));
        return;
    }
    if (std::exchange(app.togglePlot, false)) togglePlot(c);
    const PanelParams& panels = session.settings.panels;
    if (panels.panel) {
        drawStatusLine(c);
        drawCompareSlider(c);
        drawCaption(c);
        drawColourBar(c);
        drawPanel(c);
        drawPlotWindow(c);
        drawProfilerWindow(c);
        drawLogWindow(c);
    } else {
        state_->caption = {frame.layout.picture.corner.x, frame.layout.picture.corner.y};
        drawCompareSlider(c);
    }
    drawProgress(c);
    drawHelpWindow(c);
    drawSceneBrowser(c);
    drawToasts(c);
    drawQuestions(c);
    drawInspector(c);
    keepPlaces(session);
}

void Ui::keepPlaces(Session& session)
{
    if (const std::string places = state_->places.changes(); !places.empty())
        session.settings.places = places;
}

}  // namespace app
