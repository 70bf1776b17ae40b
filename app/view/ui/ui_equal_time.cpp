// Of the section that compares: what A and B are rendered with at equal time, and the run.
#include <algorithm>

#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

constexpr const char* kChoose[] = {"params-a", "params-b"};

/// The editor of one side. What is edited is chosen from then on, whatever the panel says.
void editSide(const UiContext& c, size_t side)
{
    RenderParams params = c.session.sideParams(side);
    bool changed = false;
    if (const std::string id = methodRow(params); !id.empty()) {
        params.method = c.session.settings.paramsOf(id);
        changed = true;
    }
    changed |= deviceRow(c, params);
    changed |= editParams(params.method);
    if (changed) c.session.chosenParams[side] = params;
}

void drawSideParams(const UiContext& c, size_t side)
{
    ImGui::PushID(static_cast<int>(side));
    const bool open = ImGui::TreeNode(kSideNames[side]);
    tip(std::string("what ") + kSideNames[side] + " is rendered with at equal time");
    dimText(paramsLabel(c.session.sideParams(side)));
    actionButton(c, "From the panel", kChoose[side]);
    sameLineIfRoom(buttonWidth("Into the panel"));
    actionButton(c, "Into the panel", "use-params", {}, {{"side", side == 0 ? "a" : "b"}});
    if (open) {
        editSide(c, side);
        ImGui::TreePop();
    }
    ImGui::PopID();
}

void drawDifferences(const UiContext& c)
{
    const std::vector<ParamDifference> found =
        differences(c.session.sideParams(0), c.session.sideParams(1));
    if (found.empty()) {
        dimText("A and B are rendered alike");
        return;
    }
    if (!ImGui::BeginTable("##differences", 3, ImGuiTableFlags_SizingStretchProp)) return;
    for (const char* title : {"what differs", "A", "B"}) {
        ImGui::TableNextColumn();
        dimText(title);
    }
    for (const ParamDifference& difference : found) {
        for (const std::string* text : {&difference.name, &difference.a, &difference.b}) {
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(text->c_str());
        }
    }
    ImGui::EndTable();
}

void drawRun(const UiContext& c)
{
    rowLabel("seconds each", "rendering time of each side");
    auto seconds = static_cast<float>(c.state.equalSeconds);
    if (ImGui::SliderFloat("##seconds", &seconds, 0.5f, 600, "%.3g s",
                           ImGuiSliderFlags_Logarithmic)) {
        c.state.equalSeconds = std::clamp(static_cast<double>(seconds), 0.01, 86400.0);
    }
    const EqualTime& run = c.session.equalTime();
    if (run.running()) {
        actionButton(c, "Cancel", "cancel", {}, {{"what", core::enumName(Work::equalTime)}});
        ImGui::SameLine();
        const double done = (run.side() + run.fraction()) / 2;
        ImGui::ProgressBar(static_cast<float>(done), ImVec2(-1, 0),
                           run.side() == 0 ? "rendering A" : "rendering B");
        return;
    }
    actionButton(c, "Run at equal time", "equal-time",
                 c.session.document() ? "" : "there is no scene",
                 {{"seconds", c.state.equalSeconds}});
}

}  // namespace

void drawEqualTime(const UiContext& c)
{
    ImGui::PushID("equal time");
    dimText("Equal time");
    drawSideParams(c, 0);
    drawSideParams(c, 1);
    drawDifferences(c);
    drawRun(c);
    ImGui::PopID();
}

}  // namespace app
