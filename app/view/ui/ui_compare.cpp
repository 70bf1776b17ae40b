// Sections of the panel: two pictures side by side, and the reference.
#include <algorithm>
#include <cmath>

#include "app/files/params_json.h"
#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

constexpr const char* kSides[] = {"A", "B"};

/// What a side was rendered with; a live one with what is set now.
RenderParams sideParams(const Session& session, size_t side)
{
    const Slot& slot = session.slots[side];
    return slot.picture ? slot.picture->params : session.render;
}

/// As the action equal-time takes it: everything that a picture's parameters say.
nlohmann::ordered_json changesTo(const RenderParams& params)
{
    nlohmann::ordered_json json = paramsJson(params.method);
    json["device"] = std::string(core::enumName(params.device));
    json["method"] = std::string(params.method.id());
    return json;
}

void drawSide(const UiContext& c, size_t side)
{
    Slot& slot = c.session.slots[side];
    ImGui::PushID(static_cast<int>(side));
    rowLabel(kSides[side], side == 0 ? "left of the slider" : "right of the slider");
    const std::string none = shownPicture(c) ? "" : "there is no picture yet";
    actionButton(c, "Store", side == 0 ? "store-a" : "store-b", none);
    ImGui::SameLine(0, ImGui::GetStyle().ItemInnerSpacing.x);
    const std::string live = slot.picture ? "" : "it is live already";
    if (plainButton("Live", "show what is being rendered on this side", live)) slot = {};
    dimText(slot.picture ? slot.label : "live: whatever is being rendered");
    ImGui::PopID();
}

void drawEqualTime(const UiContext& c)
{
    ImGui::PushID("equal time");
    rowLabel("seconds each", "rendering time of each side");
    auto seconds = static_cast<float>(c.state.equalSeconds);
    if (ImGui::SliderFloat("##seconds", &seconds, 0.5f, 600, "%.3g s",
                           ImGuiSliderFlags_Logarithmic)) {
        c.state.equalSeconds = std::clamp(static_cast<double>(seconds), 0.01, 86400.0);
    }
    const EqualTime& run = c.session.equalTime();
    if (run.running()) {
        actionButton(c, "Cancel", "cancel");
        ImGui::SameLine();
        const double done = (run.side() + run.fraction()) / 2;
        ImGui::ProgressBar(static_cast<float>(done), ImVec2(-1, 0),
                           run.side() == 0 ? "rendering A" : "rendering B");
    } else {
        const RenderParams a = sideParams(c.session, 0), b = sideParams(c.session, 1);
        std::string why = c.session.document() ? "" : "there is no scene";
        actionButton(c, "Run at equal time", "equal-time", why,
                     {{"seconds", c.state.equalSeconds}, {"a", changesTo(a)}, {"b", changesTo(b)}});
        dimText("A with: " + paramsLabel(a));
        dimText("B with: " + paramsLabel(b));
    }
    ImGui::PopID();
}

}  // namespace

void drawCompareSection(const UiContext& c)
{
    if (bool comparing = c.session.comparing; ImGui::Checkbox("slider between A and B", &comparing))
        c.act("compare");
    tip("the key  [" + keyOf("compare") + "]  flips between the slider and the live picture");
    drawSide(c, 0);
    drawSide(c, 1);
    const bool none = !c.session.slots[0].picture && !c.session.slots[1].picture;
    const std::string why = none ? "both sides are live" : "";
    actionButton(c, "Swap", "swap", why);
    sameLineIfRoom(buttonWidth("Both live"));
    actionButton(c, "Both live", "clear-slots", why);
    editParams(c.session.settings.view, {.onCommandLine = false}, [](const core::Field& field) {
        return std::string_view(field.name) == "compare-at";
    });
    ImGui::Spacing();
    drawEqualTime(c);
}

void drawReferenceSection(const UiContext& c)
{
    if (const auto reference = c.session.reference()) {
        dimText(reference->origin);
        std::string samples = reference->samples > 0 ? std::to_string(reference->samples) + " spp"
                                                     : "samples unknown";
        if (reference->seconds > 0) samples += " in " + secondsText(reference->seconds);
        dimText(samples);
        const double noise = referenceNoise(*reference);
        dimText(noise > 0 ? "its own noise: RMSE " + digitsText(noise)
                          : "its own noise is unknown");
    } else {
        dimText("none: errors are estimated from the samples' own spread");
    }
    ImGui::PushID("reference");
    rowLabel("samples", "samples per pixel of the reference");
    countInput("##samples", c.state.referenceSamples);
    c.state.referenceSamples = std::clamp<uint64_t>(c.state.referenceSamples, 2, 1u << 30);
    rowReset(false, {});
    std::string why;
    if (!c.session.document()) why = "there is no scene";
    if (c.session.coreThread().active())
        why = "something else runs in the background: cancel it first";
    actionButton(c, "Render in the background", "reference", why,
                 {{"spp", c.state.referenceSamples}});
    sameLineIfRoom(buttonWidth("Drop"));
    actionButton(c, "Drop", "drop-reference", c.session.reference() ? "" : "there is no reference");
    if (pathInput(c.state.reference, "file", "or an .exr of this view", {".exr"})) {
        c.act("load-reference", {{"file", c.state.reference.text}});
    }
    ImGui::PopID();
}

}  // namespace app
