// Sections of the panel: two pictures side by side, and the reference. What is rendered for them is
// in ui_equal_time.cpp, what they say in ui_comparison.cpp.
#include <algorithm>

#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

void drawSide(const UiContext& c, size_t side)
{
    const Slot& slot = c.session.slots[side];
    ImGui::PushID(static_cast<int>(side));
    rowLabel(kSideNames[side], side == 0 ? "left of the slider" : "right of the slider");
    const std::string none = shownPicture(c) ? "" : "there is no picture yet";
    actionButton(c, "Store", side == 0 ? "store-a" : "store-b", none);
    ImGui::SameLine(0, ImGui::GetStyle().ItemInnerSpacing.x);
    const std::string live = slot.picture ? "" : "it is live already";
    actionButton(c, "Live", side == 0 ? "live-a" : "live-b", live);
    dimText(slot.picture ? slot.label : "live: whatever is being rendered");
    ImGui::PopID();
}

/// Methods that make references, and the picture's own.
void drawReferenceMethod(const UiContext& c)
{
    ImGui::PushID("method");
    rowLabel("method", "what the reference is rendered with, on the CPU; to measure against a "
                       "device, keep its picture");
    std::string& chosen = c.session.referenceMethod;
    if (ImGui::BeginCombo("##value", chosen.empty() ? "as the picture" : chosen.c_str())) {
        if (ImGui::Selectable("as the picture", chosen.empty())) chosen.clear();
        for (const core::MethodInfo& method : core::methods()) {
            const std::string id(method.id());
            if (method.make != nullptr && method.traits.radiance &&
                ImGui::Selectable(id.c_str(), id == chosen))
                chosen = id;
        }
        ImGui::EndCombo();
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
    drawComparisonTable(c);
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
        const double noise = reference->noise;
        dimText(noise > 0 ? "its own noise: RMSE " + digitsText(noise)
                          : "its own noise is unknown");
    } else {
        dimText("none: errors are estimated from the samples' own spread");
    }
    ImGui::PushID("reference");
    rowLabel("samples", "samples per pixel of the reference");
    countInput("##samples", c.session.referenceSamples);
    c.session.referenceSamples = std::clamp<uint64_t>(c.session.referenceSamples, 2, 1u << 30);
    rowReset(false, {});
    drawReferenceMethod(c);
    std::string why;
    if (!c.session.document()) why = "there is no scene";
    if (isRefused(c, "reference")) why = "something else runs in the background: cancel it first";
    actionButton(c, "Render in the background", "reference", why);
    sameLineIfRoom(buttonWidth("Drop"));
    actionButton(c, "Drop", "drop-reference", c.session.reference() ? "" : "there is no reference");
    sameLineIfRoom(buttonWidth("Keep the picture"));
    actionButton(c, "Keep the picture", "keep-reference",
                 shownPicture(c) ? "" : "there is no picture yet");
    if (pathInput(c.state.reference, "file", "or an .exr of this view", {".exr"})) {
        c.act("load-reference", {{"file", c.state.reference.text}});
    }
    ImGui::PopID();
}

}  // namespace app
