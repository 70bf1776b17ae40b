// Widgets of one described field. Widths are fractions of the line, so that a narrow panel stays
// usable.
#include "app/view/ui/ui_fields.h"

#include <algorithm>
#include <cmath>

#include "app/view/ui/ui_text.h"

namespace app {
namespace {

float resetWidth()
{
    return ImGui::GetFrameHeight();
}

/// An arrow that runs back to where it came from.
void drawResetIcon(ImVec2 centre, float radius, ImU32 colour)
{
    ImDrawList& list = *ImGui::GetWindowDrawList();
    constexpr float kFrom = -2.2f, kTo = 2.6f;
    list.PathArcTo(centre, radius, kFrom, kTo, 16);
    list.PathStroke(colour, 0, std::max(1.0f, radius * 0.28f));
    const ImVec2 tip(centre.x + radius * std::cos(kFrom), centre.y + radius * std::sin(kFrom));
    const float s = radius * 0.75f;
    list.AddTriangleFilled(ImVec2(tip.x - s * 0.9f, tip.y + s * 0.1f),
                           ImVec2(tip.x + s * 0.5f, tip.y - s * 0.9f),
                           ImVec2(tip.x + s * 0.55f, tip.y + s * 0.75f), colour);
}

/// Of a label that stands beside its field.
float besideWidth(float row)
{
    return std::min(row * 0.40f, ImGui::GetFontSize() * 11);
}

std::string boundText(double value)
{
    return format("%.6g", value);
}

/// Slider of a bounded whole number: wide ranges move by factors, because 4 and 8 matter there and
/// 2004 and 2008 do not.
bool wholeSlider(const core::Range& range, uint32_t& value, const std::string& pattern)
{
    const auto low = static_cast<uint32_t>(range.low), high = static_cast<uint32_t>(range.high);
    ImGuiSliderFlags flags = ImGuiSliderFlags_AlwaysClamp;
    if (range.logarithmic || range.high - range.low > 256) flags |= ImGuiSliderFlags_Logarithmic;
    return ImGui::SliderScalar("##value", ImGuiDataType_U32, &value, &low, &high, pattern.c_str(),
                               flags);
}

}  // namespace

void tip(const std::string& text)
{
    if (text.empty() || !ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
    if (ImGui::IsMouseDown(ImGuiMouseButton_Left)) return;  // it would hide what is being dragged
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(
        std::min(ImGui::GetFontSize() * 26, ImGui::GetIO().DisplaySize.x * 0.8f));
    ImGui::TextUnformatted(text.data(), text.data() + text.size());
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

bool labelStandsAbove(const char* label, float row)
{
    constexpr float kNarrow = 19;  // in letters: fields beside labels would cut their own words
    const float room = besideWidth(row) - ImGui::GetStyle().ItemInnerSpacing.x;
    return row < kNarrow * ImGui::GetFontSize() || ImGui::CalcTextSize(label).x > room;
}

void rowLabel(const char* label, const std::string& help, bool biased)
{
    const float width = ImGui::GetContentRegionAvail().x, left = ImGui::GetCursorPosX();
    const bool above = labelStandsAbove(label, width);
    const float beside = besideWidth(width), labelWidth = above ? width : beside;
    const float height = above ? ImGui::GetTextLineHeight() : ImGui::GetFrameHeight();
    const ImVec2 place = ImGui::GetCursorScreenPos();
    const ImVec4 clip(place.x, place.y, place.x + labelWidth, place.y + height);
    ImGui::InvisibleButton("##label", ImVec2(std::max(labelWidth, 1.0f), height));
    tip(help);
    const ImU32 colour =
        biased ? ImGui::GetColorU32(kWarningColour) : ImGui::GetColorU32(ImGuiCol_Text);
    const float down = above ? 0 : ImGui::GetStyle().FramePadding.y;
    ImGui::GetWindowDrawList()->AddText(nullptr, 0, ImVec2(place.x, place.y + down), colour, label,
                                        nullptr, 0, &clip);
    if (above)  // closer to its own field than to the row before
        ImGui::SetCursorPosY(ImGui::GetCursorPosY() - 0.6f * ImGui::GetStyle().ItemSpacing.y);
    else
        ImGui::SameLine(left + labelWidth, 0);
    ImGui::SetNextItemWidth(
        std::max(width - (above ? 0 : labelWidth) - resetWidth(), ImGui::GetFontSize() * 2));
}

bool rowReset(bool differs, const std::string& standard)
{
    ImGui::SameLine(0, 0);
    const ImVec2 place = ImGui::GetCursorScreenPos();
    const ImVec2 size(resetWidth(), ImGui::GetFrameHeight());
    if (!differs) {
        ImGui::Dummy(size);
        return false;
    }
    const bool clicked = ImGui::InvisibleButton("##reset", size);
    const ImGuiCol colour = ImGui::IsItemHovered() ? ImGuiCol_Text : ImGuiCol_TextDisabled;
    drawResetIcon(ImVec2(place.x + size.x * 0.55f, place.y + size.y * 0.5f), size.y * 0.22f,
                  ImGui::GetColorU32(colour));
    tip("back to " + standard);
    return clicked;
}

std::string fieldLabel(const core::Field& field)
{
    std::string label = field.name;
    std::replace(label.begin(), label.end(), '-', ' ');
    return label;
}

std::string fieldPattern(const core::Field& field, const char* pattern, const FieldOptions& options)
{
    for (const FieldUnit& unit : options.units)
        if (unit.field == field.name) return std::string(pattern) + ' ' + std::string(unit.unit);
    return pattern;
}

std::string fieldTip(const core::Field& field, const std::string& standard, bool onCommandLine)
{
    std::string text = field.help;
    text += "\n\n";
    if (field.range.low < field.range.high) {
        text += "From " + boundText(field.range.low) + " to " + boundText(field.range.high) +
                ", normally " + standard;
        text += ". Ctrl-click to type.";
    } else {
        text += "Normally " + standard + ".";
    }
    if (field.biased) text += "\nBiased: the image no longer converges to the right one.";
    if (onCommandLine) text += std::string("\n--") + field.name;
    return text;
}

bool editField(const core::Field& field, bool& value, bool standard, const FieldOptions& options)
{
    const std::string usual = standard ? "on" : "off";
    ImGui::PushID(field.name);
    rowLabel(fieldLabel(field).c_str(), fieldTip(field, usual, options.onCommandLine),
             core::biases(field, value, standard));
    bool changed = ImGui::Checkbox("##value", &value);
    tip(fieldTip(field, usual, options.onCommandLine));
    ImGui::SameLine();
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() +
                         std::max(0.0f, ImGui::GetContentRegionAvail().x - resetWidth()));
    if (rowReset(value != standard, usual)) {
        value = standard;
        changed = true;
    }
    ImGui::PopID();
    return changed;
}

bool editField(const core::Field& field, uint32_t& value, uint32_t standard,
               const FieldOptions& options)
{
    const std::string usual = std::to_string(standard);
    ImGui::PushID(field.name);
    rowLabel(fieldLabel(field).c_str(), fieldTip(field, usual, options.onCommandLine),
             core::biases(field, value, standard));
    bool changed;
    if (field.range.low < field.range.high) {
        changed = wholeSlider(field.range, value, fieldPattern(field, "%u", options));
    } else {
        const uint32_t step = 1, fast = 100;
        changed = ImGui::InputScalar("##value", ImGuiDataType_U32, &value, &step, &fast, "%u");
    }
    tip(fieldTip(field, usual, options.onCommandLine));
    if (rowReset(value != standard, usual)) {
        value = standard;
        changed = true;
    }
    ImGui::PopID();
    return changed;
}

bool editField(const core::Field& field, float& value, float standard, const FieldOptions& options)
{
    const std::string usual = format("%g", static_cast<double>(standard));
    ImGui::PushID(field.name);
    rowLabel(fieldLabel(field).c_str(), fieldTip(field, usual, options.onCommandLine),
             core::biases(field, value, standard));
    bool changed;
    if (field.range.low < field.range.high) {
        const auto low = static_cast<float>(field.range.low),
                   high = static_cast<float>(field.range.high);
        ImGuiSliderFlags flags = ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoRoundToFormat;
        if (field.range.logarithmic) flags |= ImGuiSliderFlags_Logarithmic;
        changed = ImGui::SliderFloat("##value", &value, low, high,
                                     fieldPattern(field, "%.4g", options).c_str(), flags);
    } else {
        changed = ImGui::InputFloat("##value", &value, 0, 0, "%.6g");
    }
    if (!std::isfinite(value)) value = standard;
    tip(fieldTip(field, usual, options.onCommandLine));
    if (rowReset(value != standard, usual)) {
        value = standard;
        changed = true;
    }
    ImGui::PopID();
    return changed;
}

bool editChoice(const core::Field& field, uint32_t& value, uint32_t standard,
                std::span<const std::string_view> names, const FieldOptions& options)
{
    const std::string usual(names[standard]);
    ImGui::PushID(field.name);
    rowLabel(fieldLabel(field).c_str(), fieldTip(field, usual, options.onCommandLine),
             field.biased && value != standard && (field.harmless >> value & 1u) == 0);
    bool changed = false;
    const bool open = ImGui::BeginCombo("##value", std::string(names[value]).c_str(),
                                        ImGuiComboFlags_HeightLarge);
    if (open) {
        for (uint32_t i = 0; i < names.size(); ++i) {
            if (ImGui::Selectable(std::string(names[i]).c_str(), i == value) && i != value) {
                value = i;
                changed = true;
            }
            if (i == value) ImGui::SetItemDefaultFocus();
        }
        ImGui::EndCombo();
    }
    if (!open) tip(fieldTip(field, usual, options.onCommandLine));
    if (rowReset(value != standard, usual)) {
        value = standard;
        changed = true;
    }
    ImGui::PopID();
    return changed;
}

}  // namespace app
