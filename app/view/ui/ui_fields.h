// Widgets of one described field: a row of label, widget and reset arrow, with a tool-tip made from
// the description.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include <imgui.h>

#include "core/base/params.h"

namespace app {

// The few colours that carry a meaning; everything else is the style's.
inline const ImVec4 kWarningColour{0.98f, 0.75f, 0.33f, 1};
inline const ImVec4 kErrorColour{1.0f, 0.47f, 0.42f, 1};
inline const ImVec4 kGoodColour{0.55f, 0.82f, 0.58f, 1};

/// Whether a label has a line of its own above its field, in a row of that width: in narrow panels
/// all have, so that neither they nor what the fields say is cut.
bool labelStandsAbove(const char* label, float row);

/// The label of a row; what follows gets the rest of the line but for the reset arrow's place.
/// `help` is the tool-tip.
void rowLabel(const char* label, const std::string& help = {}, bool biased = false);

/// After the widget of a row: an arrow that is there when `differs`; true when it was clicked.
bool rowReset(bool differs, const std::string& standard);

/// Tool-tip of the last item, wrapped; also for disabled items.
void tip(const std::string& text);

/// "max-depth" -> "max depth".
std::string fieldLabel(const core::Field& field);

/// Help, range, default and the name on the command line; says whether it biases.
std::string fieldTip(const core::Field& field, const std::string& standard, bool onCommandLine);

/// The unit of the field of that name, as it stands behind its number.
struct FieldUnit {
    std::string_view field, unit;
};

/// What the next rows of fields are.
struct FieldOptions {
    bool onCommandLine = true;
    std::span<const FieldUnit> units{};  // of numbers that a slider shows; without one: plain
};

/// How a slider writes the number: `pattern` with the field's unit behind it.
std::string fieldPattern(const core::Field& field, const char* pattern,
                         const FieldOptions& options);

// One widget each; true when the value changed. `standard` is the default.
bool editField(const core::Field& field, bool& value, bool standard, const FieldOptions& options);
bool editField(const core::Field& field, uint32_t& value, uint32_t standard,
               const FieldOptions& options);
bool editField(const core::Field& field, float& value, float standard, const FieldOptions& options);
bool editChoice(const core::Field& field, uint32_t& value, uint32_t standard,
                std::span<const std::string_view> names, const FieldOptions& options);

}  // namespace app
