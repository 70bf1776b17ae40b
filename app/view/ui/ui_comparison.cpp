// Of the section that compares: the errors of A and B and which of them takes less time, once both
// are kept.
#include <cmath>

#include "app/report/text.h"
#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

using report::shortNumber;

std::string intervalText(const Bounded& bounded)
{
    const BoundedDigits text = boundedDigits(bounded);
    return text.low + " to " + text.high;
}

void row(const char* name, const std::string& a, const std::string& b, const char* help)
{
    ImGui::TableNextColumn();
    dimText(name);
    tip(help);
    for (const std::string* text : {&a, &b}) {
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(text->c_str());
        tip(help);
    }
}

void errorRows(const char* name, const Bounded& a, const Bounded& b, const char* help)
{
    if (!std::isfinite(a.high) || !std::isfinite(b.high)) {
        row(name, "unknown", "unknown", "it needs a reference of little noise");
        return;
    }
    const auto value = [](const Bounded& error) {
        return error.low > 0 ? boundedDigits(error).value : "\u2264 " + shortNumber(error.high);
    };
    row(name, value(a), value(b), help);
    row("  95 %", intervalText(a), intervalText(b),
        "the interval that holds the true error 95 times in 100");
}

void drawTable(const PictureComparison& comparison)
{
    const SideErrors &a = comparison.sides[0], &b = comparison.sides[1];
    if (!ImGui::BeginTable("##errors", 3, ImGuiTableFlags_SizingStretchProp)) return;
    row("", "A", "B", "kept pictures");
    row("samples", std::to_string(a.samples), std::to_string(b.samples), "per pixel");
    row("seconds", secondsText(a.seconds), secondsText(b.seconds), "of rendering");
    if (comparison.source != PictureComparison::Source::none) {
        errorRows("RMSE", a.rmse, b.rmse, "root mean square error");
        errorRows("relMSE", a.relMse, b.relMse,
                  "mean of the squared error over the squared radiance + 0.01");
    }
    ImGui::EndTable();
}

}  // namespace

void drawComparisonTable(const UiContext& c)
{
    if (!c.session.slots[0].picture || !c.session.slots[1].picture) return;
    const auto comparison = c.session.comparison();
    if (!comparison) {
        dimText("the errors of A and B are being measured");
        return;
    }
    ImGui::PushID("comparison");
    drawTable(*comparison);
    if (comparison->source != PictureComparison::Source::none) {
        ImGui::TextWrapped("%s", verdict(comparison->byRmse, "RMSE").c_str());
        ImGui::TextWrapped("%s", verdict(comparison->byRelMse, "relMSE").c_str());
    }
    for (const std::string& note : comparisonNotes(*comparison)) dimText(note);
    actionButton(c, "Copy as text", "copy-comparison");
    ImGui::PopID();
}

}  // namespace app
